// Modes of the scene: switch, strength and levels, on the histogram of the field.

import { mode_color } from './colors';
import { element } from './dom';
import { Histogram, type ShownLevel } from './histogram';
import type { FieldFacts, ModeFacts, SceneFacts } from './protocol';

export type Change = (path: string, value: number | boolean) => void;

const most_strength_n = 20; // of a slider
const by_slider = (strength_n: number): number => Math.sqrt(Math.min(1, strength_n / most_strength_n));
const of_slider = (share: number): number => Number((most_strength_n * share * share).toPrecision(3));

/** Number box, with a slider beside it. */
interface Knob {
  box: HTMLInputElement;
  slider: HTMLInputElement | null;
}

export class Panel {
  private readonly boxes = new Map<string, HTMLInputElement>();
  private readonly knobs = new Map<string, Knob>();
  private readonly histograms = new Map<string, Histogram>();

  constructor(
    private readonly home: HTMLElement,
    private readonly change: Change,
  ) {}

  /** Builds the panel of a scene. */
  begin(scene: SceneFacts): void {
    this.boxes.clear();
    this.knobs.clear();
    this.histograms.clear();
    this.home.replaceChildren(...scene.modes.map((mode, number) => this.mode_box(mode, number, scene)), this.coupling_box());
    this.update(scene);
  }

  /** Shows changed values. A box that is being typed in stays as it is. */
  update(scene: SceneFacts): void {
    scene.modes.forEach((mode) => {
      const box = this.boxes.get(mode.name);
      if (box) box.checked = mode.enabled;
      this.home.querySelector(`[data-mode="${CSS.escape(mode.name)}"]`)?.classList.toggle('is-off', !mode.enabled);
      if (mode.strength_n !== null) this.show(`mode.${mode.name}.strength_n`, mode.strength_n);
      for (const level of mode.levels) {
        this.show(level.path + '.value', level.value);
        this.show(level.path + '.strength_n', level.strength_n);
      }
    });
    this.show('coupling.stiffness_n_per_m', scene.stiffness_n_per_m);
    this.show('coupling.max_force_n', scene.max_force_n);
    for (const [name, histogram] of this.histograms) histogram.show(levels_of(scene, name));
  }

  toggle(scene: SceneFacts, number: number): void {
    const mode = scene.modes[number];
    if (mode) this.change(`mode.${mode.name}.enabled`, !mode.enabled);
  }

  private mode_box(mode: ModeFacts, number: number, scene: SceneFacts): HTMLElement {
    const box = element('input', { type: 'checkbox', id: `mode-${number}` });
    box.addEventListener('change', () => this.change(`mode.${mode.name}.enabled`, box.checked));
    this.boxes.set(mode.name, box);
    const spot = element('span', { class: 'spot', 'aria-hidden': true });
    spot.style.background = mode_color(number);
    const words = element('label', { for: `mode-${number}` }, spot, mode.name,
      element('span', { class: 'quiet' }, mode.type.replace(/_/g, ' ')));
    const made = element('section', { class: 'mode', 'data-mode': mode.name }, element('header', {}, box, words));
    if (mode.strength_n !== null)
      made.append(this.knob('how firm', `mode.${mode.name}.strength_n`, 'N', mode.strength_n, `${mode.name}: strength in newtons`));
    const field = field_named(scene, mode.field);
    if (field && mode.levels.length > 0) made.append(this.histogram_of(field));
    for (const level of mode.levels) {
      const unit = field?.unit ?? '';
      made.append(element('div', { class: 'level-box' }, element('h4', {}, level.name),
        this.knob('where', level.path + '.value', unit, null, `${level.name}: value of the level`),
        this.knob('how firm', level.path + '.strength_n', 'N', level.strength_n, `${level.name}: strength in newtons`)));
    }
    return made;
  }

  private coupling_box(): HTMLElement {
    return element('section', { class: 'mode' }, element('header', {}, element('h3', {}, 'Spring to the hand')),
      this.knob('stiffness', 'coupling.stiffness_n_per_m', 'N/m', null, 'Stiffness of the spring'),
      this.knob('largest force', 'coupling.max_force_n', 'N', null, 'Largest force in newtons'));
  }

  private histogram_of(field: FieldFacts): HTMLElement | string {
    if (this.histograms.has(field.name)) return '';
    const histogram = new Histogram(field);
    histogram.on_level = (path, value) => this.change(path + '.value', value);
    this.histograms.set(field.name, histogram);
    return histogram.box;
  }

  /** \param strength_n  with a slider; null: a number box alone */
  private knob(words: string, path: string, unit: string, strength_n: number | null, label: string): HTMLElement {
    const box = element('input', { type: 'number', step: 'any', 'aria-label': label });
    box.addEventListener('change', () => {
      if (box.value !== '' && Number.isFinite(box.valueAsNumber)) this.change(path, box.valueAsNumber);
    });
    let slider: HTMLInputElement | null = null;
    if (strength_n !== null) {
      slider = element('input', { type: 'range', min: 0, max: 1, step: 0.01, 'aria-label': label, 'data-path': path });
      slider.addEventListener('input', () => {
        const value = of_slider(slider!.valueAsNumber);
        box.value = String(value);
        this.change(path, value);
      });
    }
    this.knobs.set(path, { box, slider });
    return element('div', { class: 'knob' }, element('span', { class: 'name' }, words), ...(slider ? [slider] : []), box,
      element('span', { class: 'unit' }, unit));
  }

  private show(path: string, value: number): void {
    const knob = this.knobs.get(path);
    if (!knob) return;
    if (document.activeElement !== knob.box) knob.box.value = String(Number(value.toPrecision(4)));
    if (knob.slider && document.activeElement !== knob.slider) knob.slider.value = String(by_slider(value));
  }
}

/** Field of a mode, which may leave out the volume's or the field's name. */
export function field_named(scene: SceneFacts, name: string): FieldFacts | undefined {
  if (name === '') return undefined;
  return scene.fields.find((field) => field.name === name) ??
    scene.fields.find((field) => field.name.startsWith(name + '.') || field.name.endsWith('.' + name));
}

function levels_of(scene: SceneFacts, field: string): ShownLevel[] {
  return scene.modes.flatMap((mode, number) =>
    field_named(scene, mode.field)?.name === field
      ? mode.levels.map(({ path, name, value }) => ({ path, name, value, mode: number }))
      : []);
}
