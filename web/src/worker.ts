// Worker that ticks: at 1 kHz of its own time for a hand without motors, by the service's messages for an Inverse3.

import { circumstance, Feeler, type Sampling, type Steering } from './feeler';
import { Inverse3, time_unit_s } from './inverse3';
import { command_layout } from './layout';
import { Module } from './module';
import type { FromWorker, GivenFile, ToWorker } from './protocol';

const time_step_s = 1e-3;
const wake_ms = 4; // Longer: motions come in bursts; shorter: a browser does not wake more often
const most_due = 64; // ticks of one wake-up; more are dropped: nothing holds a force on the hand
const picture_ms = 15;
const sampling_ms = 6; // of a wake-up. Longer: the hand jerks while a picture is made; shorter: the picture comes late

type Device = (ToWorker & { kind: 'device' })['device'];

class FeelingWorker {
  private feeler: Feeler | null = null;
  private readonly samplings: Sampling[] = []; // in the order of the questions
  private inverse3: Inverse3 | null = null;
  private compiled: WebAssembly.Module | null = null;
  private readonly files = new Map<string, GivenFile>();
  private scene: { name: string; text: string } | null = null; // the last that could be felt
  private readonly steering: Steering = { way_m: [0, 0, 0], share: [0, 0, 0], buttons: 0, put_m: null };
  private device: Device = 'mouse';
  private view_moves = false;
  private rotation: number[] | null = null; // of the view
  private panics = false;
  private resumes = false;
  private rests = false;
  private felt_to_ms = 0;
  private shown_ms = 0;

  async start(): Promise<void> {
    this.compiled = await WebAssembly.compileStreaming(fetch(new URL('palpa.wasm', import.meta.url)));
    await this.begin();
    setInterval(() => this.wake(), wake_ms);
    const { feeler } = this;
    this.send({ kind: 'ready', version: feeler!.module.text(feeler!.module.call('palpa_version')) });
  }

  take(message: ToWorker): void {
    if (!this.feeler) return;
    try {
      this.act(message, this.feeler);
    } catch (failure) {
      this.failed(message.kind, failure);
    }
  }

  private act(message: ToWorker, feeler: Feeler): void {
    switch (message.kind) {
      case 'scene': {
        const scene = feeler.open(message.text);
        this.scene = { name: message.name, text: message.text };
        this.send({ kind: 'opened', scene });
        break;
      }
      case 'file': {
        const given = feeler.give(message.file);
        this.files.set(message.file.name, message.file);
        this.send({ kind: 'file', name: message.file.name, ...given });
        break;
      }
      case 'set': {
        const scene = feeler.set(message.path, message.value);
        if (this.scene) this.scene.text = scene.text;
        this.send({ kind: 'changed', scene });
        break;
      }
      case 'sample': this.samplings.push(feeler.begin_sample(message.field, message.longest)); break;
      case 'device': this.choose(message.device, feeler); break;
      case 'pointer': message.way_m.forEach((way_m, a) => (this.steering.way_m[a] += way_m)); break;
      case 'put': this.steering.put_m = message.position_m; break;
      case 'buttons': this.steering.buttons = message.buttons; break;
      case 'deflection':
        this.steering.share = message.share;
        this.steering.buttons = message.buttons;
        break;
      case 'view_moves': this.view_moves = message.moves; break;
      case 'turn':
        this.rotation = message.rotation;
        this.turn(feeler);
        break;
      case 'panic':
        this.resumes = this.panics && !message.on;
        this.panics = message.on;
        break;
      case 'record': this.record(message.on, feeler); break;
      case 'rest':
        this.inverse3?.end();
        this.rests = true;
        break;
      case 'wake': if (this.device === 'inverse3') this.inverse3?.begin(); break;
    }
    if (message.kind !== 'rest') this.rests = false;
  }

  private choose(device: Device, feeler: Feeler): void {
    this.inverse3?.end();
    this.device = device;
    this.hold(feeler);
  }

  /** Begins the device's hand. */
  private hold(feeler: Feeler): void {
    if (this.device !== 'inverse3') return feeler.begin_steered(this.device);
    feeler.begin_device('palpa_inverse3_limits');
    this.inverse3?.begin();
  }

  /** Turns the axes of a device as the view is turned; the mouse's ways are turned by the page. */
  private turn(feeler: Feeler): void {
    if (this.device !== 'mouse' && feeler.is_open && this.rotation) feeler.turn(this.rotation);
  }

