// The shipped scenes under simulated and recorded hands: every force of the module, in node and in Chromium, equals the native
// one to the bit.
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { page_folder, root, skip, start_browser, start_server } from './browser.mjs';
import { compiled, script, sources } from './module.mjs';
import { feel } from './same_ticks.mjs';
import { device_of, ticks_of } from './trace.mjs';

const shared = process.env.PALPA_SHARED ?? path.join(root, '../shared');
const palpa = process.env.PALPA ?? path.join(root, 'build/release/bin/palpa');
const given_files = process.env.PALPA_GIVEN_FILES ?? path.join(root, 'build/release/tests/given_files');
for (const program of [palpa, given_files]) if (!existsSync(program)) skip(`${program} is not there`);
const environment = { PALPA_READER: path.join(path.dirname(palpa), 'palpa-read'), ...process.env, PALPA_DATA: path.join(shared, 'data') };
const duration_s = process.env.PALPA_DURATION_S ?? '2';

const page = await sources('module', 'feeler', 'layout');
const module = await compiled();
const server = await start_server(page_folder());
const browser = await start_browser();
const recording = path.join(shared, 'data/trajectories/inverse3_woodcarving_20231121_102837.csv');
const hands = ['sim:stroke', ...(existsSync(recording) ? [recording] : [])];
const folder = mkdtempSync(path.join(tmpdir(), 'palpa-bits-'));
const spent_ms = { native: 0, node: 0, Chromium: 0 };
let failed = 0, left_out = 0, compared = 0, timed = 0;

/** `feel` in a page of Chromium; voxels go by the server's address. */
async function feel_in_page(felt) {
  const context = await browser.newContext({ bypassCSP: true });
  try {
    const tab = await context.newPage();
    const voxels = felt.files.flatMap((file) => file.fields.map((field) => Buffer.from(field.voxels)));
    await tab.route('**/given/*', (route) => route.fulfill({ body: voxels[Number(route.request().url().split('/').at(-1))] }));
    await tab.goto(server.address + 'licenses.txt'); // a page without scripts of its own
    await tab.addScriptTag({ content: await script('web/src/module.ts', 'web/src/feeler.ts', 'web/src/layout.ts', 'tests/web/same_ticks.mjs') });
    let number = 0;
    const files = felt.files.map((file) => ({ ...file, fields: file.fields.map((field) => ({ ...field, voxels: number++ })) }));
    return await tab.evaluate(async (given) => {
      const bytes = async (address) => (await fetch(address)).arrayBuffer();
      for (const file of given.files) for (const field of file.fields) field.voxels = await bytes(`/given/${field.voxels}`);
      return palpa_test.feel(palpa_test, await WebAssembly.compile(await bytes('/palpa.wasm')), given);
    }, { ...felt, files });
  } finally {
    await context.close();
  }
}

function files_of(scene) {
  const out = path.join(folder, 'files');
  const made = spawnSync(given_files, [scene, out], { env: environment, encoding: 'utf8' });
  if (made.status !== 0) throw new Error(made.stderr);
  return JSON.parse(readFileSync(path.join(out, 'files.json'), 'utf8')).map((file) => ({
    ...file, bytes: 0, sha256: '',
    fields: file.fields.map((field) => {
      const voxels = readFileSync(path.join(out, field.voxels));
      return { ...field, voxels: voxels.buffer.slice(voxels.byteOffset, voxels.byteOffset + voxels.length) };
    }),
  }));
}

/** Records the hand natively. */
function trace_of(scene, hand) {
  const trace = path.join(folder, 'trace');
  rmSync(trace, { recursive: true, force: true });
  execFileSync(palpa, ['run', scene, '--hand', hand, '--duration-s', duration_s, '--out', trace], { env: environment, stdio: 'ignore' });
  const native_ms = ticks_of(trace, 'timing.csv').reduce((sum, { tick_us }) => sum + tick_us / 1e3, 0);
  return { hand: path.basename(hand), device: device_of(trace), ticks: ticks_of(trace), native_ms };
}

async function compare(name) {
  const scene = path.join(root, 'scenes', name);
  const text = readFileSync(scene, 'utf8');
  const names = [...text.matchAll(/^file = "([^"]+)"/gm)].map((match) => match[1]);
  if (names.some((file) => !existsSync(path.join(shared, 'data', file)))) {
    console.log(`  left out: ${name}: its data are not there`);
    ++left_out;
    return;
  }
  const traces = hands.map((hand) => trace_of(scene, hand));
  const files = names.length > 0 ? files_of(scene).map((file, i) => ({ ...file, name: names[i] })) : [];
  // What is read and resampled natively is given as it is.
  const felt = { text: text.replace(/^crop_m = .*$/m, ''), files, traces, is_timed: name === 'head_phantom.toml' };
  for (const { ticks, native_ms } of traces) {
    compared += ticks.length;
    if (!felt.is_timed) continue;
    timed += ticks.length;
    spent_ms.native += native_ms;
  }
  for (const [where, result] of [['node', await feel(page, module, felt)], ['Chromium', await feel_in_page(felt)]]) {
    spent_ms[where] += result.time_ms;
    traces.forEach(({ hand, ticks }, n) => {
      const difference = result.differences[n];
      console.log(`${difference ? 'FAIL' : '  ok'}  ${name}, ${hand}, ${where}: ${difference || `${ticks.length} ticks are equal to the bit`}`);
      failed += difference ? 1 : 0;
    });
  }
}

try {
  const scenes = readdirSync(path.join(root, 'scenes')).filter((name) => name.endsWith('.toml'));
  for (const name of scenes.filter((one) => one.includes(process.argv[2] ?? ''))) await compare(name);
  const each = (where) => `${((1e3 * spent_ms[where]) / timed).toFixed(2)} us ${where}, ${(spent_ms[where] / spent_ms.native).toFixed(1)} times`;
  console.log(`${compared} ticks; ${left_out} left out; a tick of the head phantom: ${each('native')}, ${each('node')}, ${each('Chromium')}`);
} finally {
  await browser.close();
  server.end();
  rmSync(folder, { recursive: true, force: true });
}
process.exit(failed ? 1 : 0);
