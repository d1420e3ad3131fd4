// Hand that mouse, finger or keys lead: where a press touches, how deep it presses, and the messages that move it.

import type { Camera } from './camera';
import { add, beyond, clamp, distance, dot, minus, norm, shortened, times } from './geometry';
import type { Moment, ToWorker, Vec3 } from './protocol';
import type { SampledField } from './sampled_field';
import type { Streamline } from './streamlines';

const in_front_m = 6e-3; // of the surface: start and end of a press
const first_depth_m = 1e-3; // initial, of a press. Deeper: the first touch is a blow; less: not felt
export const deepest_m = 0.05; // largest, of a press
const led_m_per_s = 0.5; // of the mouse's hand. Faster: pushes are blows
const near_stream_px = 80; // within which a touch takes the depth of a streamline

/** Surface or place that a press touches. */
export interface Target {
  at_m: Vec3;
  into: Vec3; // unit vector of a press
}

/** A field with the levels that are felt in it. */
export interface FeltSurfaces {
  field: SampledField;
  levels: number[];
}

export class Hand {
  surfaces: FeltSurfaces[] = [];
  /** The scene's data are here: what a press meets is known. */
  is_ready = false;
  streams: Streamline[] = [];
  depth_m = first_depth_m;
  is_touching = false;
  on_depth: () => void = () => {};
  private wanted_m: Vec3 = [0, 0, 0];
  private sent_m: Vec3 = [0, 0, 0];
  private into: Vec3 = [0, 0, -1];
  private plane_depth_m = 0;
  private begins_at_m = first_depth_m; // depth of a press at its beginning
  private last_px: [number, number] = [0, 0];
  private moment: Moment | null = null;

  constructor(
    private readonly camera: Camera,
    private readonly send: (message: ToWorker) => void,
  ) {}

  /** Begins in front of the data. \param front_m  where they begin, towards the user */
  begin_scene(front_m: number): void {
    this.surfaces = [];
    this.is_ready = this.is_touching = false;
    this.moment = null;
    this.wanted_m = this.sent_m = [0, 0, front_m + in_front_m];
    this.send({ kind: 'put', position_m: this.wanted_m });
  }

  take(moment: Moment): void {
    this.moment = moment;
  }

  get has_surfaces(): boolean {
    return this.surfaces.some(({ levels }) => levels.length > 0);
  }

  /** Where a press would touch; null: it would turn the view. */
  target_at(x_px: number, y_px: number): Target | null {
    if (!this.is_ready) return null;
    const surface = this.surface_at(x_px, y_px);
    if (surface) return surface;
    if (this.has_surfaces) return null;
    const away = times(-1, this.camera.towards);
    return { at_m: beyond(this.camera.at_m(x_px, y_px), this.flow_depth_m(x_px, y_px), away), into: away };
  }

  /** Nearest pixel to the middle where a press touches. */
  nearest_target_px(): [number, number] | null {
    const { width_px, height_px } = this.camera;
    for (let ring = 0; 18 * ring < 0.5 * Math.hypot(width_px, height_px); ++ring) {
      const sides = Math.max(1, 8 * ring);
      for (let side = 0; side < sides; ++side) {
        const angle = (2 * Math.PI * side) / sides;
        const x_px = 0.5 * width_px + 18 * ring * Math.cos(angle), y_px = 0.5 * height_px + 18 * ring * Math.sin(angle);
        const is_inside = x_px >= 0 && y_px >= 0 && x_px < width_px && y_px < height_px;
        if (is_inside && this.target_at(x_px, y_px)) return [x_px, y_px];
      }
    }
    return null;
  }

  begin(x_px: number, y_px: number): boolean {
    const target = this.target_at(x_px, y_px);
    if (!target) return false;
    this.is_touching = true;
    this.depth_m = this.has_surfaces ? this.begins_at_m : 0;
    this.plane_depth_m = this.camera.depth_m(target.at_m);
    const is_behind = this.moment !== null && dot(minus(this.moment.probe_m, target.at_m), target.into) > 0;
    this.jump_to(beyond(target.at_m, -in_front_m, target.into), is_behind);
    this.lead(x_px, y_px);
    this.on_depth();
    return true;
  }

