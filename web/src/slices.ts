// Three slices along the grid's axes through the proxy, on plain canvases: they work without WebGL, too.

import { clamp, map_direction } from './geometry';
import type { Vec3 } from './protocol';
import type { SampledField } from './sampled_field';

export interface Window {
  low: number;
  high: number;
}

/** One slice: its normal is a grid axis; two others lie along the picture. */
interface Layout {
  normal: number;
  across: number; // grid axis to the right …
  is_across_turned: boolean;
  down: number; // … and down
  is_down_turned: boolean;
  words: [string, string, string, string]; // right, left, top, bottom
}

interface Placed {
  x: number;
  y: number;
  width: number;
  height: number;
}

export class Slices {
  on_touch: (at_m: Vec3, begins: boolean) => void = () => {};
  on_release: () => void = () => {};
  on_window: (window: Window) => void = () => {};
  private field: SampledField | null = null;
  private window: Window = { low: 0, high: 1 };
  private by_data: Window = { low: 0, high: 1 };
  private layouts: Layout[] = [];
  private index: Vec3 = [0, 0, 0];
  private shown: Vec3 = [-1, -1, -1]; // last position; a slice that the wheel has chosen stays until the hand moves
  private readonly images: { at: number; canvas: HTMLCanvasElement; window: Window }[] = [];

  constructor(private readonly canvases: HTMLCanvasElement[]) {
    canvases.forEach((canvas, n) => this.listen(canvas, n));
  }

  begin(field: SampledField | null, window: Window, is_medical: boolean): void {
    this.field = field;
    this.window = { ...window };
    this.by_data = { ...window };
    this.images.length = 0;
    this.shown = [-1, -1, -1];
    this.layouts = field ? layouts_of(field, is_medical) : [];
    if (field) this.index = field.dims.map((n) => (n - 1) / 2) as Vec3;
    this.draw();
  }

  set_window(window: Window): void {
    this.window = { ...window };
    this.draw();
  }

  /** Moves the slices to a position of the hand frame. */
  show(at_m: Vec3): void {
    if (!this.field) return;
    const index = this.field.index_of(at_m);
    const next = index.map((x, n) => clamp(x, 0, this.field!.dims[n] - 1)) as Vec3;
    if (next.every((x, n) => Math.abs(x - this.shown[n]) < 0.02)) return;
    this.shown = next;
    this.index = [...next];
    this.draw();
  }

  draw(): void {
    this.canvases.forEach((canvas, n) => this.draw_slice(canvas, n));
  }

  private draw_slice(canvas: HTMLCanvasElement, n: number): void {
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (width === 0 || height === 0) return;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    const painter = canvas.getContext('2d')!;
    painter.setTransform(ratio, 0, 0, ratio, 0, 0);
    painter.fillStyle = '#101012';
    painter.fillRect(0, 0, width, height);
    const { field } = this, layout = this.layouts[n];
    if (!field || !layout) return;
    const placed = this.place(canvas, layout);
    painter.imageSmoothingQuality = 'high';
    painter.drawImage(this.image_of(n, layout), placed.x, placed.y, placed.width, placed.height);
    this.draw_cross(painter, layout, placed, width, height);
    draw_words(painter, layout, width, height);
  }

  private draw_cross(painter: CanvasRenderingContext2D, layout: Layout, placed: Placed, width: number, height: number): void {
    const [x, y] = this.px_of(layout, placed);
    painter.strokeStyle = 'rgba(86, 180, 233, 0.65)';
    painter.lineWidth = 1;
    painter.beginPath();
    painter.moveTo(x, 0);
    painter.lineTo(x, height);
    painter.moveTo(0, y);
    painter.lineTo(width, y);
    painter.stroke();
    painter.fillStyle = '#16161c';
    painter.strokeStyle = 'white';
    painter.lineWidth = 1.5;
    painter.beginPath();
    painter.arc(x, y, 5, 0, 2 * Math.PI);
    painter.fill();
    painter.stroke();
  }

