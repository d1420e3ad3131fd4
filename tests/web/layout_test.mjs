// Structs of the page's module: sizes and places as the compiler has them.
import { spawnSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import path from 'node:path';

import { root, skip } from './browser.mjs';
import { sources } from './module.mjs';

const file = path.join(path.dirname(process.env.PALPA_WASM ?? path.join(root, 'build/wasm/palpa.wasm')), 'layout.wasm');
if (!existsSync(file)) skip(`${file} is not there; tools/make-web makes it`);
const run = `import { readFileSync } from 'node:fs'; import { WASI } from 'node:wasi';
const wasi = new WASI({ version: 'preview1', returnOnExit: true });
wasi.start(await WebAssembly.instantiate(await WebAssembly.compile(readFileSync(process.argv[1])), wasi.getImportObject()));`;
const printed = spawnSync(process.execPath, ['--no-warnings', '--input-type=module', '-e', run, file], { encoding: 'utf8' }).stdout;
const page = await sources('layout');

let failed = 0;
const expect = (holds, what) => {
  if (!holds) console.log(`FAIL  ${what}`), ++failed;
};
const structs = new Map();
for (const line of printed.trim().split('\n')) {
  const [name, ...numbers] = line.trim().split(' ');
  if (line.startsWith('  ')) [...structs.values()].at(-1).places.set(name, Number(numbers[0]));
  else structs.set(name, { size: Number(numbers[0]), places: new Map() });
}
for (const [name, layout] of Object.entries(page)) {
  if (!name.endsWith('_layout')) continue;
  const struct = structs.get(`palpa_${name.replace('_layout', '')}`);
  expect(struct, `${name}: no struct of palpa/c.h`);
  if (!struct) continue;
  expect(layout.size === struct.size, `${name}: ${layout.size} bytes against ${struct.size}`);
  expect(layout.names.length === struct.places.size, `${name}: ${layout.names.length} fields against ${struct.places.size}`);
  for (const [field, at] of struct.places) expect(layout.names.includes(field) && layout.at(field) === at, `${name}.${field} is not at ${at}`);
}
console.log(`${structs.size - 1} structs compared, ${failed} differ`);
process.exit(failed || structs.size < 5 ? 1 : 0);
