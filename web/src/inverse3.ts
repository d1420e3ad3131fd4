// Haply Inverse3 over a WebSocket of the Worker. The module makes and judges every message (palpa/c.h, Inverse3); here are the
// socket, the clock and the order of calls.

import { circumstance } from './feeler';
import type { Module } from './module';

/**
 * One tick, of the probe in the module's memory. bits: circumstances of the device. Returns the address of the guarded force [N],
 * three numbers.
 */
export type Tick = (time_step_s: number, bits: number) => number;

const act = { connect: 1, close: 2, done: 3 }; // PALPA_INVERSE3_…

// Open to the page by its Content-Security-Policy.
const service = 'ws://127.0.0.1:10001';
// Longest message that the module reads, and room for its end.
const most_taken_bytes = (256 << 10) + 4;
const most_given_bytes = 4096; // PALPA_MESSAGE_BYTES
// Of deadlines. Longer: late reactions; shorter: more wake-ups.
const look_interval_ms = 2;
/** Time steps are multiples of it, as a browser's timer. Longer: coarse velocities; shorter: a trace has more gaps. [s] */
export const time_unit_s = 1e-4;
const longest_step_s = 1; // of palpa_loop_tick
// Time step from which the motors have held an old force for too long: the native driver's deadline of an answer, too. Longer: held
// for longer; shorter: a browser's pauses stop the hand.
const late_s = 0.01;
// Of ticks without messages, so that the guard falls and the page shows it. Longer: shown later; shorter: idle work.
const idle_tick_s = 0.02;
// A message that comes sooner after the one before, or that had come before the last request was sent, is answered a millisecond
// later: a service that answers at once would keep a processor busy with ticks that no hand feels, and messages without a request
// come meanwhile, and are refused. Longer: a fast service is felt at half its rate; shorter: idle work.
const shortest_interval_s = 4e-4;
// Advance of the date beyond the timer's by which the machine slept. Longer: a shorter sleep is not found; shorter: a date that is
// set anew costs the force.
const shortest_sleep_ms = 20;

/** Steady clock that runs on while the machine sleeps, where performance.now() may stand still. */
class Clock {
  private timer_ms = performance.now();
  private date_ms = Date.now();
  private slept_ms = 0;

  now_s(): number {
    const timer_ms = performance.now();
    const date_ms = Date.now();
    const slept_ms = date_ms - this.date_ms - (timer_ms - this.timer_ms);
    if (slept_ms > shortest_sleep_ms) this.slept_ms += slept_ms;
    this.timer_ms = timer_ms;
    this.date_ms = date_ms;
    return 1e-3 * (timer_ms + this.slept_ms);
  }
}

/** One device, from `begin` to the end of its connection after `end`; then it may begin anew. */
export class Inverse3 {
  private readonly clock = new Clock();
  private readonly encoder = new TextEncoder();
  private readonly decoder = new TextDecoder();
  private readonly faults = new Map<number, string>(); // static texts of the module, by address
  private readonly fault_at: number;
  private readonly taken: number;
  private readonly given: number;
  private handle = 0;
  private socket: WebSocket | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;
  private begins_anew = false;
  private is_fresh = false; // a message was taken since the last tick
  private is_paced = false; // its answer follows after a millisecond
  private readonly behind_unread = new MessageChannel(); // its markers arrive behind messages that lie unread
  private markers = 0; // on their way
  private taken_s = 0;
  private ticked_s = 0;
  private words = '';

  /** probe: address of a palpa_probe with its size set. failed: the module cannot be called any more. */
  constructor(
    private readonly module: Module,
    private readonly probe: number,
    private readonly tick: Tick,
    private readonly failed: (failure: unknown) => void,
  ) {
    this.fault_at = module.room(4);
    this.taken = module.room(most_taken_bytes);
    this.given = module.room(most_given_bytes);
    this.behind_unread.port1.onmessage = () => (this.markers -= 1);
  }

  /** State in words; '': the device is felt, or not in use. */
  get state(): string {
    return this.words;
  }

  /** Connects to the service, now or after an end that goes on. */
  begin(): void {
    this.begins_anew = this.handle !== 0;
    if (this.handle !== 0) return;
    this.handle = this.module.handle('palpa_inverse3_new', 0);
    this.ticked_s = this.clock.now_s();
    this.timer = setInterval(() => this.guarded(() => this.look()), look_interval_ms);
    this.guarded(() => this.look());
  }

