// Facts of a file in lines, with the numbers of `palpa info`.

import type { Vec3 } from './protocol';

/** As palpa_files_facts writes them. */
export interface FileFacts {
  format: string;
  modality: string;
  length_unit: string;
  length_unit_assumed: boolean;
  grid: { dims: Vec3; spacing_m: Vec3; size_m: Vec3; axes: string };
  fields: { name: string; unit: string; type: string; components: number; min: number; max: number; median: number; mean: number }[];
}

/** Four digits, or as many as stand before the point. */
export function rounded(value: number): string {
  const digits = Math.max(4, Math.ceil(Math.log10(Math.abs(value) + 1)));
  return String(Number(value.toPrecision(Math.min(digits, 21))));
}

const in_mm = (lengths_m: Vec3) => lengths_m.map((length_m) => `${rounded(1e3 * length_m)} mm`).join(' × ');

export function facts_words(facts: FileFacts): string {
  const { grid } = facts;
  const assumed = facts.length_unit_assumed ? ", if the file's lengths are in mm" : '';
  const lines = [
    `format    ${facts.format}${facts.modality ? `, ${facts.modality}` : ''}`,
    `grid      ${grid.dims.join(' × ')} voxels of ${in_mm(grid.spacing_m)}`,
    `size      ${in_mm(grid.size_m)}${assumed}`,
    `axes      ${grid.axes}`,
  ];
  for (const field of facts.fields) {
    const unit = field.unit ? ` ${field.unit}` : '';
    const kind = field.components > 1 ? `${field.type} × ${field.components}` : field.type;
    lines.push(
      `${field.name.padEnd(8)}  ${kind}, ${rounded(field.min)} to ${rounded(field.max)}${unit}, ` +
        `median ${rounded(field.median)}, mean ${rounded(field.mean)}`,
    );
  }
  return lines.join('\n');
}
