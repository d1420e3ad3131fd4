// Ticks and device of a trace.
import { readFileSync } from 'node:fs';
import path from 'node:path';

/** Columns of a file of the trace, numbers where they are numbers. */
export function ticks_of(folder, file = 'ticks.csv') {
  const [head, ...lines] = readFileSync(path.join(folder, file), 'utf8').trim().split('\n');
  const names = head.split(',');
  return lines.map((line) => Object.fromEntries(line.split(',').map((text, i) => [names[i], Number.isNaN(Number(text)) ? text : Number(text)])));
}

/** Limits of the device in trace.toml, by name. */
export function device_of(folder) {
  const text = readFileSync(path.join(folder, 'trace.toml'), 'utf8');
  const numbers = text.split('[device]')[1].matchAll(/^(\w+) = ([-+.\deE]+)$/gm);
  return Object.fromEntries([...numbers].map(([, name, value]) => [name, Number(value)]));
}