  lead(x_px: number, y_px: number): void {
    if (!this.is_touching) return;
    this.last_px = [x_px, y_px];
    const surface = this.surface_at(x_px, y_px);
    if (surface) this.plane_depth_m = this.camera.depth_m(surface.at_m);
    this.into = surface ? surface.into : times(-1, this.camera.towards);
    const at_m = surface ? surface.at_m : beyond(this.camera.at_m(x_px, y_px), -this.plane_depth_m, this.camera.towards);
    this.wanted_m = beyond(at_m, this.depth_m, this.into);
  }

  /** Leads on by pixels, as the arrow keys do. */
  lead_by(x_px: number, y_px: number): void {
    this.lead(clamp(this.last_px[0] + x_px, 0, this.camera.width_px), clamp(this.last_px[1] + y_px, 0, this.camera.height_px));
  }

  press_deeper(notches: number): void {
    // Finer steps for a light press.
    this.press(this.depth_m + notches * (4e-4 + 0.15 * Math.abs(this.depth_m)));
  }

  press(depth_m: number): void {
    this.depth_m = clamp(depth_m, -deepest_m, deepest_m);
    this.lead(...this.last_px);
    this.on_depth();
  }

  /** Presses so deep, now and at the next touches. */
  press_from_now_on(depth_m: number): void {
    this.begins_at_m = clamp(depth_m, 0, deepest_m);
    this.press(this.begins_at_m);
  }

  end(): void {
    if (!this.is_touching) return;
    this.is_touching = false;
    this.depth_m = this.begins_at_m;
    this.on_depth();
    if (this.moment) this.wanted_m = beyond(this.moment.proxy_m, -in_front_m, this.into);
  }

  /** Leads to a place in a slice. */
  lead_to(at_m: Vec3, begins: boolean): void {
    if (begins) this.jump_to(at_m);
    this.wanted_m = at_m;
    this.into = [0, 0, 0];
  }

  /** Sends the motion that is due. */
  beat(dt_s: number): void {
    const step_m = shortened(minus(this.wanted_m, this.sent_m), led_m_per_s * clamp(dt_s, 0, 0.1));
    if (norm(step_m) === 0) return;
    this.sent_m = add(this.sent_m, step_m);
    this.send({ kind: 'pointer', way_m: step_m });
  }

  /** Far away, or behind the surface: jumps without contacts on the way; near: slides. */
  private jump_to(at_m: Vec3, is_behind = false): void {
    const probe_m = this.moment ? this.moment.probe_m : this.sent_m;
    if (!is_behind && distance(this.sent_m, at_m) <= 2 * in_front_m && distance(probe_m, at_m) <= 3 * in_front_m) return;
    this.wanted_m = this.sent_m = at_m;
    this.send({ kind: 'put', position_m: at_m });
  }

  private surface_at(x_px: number, y_px: number): Target | null {
    const { camera } = this;
    const far_m = 4; // in front of all data
    const from_m = beyond(camera.at_m(x_px, y_px), far_m, camera.towards);
    let first: Target | null = null;
    for (const { field, levels } of this.surfaces) {
      const found = field.first_crossing(from_m, times(-1, camera.towards), levels);
      if (found && (!first || camera.depth_m(found.at_m) < camera.depth_m(first.at_m))) first = found;
    }
    return first;
  }

  /** Depth of the nearest streamline on the screen, else of the proxy; behind the view's centre. */
  private flow_depth_m(x_px: number, y_px: number): number {
    const { camera } = this;
    let nearest_px = near_stream_px, depth_m = this.moment ? camera.depth_m(this.moment.proxy_m) : 0;
    for (const line of this.streams)
      for (let n = 0; n < line.points_m.length; n += 4) {
        const at_m = line.points_m[n];
        const away_px = Math.hypot(camera.x_px(at_m) - x_px, camera.y_px(at_m) - y_px);
        if (away_px < nearest_px) [nearest_px, depth_m] = [away_px, camera.depth_m(at_m)];
      }
    return depth_m;
  }
}
