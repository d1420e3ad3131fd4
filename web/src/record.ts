// A trace folder as one file to keep.

import { strToU8, zipSync, type Zippable } from 'fflate';

export interface TraceFile {
  name: string;
  bytes: Uint8Array;
}

/** Name with the local date and time: 'palpa-2026-11-30-221333'. */
export function trace_name(now: Date): string {
  const two = (n: number) => String(n).padStart(2, '0');
  const day = `${now.getFullYear()}-${two(now.getMonth() + 1)}-${two(now.getDate())}`;
  return `palpa-${day}-${two(now.getHours())}${two(now.getMinutes())}${two(now.getSeconds())}`;
}

export function save_trace(folder: string, files: TraceFile[]): void {
  const entries: Zippable = {};
  for (const { name, bytes } of files) entries[`${folder}/${name}`] = [bytes, { level: 6 }];
  save(`${folder}.zip`, zipSync(entries), 'application/zip');
}

export function save_scene(name: string, text: string): void {
  save(name, strToU8(text), 'text/plain');
}

function save(name: string, bytes: Uint8Array, type: string): void {
  const address = URL.createObjectURL(new Blob([bytes as Uint8Array<ArrayBuffer>], { type }));
  const link = document.createElement('a');
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}
