// The page: one scene, the Worker that feels it, and what a person does.

import { Camera } from './camera';
import { is_dark } from './colors';
import { ForceCurve } from './curve';
import { by_id, element } from './dom';
import { files_of_drop, read_volume, sorted } from './files';
import { Gamepad } from './gamepad';
import { deepest_m, Hand } from './hand';
import { Input } from './input';
import { Marks } from './marks';
import { Panel } from './panel';
import { Picture } from './picture';
import type { FromWorker, Moment, SceneFacts, ToWorker } from './protocol';
import { save_scene, save_trace, trace_name, type TraceFile } from './record';
import { Setter } from './setter';
import { address_of } from './share';
import { Slices } from './slices';
import { Status } from './status';
import { View } from './view';

const said_for_ms = 12_000; // a message
const beat_ms = 16;
// Longer: the hand rests for longer on a page that stays; shorter: a page that is left begins to feel again until it is gone.
const left_after_ms = 2000;

export class App {
  private readonly camera = new Camera();
  private readonly worker: Worker;
  private readonly view: View | null;
  private readonly marks: Marks;
  private readonly hand: Hand;
  private readonly input: Input;
  private readonly slices: Slices;
  private readonly picture: Picture;
  private readonly panel: Panel;
  private readonly curve: ForceCurve;
  private readonly status = new Status();
  private readonly setter: Setter;
  private readonly gamepad: Gamepad;
  private scene: SceneFacts | null = null;
  private scene_name = 'scene.toml';
  private moment: Moment | null = null;
  private is_off = false;
  private is_recording = false;
  private is_file_medical = false; // of the last file
  private recorded_since = new Date();
  private is_text_own = false; // the person is editing the scene's text
  private said_timer = 0;
  private last_beat_ms = 0;
  private readonly shown_ms = new Map<string, number>();

  constructor(worker: Worker) {
    this.worker = worker;
    const send = (message: ToWorker) => worker.postMessage(message);
    this.view = this.new_view();
    this.marks = new Marks(by_id<HTMLCanvasElement>('marks'), this.camera);
    this.hand = new Hand(this.camera, send);
    this.input = new Input(by_id('marks'), this.camera, this.hand, this.marks);
    this.slices = new Slices([...document.querySelectorAll<HTMLCanvasElement>('#slices canvas')]);
    this.picture = new Picture(this.view, this.camera, this.slices, this.hand, send);
    this.setter = new Setter(send);
    this.panel = new Panel(by_id('modes'), (path, value) => this.setter.set(path, value));
    this.curve = new ForceCurve(by_id('curve'));
    this.gamepad = new Gamepad(send);
    worker.onmessage = ({ data }: MessageEvent<FromWorker>) => this.take(data);
    worker.onerror = () => this.say('The part that feels has stopped. Reload the page to go on.');
    this.connect_input();
    this.connect_buttons();
    this.connect_files();
    this.connect_page();
    this.resize();
    this.recolor();
    // The hand does not wait for pictures, which a busy machine draws late.
    setInterval(() => this.beat(performance.now()), beat_ms);
    requestAnimationFrame((now_ms) => this.draw(now_ms));
  }

  /** Opens a scene's text. \param is_medical  its world is that of a patient: left, back, head */
  open(name: string, text: string, is_medical = false): void {
    this.scene_name = name;
    this.picture.is_medical = is_medical;
    this.setter.clear();
    this.send({ kind: 'scene', name, text });
  }

  /** Shows one line; it goes by itself. */
  say(words: string): void {
    by_id('said-words').textContent = words;
    by_id('said').hidden = false;
    clearTimeout(this.said_timer);
    this.said_timer = window.setTimeout(() => (by_id('said').hidden = true), said_for_ms);
  }

  private send(message: ToWorker): void {
    this.worker.postMessage(message);
  }

  private new_view(): View | null {
    const view = new View(by_id('view'), this.camera);
    if (view.can_draw) return view;
    by_id('no-webgl').hidden = false;
    return null;
  }

  // ---- from the Worker ----