  /** Sends a force of zero at once, then ends the connection: also where the page may not run any more. */
  end(): void {
    this.begins_anew = false;
    if (this.handle === 0) return;
    this.guarded(() => {
      this.module.check('palpa_inverse3_end', this.handle, this.clock.now_s());
      this.follow();
    });
  }

  /** Ends without the module, which cannot be called any more: closes the socket, for a force ends with its connection. */
  abandon(): void {
    const socket = this.socket;
    this.drop();
    socket?.close();
    clearInterval(this.timer);
    this.handle = 0;
  }

  // ---- events ----

  private guarded(body: () => void): void {
    try {
      body();
    } catch (failure) {
      this.abandon();
      this.failed(failure);
    }
  }

  private open(): void {
    let socket: WebSocket;
    try {
      socket = new WebSocket(service);
    } catch {
      return this.lose(); // pages of this browser may not
    }
    socket.onmessage = (event) => this.guarded(() => this.take(typeof event.data === 'string' ? event.data : ''));
    socket.onclose = () => this.guarded(() => this.lose());
    this.socket = socket;
  }

  private drop(): void {
    if (this.socket === null) return;
    this.socket.onmessage = this.socket.onclose = null;
    this.socket = null;
  }

  private lose(): void {
    this.drop();
    this.module.check('palpa_inverse3_take', this.handle, 0, 0, this.clock.now_s());
    this.follow();
  }

  private take(text: string): void {
    const bytes = this.encoder.encodeInto(text, this.module.bytes(this.taken, most_taken_bytes)).written;
    const now_s = this.clock.now_s();
    const is_taken = this.module.call('palpa_inverse3_take', this.handle, this.taken, bytes, now_s) === 0;
    this.is_fresh ||= is_taken;
    const is_early = this.markers > 0 || now_s - this.taken_s < shortest_interval_s;
    this.taken_s = now_s;
    if (this.is_paced) return;
    if (!is_early) return this.work();
    this.is_paced = true;
    setTimeout(() => {
      this.is_paced = false;
      this.guarded(() => this.work());
    }, 1);
  }

  private look(): void {
    if (this.clock.now_s() - this.ticked_s > idle_tick_s) this.feel();
    this.follow();
  }

  private work(): void {
    if (this.is_fresh) this.feel();
    this.follow();
  }

  // ---- ticks and messages ----

  private feel(): void {
    if (this.handle === 0) return;
    const now_s = this.clock.now_s();
    const units = Math.max(1, Math.round((now_s - this.ticked_s) / time_unit_s));
    this.ticked_s += units * time_unit_s;
    const time_step_s = Math.min(units * time_unit_s, longest_step_s);
    this.is_fresh = false;
    this.module.check('palpa_inverse3_read', this.handle, this.probe, this.fault_at, now_s);
    this.words = this.fault();
    const bits = (this.words === '' ? 0 : circumstance.device_fault) | (time_step_s > late_s ? circumstance.late : 0);
    const force_n = this.tick(time_step_s, bits);
    this.module.check('palpa_inverse3_write', this.handle, force_n, this.clock.now_s());
  }

  private fault(): string {
    const at = this.module.view().getUint32(this.fault_at, true);
    if (at === 0) return '';
    const text = this.faults.get(at) ?? this.module.text(at);
    this.faults.set(at, text);
    return text;
  }

  private follow(): void {
    while (this.handle !== 0) {
      const next = this.module.call('palpa_inverse3_look', this.handle, this.clock.now_s());
      if (next < 0) throw this.module.failure();
      if (next === act.connect) this.open();
      else if (next === act.close) this.close();
      else if (next === act.done) return this.finish();
      else break;
    }
    if (this.handle !== 0 && this.socket?.readyState === WebSocket.OPEN) this.send(this.socket);
  }

  private send(socket: WebSocket): void {
    const now_s = this.clock.now_s();
    const bytes = this.module.call('palpa_inverse3_give', this.handle, this.given, most_given_bytes, now_s);
    if (bytes === 0) return;
    socket.send(this.decoder.decode(this.module.bytes(this.given, bytes)));
    this.markers += 1;
    this.behind_unread.port2.postMessage(null);
  }

  private close(): void {
    const socket = this.socket;
    this.drop();
    socket?.close(1000);
    this.module.check('palpa_inverse3_take', this.handle, 0, 0, this.clock.now_s());
  }

  private finish(): void {
    clearInterval(this.timer);
    this.module.call('palpa_inverse3_free', this.handle);
    this.handle = 0;
    this.words = '';
    if (this.begins_anew) this.begin();
  }
}
