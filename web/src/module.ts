// The module: Palpa's functions for C, with texts, structs and failures as this language has them.

import { file_field_layout, file_layout, file_source_layout, grid_layout, type Layout } from './layout';
import type { GivenFile, Vec3 } from './protocol';
import { Wasi } from './wasi';

type Call = (...values: number[]) => number;

/** Sentence of a failure: PLACE: what is wrong; what would be right. */
export class Failure extends Error {}

const types = ['uint8', 'int16', 'uint16', 'int32', 'float32', 'float64'] as const;

/** Lattice of a sample, in the world. */
export interface Lattice {
  dims: Vec3;
  origin_m: Vec3;
  axes_m: [Vec3, Vec3, Vec3];
}

export class Module {
  private readonly memory: WebAssembly.Memory;
  private readonly calls: Record<string, Call>;

  private constructor(
    exports: WebAssembly.Exports,
    readonly wasi: Wasi,
  ) {
    this.memory = exports['memory'] as WebAssembly.Memory;
    this.calls = exports as unknown as Record<string, Call>;
  }

  static async make(compiled: WebAssembly.Module): Promise<Module> {
    const wasi = new Wasi();
    const instance = await WebAssembly.instantiate(compiled, { wasi_snapshot_preview1: wasi.imports });
    const module = new Module(instance.exports, wasi);
    wasi.bind(module.memory);
    (instance.exports['_initialize'] as () => void)();
    return module;
  }

  /** A function of palpa/c.h. */
  call(name: string, ...values: number[]): number {
    return this.calls[name](...values);
  }
  /** Likewise; a negative result is thrown as Failure. */
  check(name: string, ...values: number[]): void {
    if (this.call(name, ...values) < 0) throw this.failure();
  }
  /** Likewise of a function that returns a handle. */
  handle(name: string, ...values: number[]): number {
    const made = this.call(name, ...values);
    if (made === 0) throw this.failure();
    return made;
  }
  /** Likewise of a function that returns a text with ownership. */
  owned_text(name: string, ...values: number[]): string {
    const at = this.handle(name, ...values);
    const text = this.text(at);
    this.call('palpa_free', at);
    return text;
  }
  failure(): Failure {
    return new Failure(this.text(this.call('palpa_last_error')));
  }

  // ---- memory ----

  view(): DataView {
    return new DataView(this.memory.buffer);
  }
  bytes(at: number, length: number): Uint8Array {
    return new Uint8Array(this.memory.buffer, at, length);
  }
  room(length: number): number {
    const at = this.calls['malloc'](Math.max(length, 1));
    if (at === 0) throw new Failure('page: not enough memory; use smaller data');
    return at;
  }
  free(at: number): void {
    this.calls['free'](at);
  }
  /** A struct with its size set and all else zero. */
  // eslint-disable-next-line @typescript-eslint/no-explicit-any
  struct(layout: Layout<any>, count = 1): number {
    const at = this.room(count * layout.size);
    this.bytes(at, count * layout.size).fill(0);
    layout.put(this.view(), at, 'size', layout.size);
    return at;
  }
  text(at: number): string {
    const all = new Uint8Array(this.memory.buffer);
    return new TextDecoder().decode(all.slice(at, all.indexOf(0, at)));
  }
  /** Calls `act` with texts as zero-terminated UTF-8, which are freed behind it. */
  with_texts<T>(texts: string[], act: (...at: number[]) => T): T {
    const places = texts.map((text) => this.new_text(text));
    try {
      return act(...places);
    } finally {
      places.forEach((at) => this.free(at));
    }
  }
  private new_text(text: string): number {
    const bytes = new TextEncoder().encode(text.replaceAll('\0', ''));
    const at = this.room(bytes.length + 1);
    this.bytes(at, bytes.length).set(bytes);
    this.bytes(at + bytes.length, 1)[0] = 0;
    return at;
  }

  // ---- files and samples ----

  /** Adds a file; its voxels are copied. */
  add_file(files: number, file: GivenFile): void {
    const made: number[] = [];
    const keep = (at: number) => (made.push(at), at);
    const text = (words: string) => keep(this.new_text(words));
    try {
      const fields = keep(this.room(file_field_layout.size * file.fields.length));
      file.fields.forEach((field, i) => {
        const grid = keep(this.struct(grid_layout));
        const voxels = keep(this.room(field.voxels.byteLength));
        this.bytes(voxels, field.voxels.byteLength).set(new Uint8Array(field.voxels));
        const name = text(field.name), unit = text(field.unit);
        const view = this.view();
        grid_layout.put(view, grid, 'type', types.indexOf(field.type));
        grid_layout.put(view, grid, 'components', field.components);
        grid_layout.put(view, grid, 'medical_frame', file.medical_frame ? 1 : 0);
        grid_layout.put(view, grid, 'slope', field.slope);
        grid_layout.put(view, grid, 'intercept', field.intercept);
        grid_layout.put(view, grid, 'voxels', voxels);
        grid_layout.put(view, grid, 'bytes', field.voxels.byteLength);
        this.put_lattice(grid, field);
        const at = fields + i * file_field_layout.size;
        file_field_layout.put(view, at, 'name', name);
        file_field_layout.put(view, at, 'unit', unit);
        file_field_layout.put(view, at, 'grid', grid);
      });
      const sources = keep(this.room(file_source_layout.size * file.sources.length));
      file.sources.forEach((source, i) => {
        const name = text(source.name), sha256 = text(source.sha256);
        const view = this.view(), at = sources + i * file_source_layout.size;
        file_source_layout.put(view, at, 'name', name);
        file_source_layout.put(view, at, 'sha256', sha256);
        file_source_layout.put(view, at, 'bytes', source.bytes);
      });
      const struct = keep(this.struct(file_layout));
      const words = { format: text(file.format), modality: text(file.modality), length_unit: text(file.length_unit) };
      const name = text(file.name);
      const view = this.view();
      file_layout.put(view, struct, 'length_unit_assumed', file.length_unit_assumed ? 1 : 0);
      for (const [key, at] of Object.entries(words)) file_layout.put(view, struct, key as keyof typeof words, at);
      file_layout.put(view, struct, 'fields', fields);
      file_layout.put(view, struct, 'field_count', file.fields.length);
      file_layout.put(view, struct, 'sources', sources);
      file_layout.put(view, struct, 'source_count', file.sources.length);
      this.check('palpa_files_add', files, name, struct);
    } finally {
      made.forEach((at) => this.free(at));
    }
  }

  /** Values of a scene's field at the points of a lattice, i fastest; of a vector field x, y and z of each. */
  sample(scene: number, field: string, lattice: Lattice, components: number): Float32Array {
    const count = components * lattice.dims[0] * lattice.dims[1] * lattice.dims[2];
    const grid = this.struct(grid_layout), out = this.room(4 * count);
    try {
      this.put_lattice(grid, lattice);
      this.with_texts([field], (name) => this.check('palpa_scene_sample', scene, name, grid, out, count));
      return new Float32Array(this.memory.buffer, out, count).slice();
    } finally {
      this.free(grid);
      this.free(out);
    }
  }

  private put_lattice(grid: number, lattice: Lattice): void {
    const view = this.view();
    grid_layout.put(view, grid, 'dims', ...lattice.dims);
    grid_layout.put(view, grid, 'origin_m', ...lattice.origin_m);
    grid_layout.put(view, grid, 'axes_m', ...lattice.axes_m.flat());
  }
}
