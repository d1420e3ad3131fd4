// A field on a grid, as the Worker sampled it, in the hand frame.

import { beyond, combined, dot, inverted, map_direction, map_of_grid, map_point, norm, normalized } from './geometry';
import type { FromWorker, Vec3 } from './protocol';

export type FieldMessage = Extract<FromWorker, { kind: 'field' }>;

/** Where a ray meets a surface. */
export interface SurfacePoint {
  at_m: Vec3;
  into: Vec3; // unit normal, on the side that the ray enters
}

export class SampledField {
  readonly name: string;
  readonly unit: string;
  readonly dims: Vec3;
  /** Values; of vectors their magnitude. */
  readonly values: Float32Array;
  /** Three numbers a voxel along the world's axes; null for scalars. */
  readonly vectors: Float32Array | null;
  readonly index_to_world: number[];
  readonly index_to_hand: number[];
  private readonly hand_to_index: number[];
  private readonly world_to_hand: number[];
  /** [1] length in the world of a unit of the hand frame. */
  readonly world_per_hand: number;

  constructor(message: FieldMessage, hand_to_world: number[]) {
    this.name = message.field;
    this.unit = message.unit;
    this.dims = message.dims;
    const count = message.dims[0] * message.dims[1] * message.dims[2];
    this.vectors = message.values.length >= 3 * count && count > 0 ? message.values : null;
    this.values = this.vectors ? magnitudes(this.vectors, count) : message.values;
    this.index_to_world = map_of_grid(message.origin_m, message.axes_m);
    this.world_to_hand = inverted(hand_to_world);
    this.world_per_hand = norm(map_direction(hand_to_world, [1, 0, 0]));
    this.index_to_hand = combined(this.world_to_hand, this.index_to_world);
    this.hand_to_index = inverted(this.index_to_hand);
  }

  index_of(at_m: Vec3): Vec3 {
    return map_point(this.hand_to_index, at_m);
  }

  position_of(index: Vec3): Vec3 {
    return map_point(this.index_to_hand, index);
  }

  has_index([i, j, k]: Vec3): boolean {
    const [a, b, c] = this.dims;
    return i >= 0 && j >= 0 && k >= 0 && i <= a - 1 && j <= b - 1 && k <= c - 1;
  }

  /** Trilinear value at fractional indices; NaN outside. */
  at_index(index: Vec3): number {
    if (!this.has_index(index)) return NaN;
    return this.interpolate(this.values, index, 1, 0);
  }

  /** Vector of the hand frame at a position; null outside, or for scalars. */
  vector_at(at_m: Vec3): Vec3 | null {
    const index = this.index_of(at_m);
    if (!this.vectors || !this.has_index(index)) return null;
    const of = (c: number) => this.interpolate(this.vectors!, index, 3, c);
    return map_direction(this.world_to_hand, [of(0), of(1), of(2)]);
  }

  /** First crossing of one of the levels on a ray from a position in front of all data. */
  first_crossing(from_m: Vec3, towards: Vec3, levels: number[]): SurfacePoint | null {
    if (levels.length === 0) return null;
    const from = this.index_of(from_m);
    const way = map_direction(this.hand_to_index, towards); // [voxels per metre]
    const span = this.span_inside(from, way);
    if (!span) return null;
    const step_m = 0.5 / Math.max(norm(way), 1e-9); // half a voxel
    const value_at = (s: number) => this.at_index(beyond(from, s, way));
    let last = value_at(span[0]);
    for (let s = span[0] + step_m; s <= span[1]; s += step_m) {
      const value = value_at(s);
      const level = levels.find((one) => (last < one && value >= one) || (last >= one && value < one));
      if (level !== undefined) return this.surface_point(from_m, towards, value_at, level, s - step_m, s);
      if (!Number.isNaN(value)) last = value;
    }
    return null;
  }

  private surface_point(
    from_m: Vec3, towards: Vec3, value_at: (s: number) => number, level: number, low: number, high: number,
  ): SurfacePoint {
    const begins_below = value_at(low) < level;
    for (let halving = 0; halving < 12; ++halving) {
      const middle = 0.5 * (low + high);
      if (value_at(middle) < level === begins_below) low = middle;
      else high = middle;
    }
    const at_m = beyond(from_m, 0.5 * (low + high), towards);
    const normal = this.normal_at(at_m);
    const into: Vec3 = norm(normal) === 0 ? towards : dot(normal, towards) < 0 ? [-normal[0], -normal[1], -normal[2]] : normal;
    return { at_m, into };
  }

  /** Unit vector along the gradient, hand frame; zero without one. */
  private normal_at(at_m: Vec3): Vec3 {
    const index = this.index_of(at_m);
    const slope: Vec3 = [0, 0, 0];
    for (let axis = 0; axis < 3; ++axis) {
      const before: Vec3 = [...index], after: Vec3 = [...index];
      before[axis] -= 1;
      after[axis] += 1;
      const difference = this.at_index(after) - this.at_index(before);
      slope[axis] = Number.isFinite(difference) ? difference : 0;
    }
    // A gradient changes by the transposed inverse of the map of positions.
    const m = this.hand_to_index;
    return normalized([
      m[0] * slope[0] + m[4] * slope[1] + m[8] * slope[2],
      m[1] * slope[0] + m[5] * slope[1] + m[9] * slope[2],
      m[2] * slope[0] + m[6] * slope[1] + m[10] * slope[2],
    ]);
  }

  /** Part of a ray inside the grid. */
  private span_inside(from: Vec3, way: Vec3): [number, number] | null {
    let first = 0, last = Infinity;
    for (let axis = 0; axis < 3; ++axis) {
      const end = this.dims[axis] - 1;
      if (Math.abs(way[axis]) < 1e-12) {
        if (from[axis] < 0 || from[axis] > end) return null;
        continue;
      }
      const a = -from[axis] / way[axis], b = (end - from[axis]) / way[axis];
      first = Math.max(first, Math.min(a, b));
      last = Math.min(last, Math.max(a, b));
    }
    return first < last && Number.isFinite(last) ? [first + 1e-9, last - 1e-9] : null;
  }

  private interpolate(numbers: Float32Array, [x, y, z]: Vec3, stride: number, offset: number): number {
    const [a, b, c] = this.dims;
    const i = Math.min(Math.floor(x), Math.max(0, a - 2)), j = Math.min(Math.floor(y), Math.max(0, b - 2));
    const k = Math.min(Math.floor(z), Math.max(0, c - 2));
    const u = x - i, v = y - j, w = z - k;
    const di = a > 1 ? stride : 0, dj = b > 1 ? stride * a : 0, dk = c > 1 ? stride * a * b : 0;
    const q = stride * (i + a * (j + b * k)) + offset;
    const row = (at: number) => numbers[at] + u * (numbers[at + di] - numbers[at]);
    const plane = (at: number) => row(at) + v * (row(at + dj) - row(at));
    return plane(q) + w * (plane(q + dk) - plane(q));
  }
}

function magnitudes(vectors: Float32Array, count: number): Float32Array {
  const values = new Float32Array(count);
  for (let n = 0; n < count; ++n) values[n] = Math.hypot(vectors[3 * n], vectors[3 * n + 1], vectors[3 * n + 2]);
  return values;
}
