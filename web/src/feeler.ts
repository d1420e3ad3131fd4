// Scene, loop, and hand of mouse or controller, in one module.

import { facts_words } from './facts';
import { command_layout, event_layout, limits_layout, primitive_layout, probe_layout, steering_layout, tick_layout } from './layout';
import { Module, type Lattice } from './module';
import type { FromWorker, GivenFile, Moment, PlacedPrimitive, SceneFacts, Vec3 } from './protocol';

const reach_m = 0.4; // radius of the ball of palpa_steered's mouse
const most_primitives = 256; // in a picture
const most_events = 32; // of a tick
const most_modes = 64; // in a picture
const timed_ticks = 2000; // of their mean time. More: it follows late; fewer: steps of the browser's clock, of 0.1 ms, show
const guards = ['pass', 'limited', 'fault', 'waiting', 'ramp', 'damped', 'falling', 'off'];
const causes = [
  '', 'the session begins', 'the force is no number', 'the device has no position', 'the device has a fault',
  'the link to the device is lost', 'the loop was late', 'the hand is too fast', 'the view moves',
  'the dead-man button is released', 'stopped by hand', 'the program stops', 'another hand has a fault',
  'the far data are late', 'the far data are gone',
];
const event_words = ['onset', 'break-through', 'fault', 'warning'];
const kinds = ['point', 'line', 'plane', 'force', 'corner'] as const;

/** Bits of a tick's circumstances. */
export const circumstance = { device_fault: 1, link_lost: 2, late: 4, view_moves: 8, panic: 16, resume: 32 };

export type SteeredKind = 'mouse' | 'controller';

/** Input of a steered hand since the last tick. */
export interface Steering {
  way_m: Vec3;
  share: Vec3;
  buttons: number;
  put_m: Vec3 | null;
}

/** A field that is sampled slice by slice: thousands of ticks are due meanwhile. */
export interface Sampling {
  scene: number; // of those that were opened
  components: number;
  slices: number; // that are done
  answer: FromWorker & { kind: 'field' };
}

export class Feeler {
  private readonly files: number;
  private scene = 0;
  private opened = 0; // scenes
  private loop = 0;
  private steered = 0;
  private facts: SceneFacts | null = null;
  private folder = ''; // of the recording
  private readonly limits: number;
  private readonly steering: number;
  private readonly primitives: number;
  private readonly events: number;
  private readonly vector: number;
  private readonly rotation: number;
  /** Structs of the last tick, in the module's memory. */
  readonly probe: number;
  readonly command: number;
  readonly tick_at: number;
  private curve: number[] = [];
  private said: string[] = [];
  private ticks = 0;
  private t_s = 0;
  private spent_ms = 0;
  private spent_in = 0; // so many last ticks

  constructor(readonly module: Module) {
    this.files = module.handle('palpa_files_new');
    this.limits = module.struct(limits_layout);
    this.steering = module.struct(steering_layout);
    this.primitives = module.struct(primitive_layout, most_primitives);
    this.events = module.struct(event_layout, most_events);
    this.vector = module.room(24);
    this.rotation = module.room(72);
    this.probe = module.struct(probe_layout);
    this.command = module.struct(command_layout);
    this.tick_at = module.struct(tick_layout);
  }

  get is_open(): boolean {
    return this.loop !== 0;
  }
  get is_recording(): boolean {
    return this.folder !== '';
  }

  // ---- scene ----

  /** Feels a scene's text. A failure leaves the last scene. */
  open(text: string): SceneFacts {
    const { module } = this;
    const scene = module.with_texts([text], (at) => module.handle('palpa_scene_parse_with', at, this.files));
    let loop = 0;
    try {
      loop = module.handle('palpa_loop_new', scene, this.limits);
      this.facts = this.facts_of(scene);
    } catch (failure) {
      module.call('palpa_loop_free', loop);
      module.call('palpa_scene_free', scene);
      throw failure;
    }
    this.end_recording();
    module.call('palpa_loop_free', this.loop);
    module.call('palpa_scene_free', this.scene);
    [this.scene, this.loop] = [scene, loop];
    ++this.opened;
    this.ticks = this.t_s = this.spent_ms = this.spent_in = 0;
    return this.facts;
  }

  /** Changes the scene as --set PATH=VALUE does. A failure changes nothing. */
  set(path: string, value: string): SceneFacts {
    const { module } = this;
    const changed = module.handle('palpa_scene_copy', this.scene);
    try {
      module.with_texts([path, value], (p, v) => module.check('palpa_scene_set', changed, p, v));
      const facts = this.facts_of(changed);
      module.check('palpa_loop_change', this.loop, changed);
      this.facts = facts;
    } catch (failure) {
      module.call('palpa_scene_free', changed);
      throw failure;
    }
    module.call('palpa_scene_free', this.scene);
    this.scene = changed;
    return this.facts;
  }

