// Lines along a vector field, by Runge and Kutta's fourth order in equal steps of way.

import { magnitude_bytes } from './colors';
import { beyond, norm, normalized } from './geometry';
import type { Vec3 } from './protocol';
import type { SampledField } from './sampled_field';

export interface Streamline {
  points_m: Vec3[];
  colors: [number, number, number][];
}

const starts = 60; // lines at most
const steps = 120; // of a line, each way
const least_share = 0.12; // of the largest magnitude. More: lines end early; less: lines in noise

export function streamlines(field: SampledField, most: number): Streamline[] {
  if (!field.vectors || !(most > 0)) return [];
  const step_m = 0.8 * shortest_axis_m(field);
  return seeds(field, most)
    .map((seed) => {
      const back = way_from(field, seed, -step_m, most).reverse();
      return colored(field, [...back, seed, ...way_from(field, seed, step_m, most)], most);
    })
    .filter((line) => line.points_m.length > 8);
}

function shortest_axis_m(field: SampledField): number {
  const m = field.index_to_hand;
  return Math.min(...[0, 1, 2].map((c) => Math.hypot(m[c], m[4 + c], m[8 + c])));
}

/** Voxels in a fixed pseudo-random order, those with much flow. */
function seeds(field: SampledField, most: number): Vec3[] {
  const [a, b] = field.dims, found: Vec3[] = [];
  const count = field.values.length;
  let state = 12345;
  for (let tries = 0; tries < 40000 && found.length < starts; ++tries) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    const n = state % count;
    // Fast places first, slow ones in proportion.
    if (field.values[n] < most * Math.max(2 * least_share, 0.75 * (1 - tries / 40000))) continue;
    found.push(field.position_of([n % a, Math.floor(n / a) % b, Math.floor(n / (a * b))]));
  }
  return found;
}

function way_from(field: SampledField, from_m: Vec3, step_m: number, most: number): Vec3[] {
  const way: Vec3[] = [];
  let at_m = from_m;
  for (let n = 0; n < steps; ++n) {
    const next_m = after_step(field, at_m, step_m, most);
    if (!next_m) break;
    way.push(next_m);
    at_m = next_m;
  }
  return way;
}

function after_step(field: SampledField, at_m: Vec3, step_m: number, most: number): Vec3 | null {
  const { world_per_hand } = field; // lengths of vectors are those of the world
  const direction = (p_m: Vec3) => {
    const v = field.vector_at(p_m);
    return v && norm(v) * world_per_hand > least_share * most ? normalized(v) : null;
  };
  const k1 = direction(at_m);
  const k2 = k1 && direction(beyond(at_m, 0.5 * step_m, k1));
  const k3 = k2 && direction(beyond(at_m, 0.5 * step_m, k2));
  const k4 = k3 && direction(beyond(at_m, step_m, k3));
  if (!k1 || !k2 || !k3 || !k4) return null;
  const mean = [0, 1, 2].map((c) => (k1[c] + 2 * k2[c] + 2 * k3[c] + k4[c]) / 6) as Vec3;
  return beyond(at_m, step_m, mean);
}

function colored(field: SampledField, points_m: Vec3[], most: number): Streamline {
  return { points_m, colors: points_m.map((at_m) => magnitude_bytes(field.at_index(field.index_of(at_m)) / most)) };
}