  private take(message: FromWorker): void {
    switch (message.kind) {
      case 'ready': break; // the page's start has listened for it
      case 'opened': this.opened(message.scene); break;
      case 'changed': this.changed(message.scene); break;
      case 'field':
        this.picture.take(message);
        this.input.look_again();
        break;
      case 'moment': this.take_moment(message.moment); break;
      case 'file': this.take_file(message.name, message.facts, message.first_scene); break;
      case 'trace': this.keep_trace(message.files); break;
      case 'failed': this.failed(message.of, message.sentence); break;
    }
  }

  private opened(scene: SceneFacts): void {
    this.scene = scene;
    this.moment = null;
    by_id('title').textContent = scene.title || this.scene_name;
    document.title = `${scene.title || this.scene_name} · Palpa`;
    this.is_text_own = false;
    this.show_text(scene);
    this.input.let_go();
    this.picture.begin(scene);
    this.panel.begin(scene);
    this.marks.begin(scene.max_force_n);
    this.status.begin();
    this.curve.clear();
    this.send({ kind: 'turn', rotation: this.camera.rotation() });
    if (this.is_off) this.send({ kind: 'panic', on: true });
    if (scene.warnings.length > 0) this.say(scene.warnings.join(' · '));
    const examples = by_id('examples-box').querySelector('select')!;
    examples.value = this.scene_name;
    if (examples.selectedIndex < 0) examples.value = '';
  }

  private changed(scene: SceneFacts): void {
    this.setter.answered();
    this.scene = scene;
    this.show_text(scene);
    // A slider that is being dragged is ahead of the Worker.
    if (!this.setter.is_waiting) this.panel.update(scene);
    this.picture.update(scene);
  }

  private failed(of: ToWorker['kind'], sentence: string): void {
    this.say(sentence);
    if (of !== 'set') return;
    this.setter.answered();
    if (this.scene) this.panel.update(this.scene);
  }

  private take_moment(moment: Moment): void {
    this.moment = moment;
    this.status.note(moment);
    this.hand.take(moment);
    this.marks.take(moment);
    this.curve.take(moment.force_curve);
  }

  private take_file(name: string, facts: string, first_scene: string): void {
    by_id('facts').textContent = facts;
    by_id('facts-box').hidden = false;
    if (first_scene) this.open(name.replace(/(\.nii)?\.[^.]*$/, '') + '.toml', first_scene, this.is_file_medical);
  }

  private keep_trace(files: TraceFile[]): void {
    save_trace(trace_name(this.recorded_since), files);
    this.say('The trace is in your downloads: unpack it, then palpa replay FOLDER.');
  }

  private show_text(scene: SceneFacts): void {
    if (!this.is_text_own) by_id<HTMLTextAreaElement>('text').value = scene.text;
  }

  // ---- as time passes ----

  private beat(now_ms: number): void {
    const dt_s = (now_ms - this.last_beat_ms) / 1000;
    this.last_beat_ms = now_ms;
    // A hidden page is at rest, and moves nothing.
    if (!document.hidden) this.hand.beat(dt_s);
    if (!document.hidden && by_id<HTMLSelectElement>('device').value === 'controller') this.gamepad.poll();
    if (this.moment && this.is_due('status', now_ms, 120)) this.status.show(this.moment);
  }

  private draw(now_ms: number): void {
    this.marks.draw();
    const { moment } = this;
    if (moment) {
      if (this.is_due('curve', now_ms, 33)) this.curve.draw();
      if (this.is_due('slices', now_ms, 50)) this.slices.show(moment.proxy_m);
    }
    requestAnimationFrame((next_ms) => this.draw(next_ms));
  }

  /** True once in so many milliseconds. */
  private is_due(what: string, now_ms: number, every_ms: number): boolean {
    if (now_ms - (this.shown_ms.get(what) ?? -Infinity) < every_ms) return false;
    this.shown_ms.set(what, now_ms);
    return true;
  }

  // ---- what a person does ----

  private connect_input(): void {
    this.input.on_view = () => {
      this.picture.keep_view();
      this.view?.move();
    };
    this.input.on_view_moves = (moves) => {
      this.send({ kind: 'view_moves', moves });
      if (!moves) this.send({ kind: 'turn', rotation: this.camera.rotation() });
    };
    this.input.on_touch = () => {
      this.marks.forget_trail();
      document.body.classList.add('has-touched');
    };
    this.slices.on_touch = (at_m, begins) => this.hand.lead_to(at_m, begins);
    const press = by_id<HTMLInputElement>('press');
    press.max = String(1000 * deepest_m);
    press.addEventListener('input', () => this.hand.press_from_now_on(press.valueAsNumber / 1000));
    this.hand.on_depth = () => {
      press.value = String(1000 * this.hand.depth_m);
      by_id('press-words').textContent = `${(1000 * this.hand.depth_m).toFixed(1)} mm`;
    };
  }

