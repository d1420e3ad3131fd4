// Surfaces of levels: a coarse one at once, then the fine one, made by a Worker of their own.

import { combined } from './geometry';
import type { Vec3 } from './protocol';
import type { SampledField } from './sampled_field';
import type { Surface, SurfaceRequest } from './surface_worker';

export interface WantedSurface {
  key: string;
  field: SampledField;
  level: number;
}

const coarse_voxels = 4e5; // of which a surface is made at once. More: a dragged level lags; fewer: edges show

export class Surfaces {
  on_made: (wanted: WantedSurface, surface: Surface, map: number[], is_coarse: boolean) => void = () => {};
  private readonly worker = new Worker(new URL('surface_worker.js', import.meta.url), { type: 'module' });
  private readonly wanted = new Map<string, WantedSurface>();
  private readonly due_coarse = new Set<string>();
  private readonly due_fine = new Set<string>();
  private made_map: number[] = [];
  private is_busy = false;
  private is_coarse = false; // of what is made

  constructor() {
    this.worker.onmessage = ({ data }: MessageEvent<Surface>) => this.take(data);
  }

  want(surface: WantedSurface): void {
    const had = this.wanted.get(surface.key);
    if (had && had.level === surface.level && had.field === surface.field) return;
    this.wanted.set(surface.key, surface);
    const { values } = surface.field;
    (values.length > 2 * coarse_voxels ? this.due_coarse : this.due_fine).add(surface.key);
    this.next();
  }

  forget(key: string): void {
    this.wanted.delete(key);
    this.due_coarse.delete(key);
    this.due_fine.delete(key);
  }

  private next(): void {
    if (this.is_busy) return;
    this.is_coarse = this.due_coarse.size > 0;
    const due = this.is_coarse ? this.due_coarse : this.due_fine;
    const [key] = due;
    const wanted = key === undefined ? undefined : this.wanted.get(key);
    if (key === undefined || !wanted) return;
    due.delete(key);
    if (this.is_coarse) this.due_fine.add(key);
    const step = this.is_coarse ? Math.ceil(Math.cbrt(wanted.field.values.length / coarse_voxels)) : 1;
    this.made_map = combined(wanted.field.index_to_hand, [step, 0, 0, 0, 0, step, 0, 0, 0, 0, step, 0, 0, 0, 0, 1]);
    const request: SurfaceRequest = { key, level: wanted.level, ...every(step, wanted.field) };
    this.is_busy = true;
    this.worker.postMessage(request);
  }

  private take(surface: Surface): void {
    this.is_busy = false;
    const wanted = this.wanted.get(surface.key);
    if (wanted && wanted.level === surface.level) this.on_made(wanted, surface, this.made_map, this.is_coarse);
    this.next();
  }
}

/** Every n-th voxel along each axis. */
function every(step: number, field: SampledField): { dims: Vec3; values: Float32Array } {
  if (step === 1) return { dims: field.dims, values: field.values };
  const [a, b] = field.dims;
  const dims = field.dims.map((n) => Math.floor((n - 1) / step) + 1) as Vec3;
  const values = new Float32Array(dims[0] * dims[1] * dims[2]);
  let n = 0;
  for (let k = 0; k < dims[2]; ++k)
    for (let j = 0; j < dims[1]; ++j) {
      const row = step * a * (j + b * k);
      for (let i = 0; i < dims[0]; ++i) values[n++] = field.values[row + step * i];
    }
  return { dims, values };
}
