// Vectors and affine maps. Maps have 16 numbers by row.

import type { Vec3 } from './protocol';

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const minus = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const times = (s: number, a: Vec3): Vec3 => [s * a[0], s * a[1], s * a[2]];
/** a + s b */
export const beyond = (a: Vec3, s: number, b: Vec3): Vec3 => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
export const norm = (a: Vec3): number => Math.hypot(a[0], a[1], a[2]);
export const distance = (a: Vec3, b: Vec3): number => norm(minus(a, b));
/** Unit vector; zero stays zero. */
export const normalized = (a: Vec3): Vec3 => {
  const length = norm(a);
  return length > 0 ? times(1 / length, a) : [0, 0, 0];
};
/** The vector, at most so long. */
export const shortened = (a: Vec3, most: number): Vec3 => {
  const length = norm(a);
  return length > most ? times(most / length, a) : a;
};
export const clamp = (x: number, low: number, high: number): number => Math.min(high, Math.max(low, x));

export function map_point(map: number[], p: Vec3): Vec3 {
  return [
    map[0] * p[0] + map[1] * p[1] + map[2] * p[2] + map[3],
    map[4] * p[0] + map[5] * p[1] + map[6] * p[2] + map[7],
    map[8] * p[0] + map[9] * p[1] + map[10] * p[2] + map[11],
  ];
}

export function map_direction(map: number[], d: Vec3): Vec3 {
  return [
    map[0] * d[0] + map[1] * d[1] + map[2] * d[2],
    map[4] * d[0] + map[5] * d[1] + map[6] * d[2],
    map[8] * d[0] + map[9] * d[1] + map[10] * d[2],
  ];
}

/** First b, then a. */
export function combined(a: number[], b: number[]): number[] {
  const map: number[] = [];
  for (let r = 0; r < 4; ++r)
    for (let c = 0; c < 4; ++c)
      map.push(a[4 * r] * b[c] + a[4 * r + 1] * b[4 + c] + a[4 * r + 2] * b[8 + c] + a[4 * r + 3] * b[12 + c]);
  return map;
}

/** Inverse of an affine map. */
export function inverted(m: number[]): number[] {
  const x: Vec3 = [m[0], m[4], m[8]], y: Vec3 = [m[1], m[5], m[9]], z: Vec3 = [m[2], m[6], m[10]];
  const volume = dot(x, cross(y, z));
  const rows = [times(1 / volume, cross(y, z)), times(1 / volume, cross(z, x)), times(1 / volume, cross(x, y))];
  const at: Vec3 = [m[3], m[7], m[11]];
  return [...rows.flatMap((row) => [...row, -dot(row, at)]), 0, 0, 0, 1];
}

/** Map of a grid's indices to the world. */
export function map_of_grid(origin_m: Vec3, axes_m: [Vec3, Vec3, Vec3]): number[] {
  const [x, y, z] = axes_m;
  return [x[0], y[0], z[0], origin_m[0], x[1], y[1], z[1], origin_m[1], x[2], y[2], z[2], origin_m[2], 0, 0, 0, 1];
}

/** Vector turned about a unit axis. */
export function turned(v: Vec3, axis: Vec3, angle_rad: number): Vec3 {
  const c = Math.cos(angle_rad), s = Math.sin(angle_rad);
  const part = add(times(c, v), times(s, cross(axis, v)));
  return beyond(part, (1 - c) * dot(axis, v), axis);
}