  /** Gives a file; its facts in lines, and its first scene. */
  give(file: GivenFile): { facts: string; first_scene: string } {
    const { module } = this;
    module.add_file(this.files, file);
    return module.with_texts([file.name], (name) => ({
      facts: facts_words(JSON.parse(module.owned_text('palpa_files_facts', this.files, name))),
      first_scene: module.owned_text('palpa_files_first_scene', this.files, name),
    }));
  }

  /** Gives a file that was given to another module. */
  give_again(file: GivenFile): void {
    this.module.add_file(this.files, file);
  }

  /** Begins to sample a field over the scene's box, at most `longest` along an edge. */
  begin_sample(field: string, longest: number): Sampling {
    const is_drawn = this.facts?.layers?.some((layer) => layer.field === field); // also what is derived: 'q(wing.velocity)'
    const of = this.facts?.fields.find((one) => one.name === field) ?? (is_drawn ? { unit: '', components: 1 } : undefined);
    if (!of || !this.facts) throw this.no_scene();
    const [low, high] = this.facts.bounds_m;
    const size = [0, 1, 2].map((a) => high[a] - low[a]);
    const step_m = Math.max(...size) / (Math.max(2, Math.min(256, longest)) - 1);
    const dims = size.map((length) => Math.max(2, Math.round(length / step_m) + 1)) as Vec3;
    const axes_m = [0, 1, 2].map((a) => [0, 1, 2].map((b) => (a === b ? size[a] / (dims[a] - 1) : 0))) as Lattice['axes_m'];
    const values = new Float32Array(of.components * dims[0] * dims[1] * dims[2]);
    return { scene: this.opened, components: of.components, slices: 0, answer: { kind: 'field', field, unit: of.unit, dims, origin_m: low, axes_m, values } };
  }

  /** Samples the next slice. Returns whether it was the last, or of a scene that is no more. */
  sample_slice(sampling: Sampling): boolean {
    const { answer, components, slices } = sampling;
    if (sampling.scene !== this.opened) return true;
    const origin_m = answer.origin_m.map((x, a) => x + slices * answer.axes_m[2][a]) as Vec3;
    const lattice: Lattice = { dims: [answer.dims[0], answer.dims[1], 1], origin_m, axes_m: answer.axes_m };
    const values = this.module.sample(this.scene, answer.field, lattice, components);
    answer.values.set(values, slices * values.length);
    return ++sampling.slices === answer.dims[2];
  }

  /** Whether a sampling that has ended is of the scene that is open. */
  is_of_scene(sampling: Sampling): boolean {
    return sampling.scene === this.opened;
  }

  private facts_of(scene: number): SceneFacts {
    const { module } = this;
    return {
      ...JSON.parse(module.owned_text('palpa_scene_facts', scene)),
      text: module.owned_text('palpa_scene_text', scene),
      warnings: module.owned_text('palpa_scene_warnings', scene).split('\n').filter((line) => line !== ''),
      reach_m,
    };
  }

  private no_scene(): Error {
    return new Error('page: no scene is open, or it has no such field; open a scene first');
  }

  // ---- hands ----

  /** Limits of the hand that is felt from now on; the scene begins anew with it. */
  begin_steered(kind: SteeredKind): void {
    const { module } = this;
    const made = module.handle('palpa_steered_new', kind === 'mouse' ? 0 : 1, this.limits);
    module.call('palpa_steered_free', this.steered);
    this.steered = made;
    // The whole guard, as in the window: panic and a moving view take the force away.
    limits_layout.put(module.view(), this.limits, 'has_motors', 1);
    this.begin_again();
  }
  /** Likewise of a device, whose limits a function of palpa/c.h writes. */
  begin_device(limits_function: string): void {
    this.module.check(limits_function, this.limits);
    this.begin_again();
  }
  private begin_again(): void {
    if (!this.scene) return;
    this.end_recording();
    this.module.call('palpa_loop_free', this.loop);
    this.loop = 0;
    this.loop = this.module.handle('palpa_loop_new', this.scene, this.limits);
  }

  turn(rotation: number[]): void {
    const view = this.module.view();
    rotation.slice(0, 9).forEach((number, i) => view.setFloat64(this.rotation + 8 * i, number, true));
    this.module.check('palpa_loop_turn', this.loop, this.rotation);
  }

  /** A tick of the steered hand. */
  steer(input: Steering, time_step_s: number, bits: number): void {
    const { module } = this;
    const view = module.view();
    steering_layout.put(view, this.steering, 'buttons', input.buttons);
    steering_layout.put(view, this.steering, 'way_m', ...input.way_m);
    steering_layout.put(view, this.steering, 'deflection', ...input.share);
    steering_layout.put(view, this.steering, 'is_put', input.put_m ? 1 : 0);
    steering_layout.put(view, this.steering, 'put_m', ...(input.put_m ?? [0, 0, 0]));
    module.check('palpa_steered_read', this.steered, this.steering, time_step_s, this.probe);
    this.tick(time_step_s, bits);
    module.check('palpa_steered_write', this.steered, this.command + command_layout.at('force_n'));
  }

