// Laws of the page's parts, without a browser. Exit code 77: skipped.
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { tmpdir } from 'node:os';
import { check, root, run_cases, skip } from './browser.mjs';

if (!existsSync(path.join(root, 'web/node_modules/esbuild'))) skip('web/node_modules is not there; tools/make-web makes it');
const { build } = createRequire(path.join(root, 'web/package.json'))('esbuild');
const work = mkdtempSync(path.join(tmpdir(), 'palpa-parts-'));
const names = ['camera', 'geometry', 'hand', 'headers', 'sampled_field', 'share', 'streamlines'];
await build({
  entryPoints: names.map((name) => path.join(root, 'web/src', `${name}.ts`)),
  bundle: true, splitting: true, format: 'esm', outdir: work, outExtension: { '.js': '.mjs' }, logLevel: 'error',
});
const parts = {};
for (const name of names) Object.assign(parts, await import(pathToFileURL(path.join(work, `${name}.mjs`))));
const { Camera, Hand, SampledField, address_of, scene_of, combined, inverted, map_of_grid, map_point, norm, dot, minus } = parts;

let state = 7;
const random = () => ((state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32);
const vector = () => [random() - 0.5, random() - 0.5, random() - 0.5];
const near = (a, b, within) => norm(minus(a, b)) < within;

/** Distance from the middle of a ball, on a sheared grid of a scaled hand. */
function ball(turn) {
  const n = 40, axes = [[0.004, 0.0005, 0], [0, 0.004, 0.0003], [0.0002, 0, 0.004]];
  const map = map_of_grid([-0.08, -0.08, -0.08], axes);
  const values = new Float32Array(n ** 3);
  for (let q = 0; q < values.length; ++q) values[q] = norm(map_point(map, [q % n, Math.floor(q / n) % n, Math.floor(q / n / n)]));
  return new SampledField({ kind: 'field', field: 'v.value', unit: '', dims: [n, n, n], origin_m: [-0.08, -0.08, -0.08], axes_m: axes, values }, turn);
}

const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const doubled = [0, -2, 0, 0, 2, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]; // a quarter turn, and twice as large

const cases = {
  'an inverse map undoes its map': () => {
    let most = 0;
    for (let n = 0; n < 200; ++n) {
      const map = [...vector(), random(), ...vector(), random(), ...vector(), random(), 0, 0, 0, 1];
      const p = vector(), there = map_point(map, p), back = map_point(inverted(map), there);
      const volume = Math.abs(dot([map[0], map[4], map[8]], parts.cross([map[1], map[5], map[9]], [map[2], map[6], map[10]])));
      if (volume > 1e-3) most = Math.max(most, norm(minus(back, p)), norm(minus(map_point(combined(inverted(map), map), p), p)));
    }
    check(most < 1e-9, `to ${most}`);
  },

  'the view turns rigidly, and a pixel is where it is drawn': () => {
    const camera = new Camera();
    [camera.width_px, camera.height_px] = [800, 600];
    let most = 0;
    for (let n = 0; n < 500; ++n) {
      camera.turn(90 * (random() - 0.5), 90 * (random() - 0.5));
      const { right, up, towards } = camera;
      for (const error of [norm(right) - 1, norm(up) - 1, norm(towards) - 1, dot(right, up), dot(up, towards), dot(right, towards)])
        most = Math.max(most, Math.abs(error));
      const at = camera.at_m(120, 340);
      most = Math.max(most, Math.abs(camera.x_px(at) - 120) / 1e3, Math.abs(camera.y_px(at) - 340) / 1e3);
    }
    check(most < 1e-9, `to ${most}`);
    check(camera.up[1] > 0, 'up stays up');
    const m = camera.rotation();
    check(near([m[0], m[3], m[6]], camera.right, 1e-12), 'a push to the right of a device moves to the right of the screen');
  },

  'a ray meets the ball where it is': () => {
    for (const [words, map, size] of [['hand as the world', identity, 1], ['hand turned and half as large', doubled, 0.5]]) {
      const field = ball(map);
      let most = 0, most_turn = 0;
      for (let n = 0; n < 100; ++n) {
        const towards = parts.normalized(vector());
        const from = parts.beyond([0, 0, 0], -1, towards);
        const met = field.first_crossing(from, towards, [0.05, 0.03]);
        most = Math.max(most, met ? Math.abs(norm(met.at_m) - 0.05 * size) : 1);
        if (met) most_turn = Math.max(most_turn, Math.abs(1 - Math.abs(dot(met.into, towards))));
      }
      check(most < 1e-4, `${words}: to ${(1e6 * most).toFixed(0)} µm`);
      check(most_turn < 0.01, `${words}: along the normal`);
      check(field.first_crossing([0.2, 0.2, 1], [0, 0, -1], [0.05]) === null, `${words}: a ray beside it meets nothing`);
    }
  },

  'a led hand goes no faster than a push': () => {
    const sent = [];
    const camera = new Camera();
    [camera.width_px, camera.height_px, camera.half_height_m] = [800, 600, 0.1];
    const hand = new Hand(camera, (message) => sent.push(message));
    hand.begin_scene(0.2);
    hand.surfaces = [{ field: ball(identity), levels: [0.05] }];
    hand.is_ready = true;
    check(!hand.begin(2, 2), 'beside the ball nothing is touched');
    check(hand.begin(400, 300), 'the middle of the picture is touched');
    const put = sent.filter((message) => message.kind === 'put').at(-1);
    check(put && norm(put.position_m) > 0.0505, 'from in front of the surface');
    const way = [...put.position_m];
    let fastest = 0;
    for (let n = 0; n < 60; ++n) {
      const before = sent.length;
      hand.beat(1 / 60);
      for (const message of sent.slice(before)) {
        fastest = Math.max(fastest, norm(message.way_m) * 60);
        for (let c = 0; c < 3; ++c) way[c] += message.way_m[c];
      }
    }
    check(fastest <= 0.5 + 1e-9, `at most 0.5 m/s: ${fastest}`);
    check(Math.abs(norm(way) - 0.049) < 2e-4, `the hand presses a millimetre deep: ${norm(way)} m from the middle`);
  },

  'an address gives its scene back': async () => {
    for (const text of ['', 'palpa = 1\n', 'title = "Häuser & <b>Größen</b> \u{1F600}"\n'.repeat(20)]) {
      const address = await address_of(text, 'http://127.0.0.1:1/#old');
      check((await scene_of(new URL(address).hash)) === text, `${text.length} characters in ${address.length}`);
    }
    check((await scene_of('#elsewhere')) === null, 'another fragment is no scene');
    let noise = '';
    for (let n = 0; n < 20000; ++n) noise += String.fromCharCode(32 + Math.floor(90 * random()));
    check(await address_of(noise, 'http://a/').then(() => false, (error) => /characters/.test(error.message)), 'too long: one line');
    const big = await address_of('a'.repeat(3 << 20), 'http://a/');
    check(await scene_of(new URL(big).hash).then(() => false, (error) => /megabyte/.test(error.message)), 'a small address of a large text: one line');
    for (const wrong of ['#scene=', '#scene=%', '#scene=AAAA', '#scene=' + 'zz'.repeat(50)])
      check(await scene_of(wrong).then((text) => text === '', (error) => /damaged/.test(error.message)), `${wrong.slice(0, 20)}: damaged`);
  },

  'headers say what they say': () => {
    const bytes = (text) => new TextEncoder().encode(text);
    const nrrd = parts.nrrd_facts(bytes('NRRD0004\ntype: unsigned short\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 5 6\n' +
      'space units: "um" "um" "um"\nsample units: "HU"\nmodality:=CT\ndata file: a.raw\n\nnonsense: 1\n'));
    check(nrrd.medical_frame && nrrd.length_unit === 'um' && nrrd.value_unit === 'HU' && nrrd.modality === 'CT', 'NRRD: frame, units, modality');
    check(nrrd.claimed_bytes === 240 && nrrd.data_files[0] === 'a.raw', 'NRRD: size, data file');
    const meta = parts.meta_facts(bytes('NDims = 3\nDimSize = 4 5 6\nElementType = MET_SHORT\nAnatomicalOrientation = RAI\nElementDataFile = LIST\na.raw\nb.raw\n'));
    check(meta.medical_frame && meta.claimed_bytes === 240 && meta.data_files.join() === 'a.raw,b.raw', 'MetaImage: frame, size, list');
    check(!parts.meta_facts(bytes('NDims = 3\nDimSize = 4 5 6\nElementDataFile = LOCAL\n')).medical_frame, 'MetaImage: no frame without its name');
    let thrown = 0;
    for (let n = 0; n < 3000; ++n) {
      const noise = Uint8Array.from({ length: Math.floor(700 * random()) }, () => 256 * random());
      for (const read of [parts.nrrd_facts, parts.meta_facts, parts.nifti_facts])
        try {
          read(noise);
        } catch (error) {
          if (error.message.includes('\n')) throw error;
          ++thrown;
        }
    }
    check(thrown > 8000, 'noise ends in one line');
  },
};

const code = await run_cases(cases);
rmSync(work, { recursive: true });
process.exit(code);
