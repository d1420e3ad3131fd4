// ITK's readers for the page, unpacked: the package's own decoder is loaded by a data address, which the page's policy refuses.
import { copyFileSync, readFileSync, writeFileSync } from 'node:fs';
import { ZSTDDecoder } from '@thewtex/zstddec';

const readers = {
  '@itk-wasm/image-io': ['nrrd-read-image', 'nifti-read-image', 'meta-read-image'],
  '@itk-wasm/dicom': ['read-image-dicom-file-series', 'read-dicom-tags'],
};

const out = process.argv[2];
const decoder = new ZSTDDecoder();
await decoder.init();
for (const [home, names] of Object.entries(readers)) {
  for (const name of names) {
    const from = new URL(`node_modules/${home}/dist/pipelines/${name}`, import.meta.url).pathname;
    copyFileSync(`${from}.js`, `${out}/${name}.js`);
    writeFileSync(`${out}/${name}.wasm`, decoder.decode(readFileSync(`${from}.wasm.zst`)));
  }
}
