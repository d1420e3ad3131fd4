// Parallel view of the hand frame, as in the native window: turns keep up upright.

import { add, beyond, clamp, cross, dot, normalized, times, turned } from './geometry';
import type { Vec3 } from './protocol';

/** Box in the hand frame. */
export interface Box {
  low_m: Vec3;
  high_m: Vec3;
}

const steepest_rad = 1.47; // of the line of sight. More: turns about it jump; less: the top is not seen
const from_front: Vec3 = [0.35, 0.25, 1.0];

export class Camera {
  centre_m: Vec3 = [0, 0, 0];
  right: Vec3 = [1, 0, 0];
  up: Vec3 = [0, 1, 0];
  towards: Vec3 = [0, 0, 1]; // the viewer
  half_height_m = 0.1;
  width_px = 1;
  height_px = 1;

  constructor() {
    this.look_from(from_front, [0, 1, 0]);
  }

  get px_per_m(): number {
    return (0.5 * this.height_px) / this.half_height_m;
  }

  x_px(at_m: Vec3): number {
    return 0.5 * this.width_px + this.px_per_m * this.along(at_m, this.right);
  }

  /** From the top. */
  y_px(at_m: Vec3): number {
    return 0.5 * this.height_px - this.px_per_m * this.along(at_m, this.up);
  }

  /** Position of a pixel on the plane through the view's centre. */
  at_m(x_px: number, y_px: number): Vec3 {
    const per_px = 1 / this.px_per_m;
    const across = beyond(this.centre_m, (x_px - 0.5 * this.width_px) * per_px, this.right);
    return beyond(across, (0.5 * this.height_px - y_px) * per_px, this.up);
  }

  /** Depth [m] behind the plane through the view's centre. */
  depth_m(at_m: Vec3): number {
    return -this.along(at_m, this.towards);
  }

  look_from(from: Vec3, up: Vec3): void {
    this.towards = normalized(from);
    this.right = normalized(cross(up, this.towards));
    this.up = cross(this.towards, this.right);
  }

  turn(right_deg: number, up_deg: number): void {
    const a = (right_deg * Math.PI) / 180, b = (up_deg * Math.PI) / 180;
    const y: Vec3 = [0, 1, 0];
    const right = turned(this.right, y, -a);
    // Not over the poles, where up would become down.
    const height = Math.asin(clamp(this.towards[1], -1, 1));
    const tilt = clamp(height + b, -steepest_rad, steepest_rad) - height;
    this.towards = normalized(turned(turned(this.towards, y, -a), right, -tilt));
    this.right = normalized(beyond(right, -dot(right, this.towards), this.towards));
    this.up = cross(this.towards, this.right);
  }

  move(x_px: number, y_px: number): void {
    const per_px = 1 / this.px_per_m;
    this.centre_m = add(this.centre_m, add(times(-x_px * per_px, this.right), times(y_px * per_px, this.up)));
  }

  zoom(factor: number): void {
    this.half_height_m = clamp(this.half_height_m / factor, 1e-4, 10);
  }

  show_all(box: Box): void {
    const size: Vec3 = [0, 1, 2].map((n) => box.high_m[n] - box.low_m[n]) as Vec3;
    if (!(Math.max(...size) > 0)) return;
    this.centre_m = times(0.5, add(box.low_m, box.high_m));
    const extent = (axis: Vec3) => Math.abs(axis[0]) * size[0] + Math.abs(axis[1]) * size[1] + Math.abs(axis[2]) * size[2];
    const aspect = Math.max(0.1, this.width_px / Math.max(1, this.height_px));
    this.half_height_m = 0.57 * Math.max(extent(this.up), extent(this.right) / aspect);
  }

  /** Rotation from a device's axes to the hand frame, by row: a push to the right moves to the right of the screen. */
  rotation(): number[] {
    const { right, up, towards } = this;
    return [0, 1, 2].flatMap((n) => [right[n], up[n], towards[n]]);
  }

  private along(at_m: Vec3, axis: Vec3): number {
    return (at_m[0] - this.centre_m[0]) * axis[0] + (at_m[1] - this.centre_m[1]) * axis[1] +
      (at_m[2] - this.centre_m[2]) * axis[2];
  }
}
