// The page's module in node: its TypeScript bundled, its wasm instantiated.
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

import { root, skip } from './browser.mjs';

/** Exports of some of the page's sources. */
export async function sources(...names) {
  const packages = path.join(root, 'web/node_modules');
  if (!existsSync(path.join(packages, 'esbuild'))) skip('web/node_modules is not there; tools/make-web makes it');
  const esbuild = createRequire(path.join(root, 'web/package.json'))('esbuild');
  const folder = mkdtempSync(path.join(tmpdir(), 'palpa-web-'));
  try {
    const outfile = path.join(folder, 'sources.mjs');
    const lines = names.map((name) => `export * from './src/${name}.ts';`).join('\n');
    await esbuild.build({ stdin: { contents: lines, resolveDir: path.join(root, 'web') }, bundle: true, platform: 'node', format: 'esm', outfile });
    return await import(pathToFileURL(outfile).href);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** The same exports as a script for a page, which has them as `palpa_test`. */
export async function script(...files) {
  const esbuild = createRequire(path.join(root, 'web/package.json'))('esbuild');
  const lines = files.map((file) => `export * from './${file}';`).join('\n');
  const made = await esbuild.build({
    stdin: { contents: lines, resolveDir: root }, bundle: true, format: 'iife', globalName: 'palpa_test', write: false,
    external: ['node:*'],
  });
  return made.outputFiles[0].text;
}

/** The compiled module, or the end of the test. */
export async function compiled() {
  const file = process.env.PALPA_WASM ?? path.join(root, 'build/wasm/palpa.wasm');
  if (!existsSync(file)) skip(`${file} is not there; tools/make-web makes it`);
  return WebAssembly.compile(readFileSync(file));
}
