// Hand, force and primitives, painted over the picture of the data in pixels that are legible in any view.

import type { Camera } from './camera';
import { force_style, mode_color, proxy_color } from './colors';
import { add, beyond, clamp, cross, distance, norm, normalized, times } from './geometry';
import type { Moment, PlacedPrimitive, Vec3 } from './protocol';

const disc_px = 34; // radius of a plane's disc. Larger: hides the data; smaller: hides its tilt
const rod_px = 46; // half the length of a line
const arrow_px = 84; // of the largest force
const least_shown_n = 1e-3;
const trail_moments = 90;
const same_m = 2e-6, same_n = 2e-3; // differences that are not seen

type Px = [number, number];

export class Marks {
  shows_primitives = true;
  /** Where a press would touch. */
  ghost_m: Vec3 | null = null;
  private moment: Moment | null = null;
  private most_n = 3.3;
  private is_changed = true;
  private seen = ''; // view and cues of the last picture
  private trail: { at_m: Vec3; force_n: number }[] = [];
  private readonly painter: CanvasRenderingContext2D;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly camera: Camera,
  ) {
    this.painter = canvas.getContext('2d')!;
  }

  begin(most_n: number): void {
    this.most_n = Math.max(most_n, 1e-3);
    this.moment = null;
    this.trail = [];
    this.is_changed = true;
  }

  forget_trail(): void {
    this.trail = [];
    this.is_changed = true;
  }

  take(moment: Moment): void {
    if (this.moment && look_alike(this.moment, moment) && this.trail.length === 0) return;
    this.moment = moment;
    this.is_changed = true;
    this.trail.push({ at_m: moment.proxy_m, force_n: norm(moment.command_n) });
    // A hand at rest draws its trail in, and then nothing changes.
    const first = this.trail[0];
    const rests = this.trail.every(({ at_m, force_n }) => distance(at_m, first.at_m) < same_m && Math.abs(force_n - first.force_n) < same_n);
    if (rests) this.trail = [];
    else if (this.trail.length > trail_moments) this.trail.shift();
  }

  resize(): void {
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(this.camera.width_px * ratio);
    this.canvas.height = Math.round(this.camera.height_px * ratio);
    this.painter.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.is_changed = true;
  }

  /** Draws if anything has changed. */
  draw(): void {
    const { painter, camera, moment } = this;
    const ghost = this.ghost_m ? this.ghost_m.join() : '';
    const seen = `${camera.px_per_m} ${camera.centre_m} ${camera.towards} ${ghost} ${this.shows_primitives}`;
    if (!this.is_changed && seen === this.seen) return;
    this.is_changed = false;
    this.seen = seen;
    painter.clearRect(0, 0, camera.width_px, camera.height_px);
    painter.lineCap = 'round';
    this.draw_trail();
    if (this.ghost_m) this.draw_ghost(this.px(this.ghost_m));
    if (!moment) return;
    if (this.shows_primitives) for (const placed of moment.primitives) this.draw_primitive(placed, moment);
    this.draw_hand(moment);
  }

  private px(at_m: Vec3): Px {
    return [this.camera.x_px(at_m), this.camera.y_px(at_m)];
  }

  private draw_trail(): void {
    const { painter, trail } = this;
    painter.lineWidth = 3;
    for (let n = 1; n < trail.length; ++n) {
      painter.strokeStyle = force_style(trail[n].force_n / this.most_n, 0.2 + (0.7 * n) / trail.length);
      this.line(this.px(trail[n - 1].at_m), this.px(trail[n].at_m));
    }
  }

  private draw_hand(moment: Moment): void {
    const { painter } = this;
    const proxy = this.px(moment.proxy_m), probe = this.px(moment.probe_m);
    painter.strokeStyle = 'rgb(90, 90, 96)';
    painter.lineWidth = 2;
    painter.setLineDash([5, 4]);
    this.line(proxy, probe);
    painter.setLineDash([]);
    painter.fillStyle = 'rgba(110, 110, 120, 0.5)';
    painter.strokeStyle = 'rgba(255, 255, 255, 0.8)';
    painter.lineWidth = 1;
    this.circle(probe, 5);
    const light = painter.createRadialGradient(proxy[0] - 2.5, proxy[1] - 2.5, 0, proxy[0], proxy[1], 9);
    light.addColorStop(0, '#55555f');
    light.addColorStop(1, proxy_color);
    painter.fillStyle = light;
    painter.strokeStyle = 'white';
    painter.lineWidth = 1.5;
    this.circle(proxy, 7);
    this.draw_force(moment, proxy);
  }

  private draw_force(moment: Moment, proxy: Px): void {
    const force_n = norm(moment.command_n);
    if (force_n < 0.02) return;
    const length_m = (10 + arrow_px * clamp(force_n / this.most_n, 0, 1)) / this.camera.px_per_m;
    const end = beyond(moment.proxy_m, length_m, normalized(moment.command_n));
    this.arrow(proxy, this.px(end), force_style(0.35 + (0.5 * force_n) / this.most_n, 1), 3);
  }

  private draw_primitive(placed: PlacedPrimitive, moment: Moment): void {
    const color = mode_color(placed.mode), force_n = norm(placed.force_n);
    const is_idle = force_n < least_shown_n;
    const at = this.px(placed.position_m);
    const length_m = (10 + arrow_px * clamp(force_n / this.most_n, 0, 1)) / this.camera.px_per_m;
    const { painter } = this;
    painter.strokeStyle = color;
    if (placed.kind === 'plane' || placed.kind === 'corner') {
      this.draw_disc(placed, color, is_idle);
    } else if (placed.kind === 'line') {
      const rod_m = rod_px / this.camera.px_per_m;
      painter.lineWidth = is_idle ? 1.5 : 3;
      this.line(this.px(beyond(placed.position_m, -rod_m, placed.direction)), this.px(beyond(placed.position_m, rod_m, placed.direction)));
    } else if (placed.kind === 'point') {
      painter.fillStyle = color + '80';
      painter.lineWidth = 1.5;
      this.circle(at, 4 + 10 * clamp(force_n / this.most_n, 0, 1));
    } else if (!is_idle) {
      const end = beyond(moment.proxy_m, length_m, normalized(placed.force_n));
      this.arrow(this.px(moment.proxy_m), this.px(end), color, 3);
    }
  }

  private draw_disc(placed: PlacedPrimitive, color: string, is_idle: boolean): void {
    const { painter } = this;
    const normal = placed.direction;
    const other: Vec3 = Math.abs(normal[0]) < 0.7 ? [1, 0, 0] : [0, 1, 0];
    const a = normalized(cross(normal, other)), b = cross(normal, a);
    const radius_m = disc_px / this.camera.px_per_m;
    painter.beginPath();
    for (let n = 0; n < 40; ++n) {
      const angle = (2 * Math.PI * n) / 40;
      const around = add(times(radius_m * Math.cos(angle), a), times(radius_m * Math.sin(angle), b));
      painter.lineTo(...this.px(add(placed.position_m, around)));
    }
    painter.closePath();
    painter.fillStyle = color + (is_idle ? '26' : '66');
    painter.lineWidth = is_idle ? 1 : 1.8;
    painter.fill();
    painter.stroke();
  }

  private draw_ghost(at: Px): void {
    const { painter } = this;
    painter.fillStyle = 'rgba(22, 22, 28, 0.27)';
    painter.strokeStyle = 'rgba(255, 255, 255, 0.86)';
    painter.lineWidth = 2.2;
    this.circle(at, 7);
    painter.strokeStyle = 'rgba(22, 22, 28, 0.86)';
    painter.lineWidth = 1;
    painter.beginPath();
    painter.arc(at[0], at[1], 8.2, 0, 2 * Math.PI);
    painter.stroke();
  }

  private arrow(from: Px, to: Px, color: string, width: number): void {
    const { painter } = this;
    const way: Px = [to[0] - from[0], to[1] - from[1]], length = Math.hypot(...way);
    painter.strokeStyle = painter.fillStyle = color;
    painter.lineWidth = width;
    if (length < 3 * width) {
      // Along the line of sight.
      this.circle(to, width);
      return;
    }
    const x = way[0] / length, y = way[1] / length, head = Math.min(5 * width, 0.5 * length);
    this.line(from, [to[0] - 0.8 * head * x, to[1] - 0.8 * head * y]);
    painter.beginPath();
    painter.moveTo(...to);
    painter.lineTo(to[0] - head * x - 0.45 * head * y, to[1] - head * y + 0.45 * head * x);
    painter.lineTo(to[0] - head * x + 0.45 * head * y, to[1] - head * y - 0.45 * head * x);
    painter.fill();
  }

  private line(from: Px, to: Px): void {
    this.painter.beginPath();
    this.painter.moveTo(...from);
    this.painter.lineTo(...to);
    this.painter.stroke();
  }

  private circle(at: Px, radius: number): void {
    this.painter.beginPath();
    this.painter.arc(at[0], at[1], radius, 0, 2 * Math.PI);
    this.painter.fill();
    this.painter.stroke();
  }
}

function look_alike(a: Moment, b: Moment): boolean {
  return distance(a.proxy_m, b.proxy_m) < same_m && distance(a.probe_m, b.probe_m) < same_m &&
    distance(a.command_n, b.command_n) < same_n && a.primitives.length === b.primitives.length;
}
