// Files that are dropped on the page: read, felt, with the facts of `palpa info`; wrong ones end in one line.
//
// node tests/web/files_test.mjs; PALPA_SHARED: folder of the data; others as in page_test.mjs. Exit code 77: skipped.
import { execFileSync } from 'node:child_process';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { check, page_folder, root, run_cases, start_browser, start_server, Visit } from './browser.mjs';

const palpa = process.env.PALPA ?? path.join(root, 'build/release/bin/palpa');
const of_shared = path.join(process.env.PALPA_SHARED ?? '', 'data');
const data = process.env.PALPA_SHARED && existsSync(of_shared) ? of_shared : '';

const folder = page_folder();
const server = await start_server(folder);
const browser = await start_browser();
const one = await Visit.begin(browser, server.address);
await one.is_felt();

/** Drops files, as a file manager does. \param files  name and bytes */
async function drop(files) {
  await one.page.evaluate(() => {
    document.getElementById('facts').textContent = '';
    document.getElementById('said').hidden = true;
  });
  const packed = files.map(({ name, bytes }) => ({ name, text: bytes.toString('base64') }));
  await one.page.evaluate((all) => {
    const drop = new DataTransfer();
    for (const { name, text } of all) drop.items.add(new File([Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))], name));
    window.dispatchEvent(new DragEvent('drop', { dataTransfer: drop, bubbles: true, cancelable: true }));
  }, packed);
  await one.page.waitForFunction(() => document.getElementById('busy').hidden &&
    (document.getElementById('facts').textContent !== '' || !document.getElementById('said').hidden), null, { timeout: 60000 });
  await one.page.waitForTimeout(300);
}

const file = (name) => ({ name: path.basename(name), bytes: readFileSync(path.join(data, name)) });

/** Numbers of a text, as they are written. */
const numbers_of = (text) => (text ?? '').match(/-?\d+(\.\d+)?(e-?\d+)?/g)?.map(Number) ?? [];

/** Facts on the page beside those of the native program: sizes, axes, type and range of the values. */
async function same_facts(native_path) {
  if (!existsSync(palpa)) return console.log(`      facts not compared: ${palpa} is not there`);
  const run = (...words) => execFileSync(palpa, ['info', path.join(data, native_path), ...words], { encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] });
  const native = JSON.parse(run('--json')), text = await one.text('#facts');
  const line = (word) => text.split('\n').find((each) => each.startsWith(word + ' ')) ?? '';
  const words = run().split('\n').map((each) => each.trim());
  for (const word of ['grid', 'size']) {
    const here = numbers_of(line(word)), there = numbers_of(words.find((each) => each.startsWith(word + ' '))).slice(0, here.length);
    check(here.length >= 3 && here.join() === there.join(), `${line(word)}${here.join() === there.join() ? '' : `; palpa info: ${there}`}`);
  }
  const letters = words.find((each) => each.startsWith('axes'))?.match(/: ([RLAPSI]{3})/)?.[1] ?? '+x +y +z';
  check(line('axes').includes(letters), `${line('axes')}; palpa info: ${letters}`);
  const field = native.fields[0];
  const said = line(field.name);
  check(said.includes(`${field.type},`), `${said}; palpa info: ${field.type}`);
  const [low, high] = numbers_of(said.replace(field.type, ''));
  const near = (a, b) => Math.abs(a - b) <= 6e-4 * Math.max(Math.abs(a), Math.abs(b));
  check(near(low, field.min) && near(high, field.max), `${low} to ${high}; palpa info: ${field.min} to ${field.max}`);
}

async function felt(name) {
  await one.page.waitForTimeout(1500);
  await one.is_felt();
  let most_n = 0;
  try {
    most_n = await one.press(await one.surface(), 5);
    await one.picture('file-' + name);
    await one.page.mouse.up();
  } catch (error) {
    check(false, `${name}: ${error.message}`);
  }
  check(most_n > 0.02, `${name} is felt: ${most_n} N`);
}

function opened(name, files, native_path) {
  return async () => {
    if (!data) return console.log('      skipped: PALPA_SHARED names no data');
    await drop(files());
    check(!(await one.page.isVisible('#said')) || (await one.text('#facts')) !== '', `${name}: ${await one.text('#said-words')}`);
    await same_facts(native_path);
    await felt(name);
  };
}

const series = 'ct_headphantom_dicom';
const cases = {
  'NRRD': opened('nrrd', () => [file('mri_flair_nrrd/FLAIR.nrrd')], 'mri_flair_nrrd/FLAIR.nrrd'),
  'NIfTI': opened('nifti', () => [file('mri_avg152_bigendian/avg152T1_RL_nifti.nii.gz')], 'mri_avg152_bigendian/avg152T1_RL_nifti.nii.gz'),
  'NIfTI with axes in another order and a scale': opened('nifti-ail', () => [file('nifti_orientations/AIL.nii.gz')], 'nifti_orientations/AIL.nii.gz'),
  'MetaImage with its data file': opened('meta', () => [file('ct_head_cranium/cranium.mhd'), file('ct_head_cranium/cranium.raw.gz')], 'ct_head_cranium/cranium.mhd'),
  'MetaImage in one file': opened('mha', () => [file('mri_mha_zlib/mha.mha')], 'mri_mha_zlib/mha.mha'),
  'DICOM series': opened('dicom', () => readdirSync(path.join(data, series)).map((name) => file(path.join(series, name))), series),

  'wrong files end in one line': async () => {
    const wrong = {
      'nonsense.nrrd': [Buffer.from('NRRD0004\ntype: float\nsizes: 9999 9999 9999\n\n'), /MB of voxels/],
      'cut.nii': [Buffer.alloc(100), /shorter than a NIfTI header/],
      'bare.mhd': [Buffer.from('NDims = 3\nElementDataFile = gone.raw\n'), /needs its data file 'gone.raw'/],
      'picture.gif': [Buffer.from('GIF89a'), /no format that this page reads/],
      'empty.mha': [Buffer.alloc(0), /no MetaImage|empty/],
      'loud<img src=x onerror=document.title="taken">.nrrd': [Buffer.from('<script>document.title="taken"</script>'), /<img src=x/],
    };
    for (const [name, [bytes, words]] of Object.entries(wrong)) {
      await drop([{ name, bytes }]);
      const said = await one.text('#said-words');
      check(words.test(said) && !said.includes('\n'), `${name}: ${said}`);
    }
    check((await one.page.title()) !== 'taken' && (await one.page.locator('#said img').count()) === 0, 'a name never becomes markup');
  },

  'a name with markup is text': async () => {
    const header = 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nencoding: raw\n\n';
    const voxels = Buffer.alloc(24 ** 3);
    for (let n = 0; n < voxels.length; ++n) voxels[n] = Math.hypot((n % 24) - 12, (Math.floor(n / 24) % 24) - 12, Math.floor(n / 576) - 12) < 8 ? 200 : 10;
    await drop([{ name: '<img src=x onerror=document.title="taken">.nrrd', bytes: Buffer.concat([Buffer.from(header), voxels]) }]);
    check((await one.text('#facts')).includes('24 × 24 × 24'), 'the ball is read');
    check((await one.page.title()) !== 'taken' && (await one.page.locator('#panel img, #top img').count()) === 0, 'its name is text');
    await felt('ball');
  },

  'nothing left the machine': async () => {
    check(one.foreign.length === 0, `no foreign request ${one.foreign.join(' ')}`);
    check(one.complaints.length === 0, `no complaint of the browser ${one.complaints.join(' | ')}`);
  },
};

const code = await run_cases(cases);
await browser.close();
server.end();
process.exit(code);