  /** A tick at the probe in `probe`; its command is in `command`. */
  tick(time_step_s: number, bits: number): void {
    const { module } = this;
    const from_ms = performance.now();
    module.call('palpa_loop_tick', this.loop, this.probe, time_step_s, bits, this.command, this.tick_at);
    this.spent_ms += performance.now() - from_ms;
    ++this.ticks;
    ++this.spent_in;
    this.t_s += time_step_s;
    const force_n = command_layout.vector(module.view(), this.command, 'force_n');
    this.curve.push(Math.hypot(...force_n));
    this.note_events();
  }

  private note_events(): void {
    const count = Math.min(this.module.call('palpa_loop_events', this.loop, this.events, most_events), most_events);
    const view = this.module.view();
    for (let i = 0; i < count; ++i) {
      const at = this.events + i * event_layout.size;
      const mode = this.facts?.modes[event_layout.get(view, at, 'mode')];
      const value = event_layout.get(view, at, 'value');
      const level = mode?.levels.find((one) => one.value === value);
      const text = this.module.text(at + event_layout.at('text'));
      const subject = text || level?.name || mode?.name || '';
      this.said.push(`${event_words[event_layout.get(view, at, 'kind')]} ${subject}`.trim());
    }
  }

  /** State for a picture since the last one. */
  moment(device: string): Moment {
    const { module } = this;
    const view = module.view();
    const command = (name: 'force_n' | 'coupling_n' | 'proxy_m') => command_layout.vector(view, this.command, name);
    const energy = (name: Parameters<typeof tick_layout.get>[2]) => tick_layout.get(view, this.tick_at, name);
    const moment: Moment = {
      tick: this.ticks,
      t_s: this.t_s,
      probe_m: tick_layout.vector(view, this.tick_at, 'probe_m'),
      proxy_m: command('proxy_m'),
      force_n: command('coupling_n'),
      command_n: command('force_n'),
      guard: guards[command_layout.get(view, this.command, 'guard')] ?? '',
      cause: causes[command_layout.get(view, this.command, 'cause')] ?? '',
      modes_n: this.modes_n(),
      primitives: this.placed(),
      events: this.said,
      force_curve: Float32Array.from(this.curve),
      energy_j: {
        stored: energy('stored_j'), dissipated: energy('dissipated_j'), injected: energy('injected_j'),
        released: energy('released_j'), damper: energy('damper_j'),
      },
      tick_us: (1e3 * this.spent_ms) / Math.max(1, this.spent_in),
      device,
    };
    this.curve = [];
    this.said = [];
    if (this.spent_in > timed_ticks) {
      this.spent_ms /= 2;
      this.spent_in /= 2;
    }
    return moment;
  }

  private modes_n(): Vec3[] {
    return (this.facts?.modes ?? []).slice(0, most_modes).map((_, number): Vec3 => {
      if (this.module.call('palpa_loop_mode', this.loop, number, this.vector) < 0) return [0, 0, 0];
      const view = this.module.view();
      return [0, 8, 16].map((at) => view.getFloat64(this.vector + at, true)) as Vec3;
    });
  }

  private placed(): PlacedPrimitive[] {
    const count = this.module.call('palpa_loop_primitives', this.loop, this.primitives, most_primitives);
    const view = this.module.view();
    return Array.from({ length: Math.min(count, most_primitives) }, (_, i) => {
      const at = this.primitives + i * primitive_layout.size;
      return {
        kind: kinds[primitive_layout.get(view, at, 'kind')],
        mode: primitive_layout.get(view, at, 'mode'),
        position_m: primitive_layout.vector(view, at, 'position_m'),
        direction: primitive_layout.vector(view, at, 'direction'),
        strength_n: primitive_layout.get(view, at, 'strength_n'),
        force_n: primitive_layout.vector(view, at, 'force_n'),
      };
    });
  }

  // ---- recording ----

  /** Records from now on, with a session at rest. */
  record(least_time_step_s: number, device: string): void {
    const folder = 'trace';
    this.module.with_texts([`/${folder}`, device], (at, name) =>
      this.module.check('palpa_loop_record', this.loop, at, least_time_step_s, name),
    );
    this.folder = folder;
    this.ticks = this.t_s = this.spent_ms = this.spent_in = 0;
  }

  /** Ends the recording; its files. */
  end_recording(): { name: string; bytes: Uint8Array }[] {
    if (!this.is_recording) return [];
    this.module.check('palpa_loop_record', this.loop, 0, 0, 0);
    const files = this.module.wasi.take_folder(this.folder);
    this.folder = '';
    return files;
  }
}