  private px_of(layout: Layout, placed: Placed): [number, number] {
    const { dims } = this.field!;
    const share = (axis: number, is_turned: boolean) => {
      const s = (this.index[axis] + 0.5) / dims[axis];
      return is_turned ? 1 - s : s;
    };
    return [
      placed.x + placed.width * share(layout.across, layout.is_across_turned),
      placed.y + placed.height * share(layout.down, layout.is_down_turned),
    ];
  }

  private place(canvas: HTMLCanvasElement, layout: Layout): Placed {
    const { dims, index_to_world: m } = this.field!;
    const length = (axis: number) => dims[axis] * Math.hypot(m[axis], m[4 + axis], m[8 + axis]);
    const a = length(layout.across), b = length(layout.down);
    const scale = Math.min(canvas.clientWidth / a, canvas.clientHeight / b);
    const width = a * scale, height = b * scale;
    return { x: 0.5 * (canvas.clientWidth - width), y: 0.5 * (canvas.clientHeight - height), width, height };
  }

  private image_of(n: number, layout: Layout): HTMLCanvasElement {
    const { dims, values } = this.field!;
    const at = Math.round(this.index[layout.normal]);
    const had = this.images[n];
    const { low, high } = this.window;
    if (had && had.at === at && had.window.low === low && had.window.high === high) return had.canvas;
    const width = dims[layout.across], height = dims[layout.down];
    const canvas = had?.canvas ?? document.createElement('canvas');
    canvas.width = width;
    canvas.height = height;
    const image = new ImageData(width, height), pixels = new Uint32Array(image.data.buffer);
    const stride = [1, dims[0], dims[0] * dims[1]];
    const scale = 255 / (high > low ? high - low : 1);
    for (let row = 0; row < height; ++row) {
      const down = layout.is_down_turned ? height - 1 - row : row;
      for (let column = 0; column < width; ++column) {
        const across = layout.is_across_turned ? width - 1 - column : column;
        const value = values[at * stride[layout.normal] + across * stride[layout.across] + down * stride[layout.down]];
        const grey = value > low ? Math.min(255, (value - low) * scale) & 255 : 0;
        pixels[row * width + column] = 0xff000000 | (grey << 16) | (grey << 8) | grey;
      }
    }
    canvas.getContext('2d')!.putImageData(image, 0, 0);
    this.images[n] = { at, canvas, window: { low, high } };
    return canvas;
  }

  private listen(canvas: HTMLCanvasElement, n: number): void {
    let drag: 'touch' | 'window' | null = null;
    let last: [number, number] = [0, 0];
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('pointerdown', (event) => {
      if (!this.field) return;
      canvas.setPointerCapture(event.pointerId);
      drag = event.button === 2 ? 'window' : 'touch';
      last = [event.clientX, event.clientY];
      if (drag === 'touch') this.touch(canvas, n, event, true);
    });
    canvas.addEventListener('pointermove', (event) => {
      if (drag === 'touch') this.touch(canvas, n, event, false);
      if (drag === 'window') this.change_window(event.clientX - last[0], event.clientY - last[1]);
      last = [event.clientX, event.clientY];
    });
    const ends = () => {
      if (drag === 'touch') this.on_release();
      drag = null;
    };
    canvas.addEventListener('pointerup', ends);
    canvas.addEventListener('pointercancel', ends);
    canvas.addEventListener('dblclick', () => this.apply_window(this.by_data));
    canvas.addEventListener('wheel', (event) => {
      const layout = this.layouts[n];
      if (!this.field || !layout) return;
      event.preventDefault();
      const last_slice = this.field.dims[layout.normal] - 1;
      this.index[layout.normal] = clamp(Math.round(this.index[layout.normal]) - Math.sign(event.deltaY), 0, last_slice);
      this.draw();
    }, { passive: false });
  }

