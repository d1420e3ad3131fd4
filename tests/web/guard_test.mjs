// Campaign of the guard in wasm: 10⁶ ticks, no promise broken.
import { existsSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { WASI } from 'node:wasi';

import { root, skip } from './browser.mjs';

const file = path.join(path.dirname(process.env.PALPA_WASM ?? path.join(root, 'build/wasm/palpa.wasm')), 'guard_campaign.wasm');
if (!existsSync(file)) skip(`${file} is not there; tools/make-web makes it`);
const wasi = new WASI({ version: 'preview1', args: ['guard_campaign', process.argv[2] ?? '1', process.argv[3] ?? '1000000'], returnOnExit: true });
const instance = await WebAssembly.instantiate(await WebAssembly.compile(readFileSync(file)), wasi.getImportObject());
process.exitCode = wasi.start(instance);