  private record(on: boolean, feeler: Feeler): void {
    if (on) feeler.record(this.device === 'inverse3' ? time_unit_s : time_step_s, `browser, ${this.device}`);
    else this.send({ kind: 'trace', folder: 'trace', files: feeler.end_recording() });
  }

  // ---- ticks ----

  private wake(): void {
    const now_ms = performance.now();
    const { feeler } = this;
    if (feeler) this.sample(feeler, now_ms + sampling_ms);
    if (!feeler?.is_open || this.rests || this.device === 'inverse3') {
      this.felt_to_ms = now_ms;
      if (feeler?.is_open && !this.rests) this.show(feeler, now_ms, this.inverse3?.state ?? '');
      return;
    }
    const due = Math.floor((now_ms - this.felt_to_ms) / (1e3 * time_step_s));
    this.felt_to_ms += 1e3 * time_step_s * due;
    try {
      for (let i = 0; i < Math.min(due, most_due); ++i) this.tick(feeler);
      this.show(feeler, now_ms, '');
    } catch (failure) {
      this.failed('scene', failure);
    }
  }

  /** Goes on with the samplings until a time, at least by a slice. */
  private sample(feeler: Feeler, until_ms: number): void {
    try {
      for (let first = this.samplings[0]; first; first = this.samplings[0]) {
        if (feeler.sample_slice(first)) {
          this.samplings.shift();
          if (feeler.is_of_scene(first)) self.postMessage(first.answer, { transfer: [first.answer.values.buffer] });
        }
        if (performance.now() >= until_ms) return;
      }
    } catch (failure) {
      this.samplings.length = 0;
      this.failed('sample', failure);
    }
  }

  private bits(): number {
    const bits =
      (this.view_moves ? circumstance.view_moves : 0) |
      (this.panics ? circumstance.panic : 0) |
      (this.resumes ? circumstance.resume : 0);
    this.resumes = false;
    return bits;
  }

  private tick(feeler: Feeler): void {
    feeler.steer(this.steering, time_step_s, this.bits());
    this.steering.way_m = [0, 0, 0];
    this.steering.put_m = null;
  }

  /** A tick of the Inverse3; address of its force. */
  private tick_device(feeler: Feeler, no_force: number, step_s: number, bits: number): number {
    if (this.device !== 'inverse3' || this.rests || !feeler.is_open) return no_force;
    feeler.tick(step_s, bits | this.bits());
    return feeler.command + command_layout.at('force_n');
  }

  private show(feeler: Feeler, now_ms: number, device: string): void {
    if (now_ms - this.shown_ms < picture_ms) return;
    this.shown_ms = now_ms;
    const moment = feeler.moment(device);
    self.postMessage({ kind: 'moment', moment } satisfies FromWorker, { transfer: [moment.force_curve.buffer] });
  }

  // ---- failures ----

  /** One line for a failure. After a trap the module is made anew, with its files and the last scene. */
  private failed(of: ToWorker['kind'], failure: unknown): void {
    const words = failure instanceof Error ? failure.message : String(failure);
    this.send({ kind: 'failed', of, sentence: words.split('\n')[0] });
    const is_trap = failure instanceof WebAssembly.RuntimeError || failure instanceof RangeError;
    if (is_trap) void this.begin();
  }

  private async begin(): Promise<void> {
    this.inverse3?.abandon();
    this.feeler = this.inverse3 = null;
    this.samplings.length = 0;
    const module = await Module.make(this.compiled!);
    const feeler = new Feeler(module);
    const no_force = module.room(24);
    module.bytes(no_force, 24).fill(0);
    this.inverse3 = new Inverse3(
      module,
      feeler.probe,
      (step_s, bits) => this.tick_device(feeler, no_force, step_s, bits),
      (failure) => this.failed('device', failure),
    );
    this.hold(feeler);
    for (const file of this.files.values()) feeler.give_again(file);
    if (this.scene) feeler.open(this.scene.text);
    this.turn(feeler);
    this.felt_to_ms = performance.now();
    this.feeler = feeler;
  }

  private send(message: FromWorker): void {
    self.postMessage(message);
  }
}

const worker = new FeelingWorker();
const early: ToWorker[] = [];
self.onmessage = ({ data }: MessageEvent<ToWorker>) => early.push(data);
void worker.start().then(
  () => {
    self.onmessage = ({ data }: MessageEvent<ToWorker>) => worker.take(data);
    early.forEach((message) => worker.take(message));
  },
  (failure: unknown) => self.postMessage({ kind: 'failed', of: 'scene', sentence: `page: the module cannot be loaded: ${String(failure)}; load the page again` } satisfies FromWorker),
);