  private connect_buttons(): void {
    const on = (id: string, action: () => void) => by_id(id).addEventListener('click', action);
    on('off', () => this.set_off(!this.is_off));
    on('record', () => this.set_recording(!this.is_recording));
    on('share', () => void this.share());
    on('said-close', () => (by_id('said').hidden = true));
    const text = by_id<HTMLTextAreaElement>('text');
    on('apply', () => this.open(this.scene_name, text.value, this.picture.is_medical));
    on('keep', () => save_scene(this.scene_name, text.value));
    on('front', () => this.input.look_from([0, 0, 1], [0, 1, 0]));
    on('right', () => this.input.look_from([1, 0, 0], [0, 1, 0]));
    on('above', () => this.input.look_from([0, 1, 0.001], [0, 0, -1]));
    on('whole', () => this.picture.show_all());
    text.addEventListener('input', () => (this.is_text_own = true));
    const check = (id: string, action: (is_on: boolean) => void) => {
      const box = by_id<HTMLInputElement>(id);
      box.addEventListener('change', () => action(box.checked));
    };
    check('primitives', (is_on) => (this.marks.shows_primitives = is_on));
    check('cloud', (is_on) => void this.picture.show_cloud(is_on));
    by_id('device').addEventListener('change', () => this.choose_device());
    const of_slices = by_id<HTMLSelectElement>('slice-field');
    of_slices.addEventListener('change', () => this.picture.slice(of_slices.value));
    this.picture.on_slice_field = (names, shown) => {
      of_slices.replaceChildren(...names.map((name) => element('option', { value: name }, name)));
      of_slices.value = shown;
      of_slices.hidden = names.length < 2;
    };
    this.picture.on_legend = (entries) =>
      by_id('legend').replaceChildren(...entries.map(({ name, color }) => {
        const spot = element('span', { class: 'spot', 'aria-hidden': true });
        spot.style.background = color;
        return element('li', {}, spot, name);
      }));
  }

  private set_off(is_off: boolean): void {
    this.is_off = is_off;
    this.send({ kind: 'panic', on: is_off });
    by_id('off').setAttribute('aria-pressed', String(is_off));
    by_id('off-words').textContent = is_off ? 'Force on' : 'Force off';
  }

  private set_recording(is_on: boolean): void {
    this.is_recording = is_on;
    if (is_on) this.recorded_since = new Date();
    this.send({ kind: 'record', on: is_on });
    by_id('record').setAttribute('aria-pressed', String(is_on));
    by_id('record-words').textContent = is_on ? 'Stop' : 'Record';
  }

  private async share(): Promise<void> {
    if (!this.scene) return;
    try {
      const address = await address_of(this.scene.text, location.href);
      history.replaceState(null, '', address);
      await navigator.clipboard.writeText(address).then(
        () => this.say('The address of this scene is copied. Data from files are not in it.'),
        () => this.say('The address of this scene is in the address bar. Data from files are not in it.'));
    } catch (problem) {
      this.say((problem as Error).message);
    }
  }

  private choose_device(): void {
    const device = by_id<HTMLSelectElement>('device').value as 'mouse' | 'controller' | 'inverse3';
    this.input.let_go();
    this.gamepad.restart();
    this.send({ kind: 'device', device });
    this.send({ kind: 'turn', rotation: this.camera.rotation() });
    if (device === 'controller' && !Gamepad.is_there) this.say('Press a button of the game controller: only then the browser shows it.');
  }

  // ---- files ----

