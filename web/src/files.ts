// Files that a person drops or chooses: which belong together, and who reads them.

import type { FileAnswer, FileRequest } from './file_worker';
import { meta_facts, nrrd_facts } from './headers';

/** Scene texts and volumes of one drop. */
export interface Dropped {
  scenes: File[];
  volumes: Volume[];
}

interface Volume {
  format: FileRequest['format'];
  name: string;
  files: File[]; // the named one first
}

const most_files = 4096;
const most_file_bytes = 1.5e9; // of all files of a volume. More: a tab's memory does not hold them

/** Files of a drop, also those in folders. Call it within the event. */
export async function files_of_drop(drop: DataTransfer): Promise<File[]> {
  const entries = [...drop.items].filter((item) => item.kind === 'file').map((item) => item.webkitGetAsEntry());
  const plain = [...drop.files];
  if (entries.length === 0 || entries.some((entry) => entry === null)) return plain;
  const found: File[] = [];
  for (const entry of entries) await collect(entry!, found);
  return found;
}

async function collect(entry: FileSystemEntry, found: File[]): Promise<void> {
  if (found.length >= most_files) throw new Error(`More than ${most_files} files; drop the folder of one series.`);
  if (entry.isFile) {
    found.push(await new Promise<File>((done, failed) => (entry as FileSystemFileEntry).file(done, failed)));
    return;
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  for (;;) {
    const part = await new Promise<FileSystemEntry[]>((done, failed) => reader.readEntries(done, failed));
    if (part.length === 0) return;
    for (const one of part) await collect(one, found);
  }
}

/** Sorts files into scenes and volumes. Throws an Error of one line if there is nothing to open. */
export async function sorted(files: File[]): Promise<Dropped> {
  const dropped: Dropped = { scenes: [], volumes: [] };
  const left = new Set(files.filter((file) => !file.name.startsWith('.')));
  const take = (file: File) => (left.delete(file), file);
  for (const file of [...left]) {
    const name = file.name.toLowerCase();
    if (name.endsWith('.toml')) dropped.scenes.push(take(file));
    else if (/\.(nrrd|nhdr)$/.test(name)) dropped.volumes.push(await with_data(take(file), 'nrrd', left));
    else if (/\.(mha|mhd)$/.test(name)) dropped.volumes.push(await with_data(take(file), 'metaimage', left));
    else if (/\.nii(\.gz)?$/.test(name)) dropped.volumes.push({ format: 'nifti', name: file.name, files: [take(file)] });
  }
  const slices: File[] = [];
  for (const file of left) if (await is_dicom(file)) slices.push(file);
  if (slices.length > 0) dropped.volumes.push({ format: 'dicom', name: name_of_series(slices), files: slices });
  if (dropped.scenes.length + dropped.volumes.length === 0) throw new Error(nothing_in(files));
  return dropped;
}

function nothing_in(files: File[]): string {
  const what = 'NRRD, NIfTI, MetaImage, a DICOM folder or a scene (.toml) can be opened here';
  return files.length === 1 ? `${files[0].name}: is of no format that this page reads; ${what}` : `Nothing to open; ${what}`;
}

/** Reads one volume in a Worker of its own, which ends with it. Throws an Error of one line. */
export async function read_volume(volume: Volume): Promise<Extract<FileAnswer, { file: object }>> {
  const size = volume.files.reduce((sum, file) => sum + file.size, 0);
  if (size > most_file_bytes) throw new Error(`${volume.name}: has ${Math.round(size / 1e6)} MB; a browser holds at most 1500 MB`);
  if (size === 0) throw new Error(`${volume.name}: is empty; get the whole file`);
  const files = await Promise.all(volume.files.map(async (file) => ({ name: file.name, bytes: await file.arrayBuffer() })));
  const request: FileRequest = { format: volume.format, name: volume.name, files };
  const worker = new Worker(new URL('file_worker.js', import.meta.url), { type: 'module' });
  try {
    const answer = await new Promise<FileAnswer>((done, failed) => {
      worker.onmessage = ({ data }: MessageEvent<FileAnswer>) => done(data);
      worker.onerror = () => failed(new Error(`${volume.name}: cannot be read; check that it is whole`));
      worker.postMessage(request, files.map((file) => file.bytes));
    });
    if ('problem' in answer) throw new Error(`${volume.name}: ${answer.problem}`);
    return answer;
  } finally {
    worker.terminate();
  }
}

/** A header with the data files that it names, which must be among the dropped. */
async function with_data(file: File, format: 'nrrd' | 'metaimage', left: Set<File>): Promise<Volume> {
  const start = new Uint8Array(await file.slice(0, 1 << 16).arrayBuffer());
  const files = [file];
  let named: string[] = [];
  try {
    named = (format === 'nrrd' ? nrrd_facts(start) : meta_facts(start)).data_files;
  } catch (problem) {
    throw new Error(`${file.name}: ${problem instanceof Error ? problem.message : 'cannot be read'}`);
  }
  for (const name of named) {
    const bare = name.replace(/^.*[\\/]/, '').trim();
    const found = [...left].find((one) => one.name === bare);
    if (!found) throw new Error(`${file.name}: needs its data file '${bare}'; drop both together`);
    left.delete(found);
    files.push(found);
  }
  return { format, name: file.name, files };
}

async function is_dicom(file: File): Promise<boolean> {
  if (file.name === 'DICOMDIR' || file.size < 132) return false;
  return new TextDecoder('latin1').decode(await file.slice(128, 132).arrayBuffer()) === 'DICM';
}

/** Name of the folder of a series, else of its first file. */
function name_of_series(slices: File[]): string {
  const folders = slices[0].webkitRelativePath.split('/');
  return folders.length > 1 ? folders[folders.length - 2] : slices.length === 1 ? slices[0].name : 'series';
}
