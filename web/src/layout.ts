// Structs of palpa/c.h in the module's memory (wasm32): fields at their natural alignment.

type Kind = 'i32' | 'u32' | 'i64' | 'f64' | 'pointer' | 'text';

const bytes_of: Record<Kind, number> = { i32: 4, u32: 4, i64: 8, f64: 8, pointer: 4, text: 1 };

/** A field: its kind, and how many of it. */
type Fields = Record<string, Kind | readonly [Kind, number]>;

export class Layout<F extends Fields> {
  readonly size: number;
  private readonly places = new Map<string, { kind: Kind; count: number; at: number }>();

  constructor(fields: F) {
    let at = 0;
    let widest = 1;
    for (const [name, of] of Object.entries(fields)) {
      const [kind, count] = typeof of === 'string' ? [of, 1] : of;
      const width = bytes_of[kind];
      at = Math.ceil(at / width) * width;
      this.places.set(name, { kind, count, at });
      at += width * count;
      widest = Math.max(widest, width);
    }
    this.size = Math.ceil(at / widest) * widest;
  }

  /** Names of its fields, in their order. */
  get names(): string[] {
    return [...this.places.keys()];
  }

  /** Writes numbers of a field. */
  put(view: DataView, base: number, name: keyof F & string, ...values: number[]): void {
    const { kind, at } = this.places.get(name)!;
    values.forEach((value, i) => {
      const to = base + at + i * bytes_of[kind];
      if (kind === 'f64') view.setFloat64(to, value, true);
      else if (kind === 'i64') view.setBigInt64(to, BigInt(value), true);
      else view.setInt32(to, value | 0, true);
    });
  }

  /** Number of a field, or one of its numbers. */
  get(view: DataView, base: number, name: keyof F & string, i = 0): number {
    const { kind, at } = this.places.get(name)!;
    const from = base + at + i * bytes_of[kind];
    if (kind === 'f64') return view.getFloat64(from, true);
    if (kind === 'i64') return Number(view.getBigInt64(from, true));
    return kind === 'i32' ? view.getInt32(from, true) : view.getUint32(from, true);
  }

  /** Place of a field in the struct. */
  at(name: keyof F & string): number {
    return this.places.get(name)!.at;
  }

  vector(view: DataView, base: number, name: keyof F & string): [number, number, number] {
    return [this.get(view, base, name, 0), this.get(view, base, name, 1), this.get(view, base, name, 2)];
  }
}

const vector = ['f64', 3] as const;

export const grid_layout = new Layout({
  size: 'u32', type: 'i32', components: 'i32', medical_frame: 'i32', dims: ['i64', 3], origin_m: vector, axes_m: ['f64', 9],
  voxels: 'pointer', bytes: 'u32', slope: 'f64', intercept: 'f64',
});
export const file_field_layout = new Layout({ name: 'pointer', unit: 'pointer', grid: 'pointer' });
export const file_source_layout = new Layout({ name: 'pointer', sha256: 'pointer', bytes: 'i64' });
export const file_layout = new Layout({
  size: 'u32', length_unit_assumed: 'i32', format: 'pointer', modality: 'pointer', length_unit: 'pointer', fields: 'pointer',
  field_count: 'u32', sources: 'pointer', source_count: 'u32',
});
export const probe_layout = new Layout({
  size: 'u32', buttons: 'u32', valid: 'i32', has_velocity: 'i32', position_m: vector, velocity_m_per_s: vector, turn: ['f64', 4],
});
export const limits_layout = new Layout({
  size: 'u32', has_motors: 'i32', dead_man_buttons: 'u32', unused: 'i32', max_force_n: 'f64', max_stiffness_n_per_m: 'f64',
  max_damping_ns_per_m: 'f64', continuous_force_n: 'f64', encoder_step_m: 'f64', damping_ns_per_m: 'f64', token: ['text', 16],
});
export const command_layout = new Layout({
  size: 'u32', guard: 'i32', cause: 'i32', link: 'i32', brakes: 'i32', beyond: 'i32', force_n: vector, coupling_n: vector,
  proxy_m: vector, model_age_s: 'f64', round_trip_s: 'f64',
});
export const tick_layout = new Layout({
  size: 'u32', status: 'i32', force_n: vector, proxy_m: vector, proxy_velocity_m_per_s: vector, probe_m: vector,
  probe_velocity_m_per_s: vector, probe_step_m: vector, error_bound_m: 'f64', given_back_n: 'f64', unborne_n: 'f64',
  felt_octave: 'f64', probe_valid: 'i32', forced_octave: 'i32', sub_steps: 'i32', iterations: 'i32', dropped: 'i32', work: 'i32',
  stored_j: 'f64', elastic_j: 'f64', dissipated_j: 'f64', injected_j: 'f64', path_and_release_j: 'f64', damper_j: 'f64',
  data_motion_j: 'f64', released_j: 'f64', sampling_j: 'f64', sampling_bound_j: 'f64', torque_nm: vector, probe_turn: ['f64', 4],
  proxy_turn: ['f64', 4], probe_turn_step_rad: vector,
});
export const event_layout = new Layout({
  size: 'u32', kind: 'i32', mode: 'i32', unused: 'i32', value: 'f64', depth_m: 'f64', text: ['text', 120],
});
export const primitive_layout = new Layout({
  size: 'u32', kind: 'i32', mode: 'i32', unused: 'i32', position_m: vector, direction: vector, strength_n: 'f64', force_n: vector,
});
export const steering_layout = new Layout({
  size: 'u32', buttons: 'u32', way_m: vector, deflection: vector, is_put: 'i32', unused: 'i32', put_m: vector,
});
export const inverse3_options_layout = new Layout({
  size: 'u32', force_key: 'i32', version: 'pointer', device_id: 'pointer', grip_id: 'pointer', profile: 'pointer',
});