  private connect_files(): void {
    const choose = (id: string, input: string) => {
      const box = by_id<HTMLInputElement>(input);
      by_id(id).addEventListener('click', () => box.click());
      box.addEventListener('change', () => {
        const files = [...(box.files ?? [])];
        box.value = '';
        if (files.length > 0) void this.open_files(async () => files);
      });
    };
    choose('open', 'file');
    choose('open-folder', 'folder');
    const over = (is_over: boolean) => document.body.classList.toggle('is-dropping', is_over);
    window.addEventListener('dragover', (event) => (event.preventDefault(), over(true)));
    window.addEventListener('dragleave', (event) => event.relatedTarget === null && over(false));
    window.addEventListener('drop', (event) => {
      event.preventDefault();
      over(false);
      const drop = event.dataTransfer;
      if (drop) void this.open_files(() => files_of_drop(drop));
    });
  }

  private async open_files(gather: () => Promise<File[]>): Promise<void> {
    by_id('busy').hidden = false;
    try {
      const { scenes, volumes } = await sorted(await gather());
      for (const volume of volumes) {
        const { file, notes } = await read_volume(volume);
        this.is_file_medical = file.medical_frame;
        this.worker.postMessage({ kind: 'file', file } satisfies ToWorker, file.fields.map((field) => field.voxels));
        for (const note of notes) this.say(note);
      }
      if (scenes.length > 0) this.open(scenes[0].name, await scenes[0].text(), volumes.length > 0 && this.is_file_medical);
    } catch (problem) {
      this.say(problem instanceof Error ? problem.message : 'The file cannot be read.');
    } finally {
      by_id('busy').hidden = true;
    }
  }

  // ---- the page ----

  private connect_page(): void {
    const rest = () => {
      this.send({ kind: 'rest' });
      this.input.let_go();
    };
    const wake = () => document.hidden || this.send({ kind: 'wake' });
    document.addEventListener('visibilitychange', () => (document.hidden ? rest() : wake()));
    // At the beginning of a navigation: the Worker sends its last messages while the next page is fetched.
    window.addEventListener('beforeunload', (event) => {
      if (this.is_recording) event.preventDefault(); // the browser asks
      rest();
      setTimeout(wake, left_after_ms);
    });
    // A browser may keep a page that is left, and stop its Worker anywhere: the connection ends with the Worker, and the force
    // with the connection.
    const has_motors = () => by_id<HTMLSelectElement>('device').value === 'inverse3';
    window.addEventListener('pagehide', () => {
      rest();
      if (has_motors()) this.worker.terminate();
    });
    window.addEventListener('pageshow', ({ persisted }) => {
      if (persisted && has_motors()) location.reload();
      else wake();
    });
    window.addEventListener('blur', () => this.input.let_go());
    document.addEventListener('freeze', rest);
    document.addEventListener('resume', wake);
    new ResizeObserver(() => this.resize()).observe(by_id('stage'));
    new ResizeObserver(() => this.curve.resize()).observe(by_id('curve'));
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.recolor());
    window.addEventListener('keydown', (event) => this.key(event));
  }

  private key(event: KeyboardEvent): void {
    const on = event.target as HTMLElement;
    if (event.ctrlKey || event.altKey || event.metaKey || on.closest('textarea, input:not([type=checkbox]), select')) return;
    if (event.key === ' ') {
      // Buttons and boxes have the space key for themselves.
      if (on.closest('button, input, summary, a')) return;
      event.preventDefault();
      return this.set_off(!this.is_off);
    }
    if (event.shiftKey && /^Digit[1-9]$/.test(event.code)) {
      if (this.scene) this.panel.toggle(this.scene, Number(event.code.slice(5)) - 1);
      return;
    }
    const clicks: Record<string, string> = {
      1: 'front', 2: 'right', 3: 'above', Home: 'whole', r: 'record', o: 'open', m: 'primitives', c: 'cloud',
    };
    const id = clicks[event.key];
    if (!id) return;
    event.preventDefault();
    by_id(id).click();
  }

  private resize(): void {
    const stage = by_id('stage');
    if (stage.clientWidth === 0 || stage.clientHeight === 0) return;
    const is_first = this.camera.width_px <= 1;
    this.camera.width_px = stage.clientWidth;
    this.camera.height_px = stage.clientHeight;
    this.marks.resize();
    this.view?.resize();
    this.slices.draw();
    if (is_first) this.picture.show_all();
  }

  private recolor(): void {
    this.view?.set_ground(is_dark() ? '#1b1c1f' : '#fbfbfa');
    this.curve.recolor();
  }
}