  private touch(canvas: HTMLCanvasElement, n: number, event: PointerEvent, begins: boolean): void {
    const layout = this.layouts[n];
    if (!this.field || !layout) return;
    const box = canvas.getBoundingClientRect(), placed = this.place(canvas, layout), { dims } = this.field;
    const share = (px: number, from: number, size: number, is_turned: boolean) => {
      const s = clamp((px - from) / size, 0, 1);
      return is_turned ? 1 - s : s;
    };
    const index: Vec3 = [...this.index];
    const across = share(event.clientX - box.left, placed.x, placed.width, layout.is_across_turned);
    const down = share(event.clientY - box.top, placed.y, placed.height, layout.is_down_turned);
    index[layout.across] = clamp(across * dims[layout.across] - 0.5, 0, dims[layout.across] - 1);
    index[layout.down] = clamp(down * dims[layout.down] - 0.5, 0, dims[layout.down] - 1);
    this.on_touch(this.field.position_of(index), begins);
  }

  private change_window(x_px: number, y_px: number): void {
    const { low, high } = this.window, span = this.by_data.high - this.by_data.low;
    const middle = 0.5 * (low + high) + (y_px / 300) * span;
    const half = Math.max(0.005 * span, 0.5 * (high - low) + (x_px / 300) * span);
    this.apply_window({ low: middle - half, high: middle + half });
  }

  private apply_window(window: Window): void {
    this.set_window(window);
    this.on_window(window);
  }
}

function draw_words(painter: CanvasRenderingContext2D, layout: Layout, width: number, height: number): void {
  painter.font = '600 11px system-ui, sans-serif';
  painter.textBaseline = 'middle';
  const word = (text: string, x: number, y: number, align: CanvasTextAlign) => {
    painter.textAlign = align;
    painter.lineWidth = 3;
    painter.strokeStyle = 'rgba(0, 0, 0, 0.7)';
    painter.strokeText(text, x, y);
    painter.fillStyle = 'rgba(255, 255, 255, 0.9)';
    painter.fillText(text, x, y);
  };
  const [right, left, top, bottom] = layout.words;
  word(right, width - 6, height / 2, 'right');
  word(left, 6, height / 2, 'left');
  word(top, width / 2, 11, 'center');
  word(bottom, width / 2, height - 10, 'center');
}

const plain_words = [['+x', '−x'], ['+y', '−y'], ['+z', '−z']];
const patient_words = [['L', 'R'], ['P', 'A'], ['S', 'I']];

/** Slices across the world's z, y and x, each by the grid axis nearest to it. */
function layouts_of(field: SampledField, is_medical: boolean): Layout[] {
  const axis_of = nearest_axes(field);
  const words = is_medical ? patient_words : plain_words;
  const sign = (world: number) => {
    const unit: Vec3 = [0, 0, 0];
    unit[axis_of[world]] = 1;
    return map_direction(field.index_to_world, unit)[world] >= 0;
  };
  const layout = (normal: number, across: number, up: number, is_up_against: boolean): Layout => ({
    normal: axis_of[normal],
    across: axis_of[across],
    is_across_turned: !sign(across),
    down: axis_of[up],
    is_down_turned: sign(up) !== is_up_against,
    words: [words[across][0], words[across][1], words[up][is_up_against ? 1 : 0], words[up][is_up_against ? 0 : 1]],
  });
  return [layout(2, 0, 1, is_medical), layout(1, 0, 2, false), layout(0, 1, 2, false)];
}

/** Grid axis nearest to each of the world's; each is taken once. */
function nearest_axes(field: SampledField): Vec3 {
  const m = field.index_to_world;
  const along = (world: number, axis: number) => {
    const length = Math.hypot(m[axis], m[4 + axis], m[8 + axis]);
    return length > 0 ? Math.abs(m[4 * world + axis]) / length : 0;
  };
  const orders: Vec3[] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
  const fit = (order: Vec3) => along(0, order[0]) + along(1, order[1]) + along(2, order[2]);
  return orders.reduce((best, one) => (fit(one) > fit(best) + 1e-9 ? one : best));
}
