// Histogram of a field with its levels, which can be dragged, or moved by keys.

import { mode_color } from './colors';
import { element, number_words } from './dom';
import { clamp } from './geometry';
import type { FieldFacts } from './protocol';

export interface ShownLevel {
  path: string;
  name: string;
  value: number;
  mode: number;
}

const css = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export class Histogram {
  readonly box: HTMLElement;
  on_level: (path: string, value: number) => void = () => {};
  private readonly canvas: HTMLCanvasElement;
  private readonly handles = new Map<string, HTMLElement>();
  private levels: ShownLevel[] = [];

  constructor(private readonly field: FieldFacts) {
    this.canvas = element('canvas', { class: 'bars', 'aria-hidden': true });
    const [low, high] = field.range;
    const unit = field.unit ? ` ${field.unit}` : '';
    this.box = element('div', { class: 'histogram' },
      element('div', { class: 'area' }, this.canvas),
      element('div', { class: 'ends' }, element('span', {}, number_words(low) + unit), element('span', {}, number_words(high) + unit)));
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  show(levels: ShownLevel[]): void {
    this.levels = levels;
    for (const [path, handle] of this.handles)
      if (!levels.some((level) => level.path === path)) {
        handle.remove();
        this.handles.delete(path);
      }
    for (const level of levels) this.place(level);
  }

  draw(): void {
    const ratio = window.devicePixelRatio || 1;
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (width === 0) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const painter = this.canvas.getContext('2d')!;
    painter.scale(ratio, ratio);
    painter.fillStyle = css('--bars');
    const { histogram } = this.field, most = Math.log1p(Math.max(...histogram, 1));
    const step = width / Math.max(1, histogram.length);
    histogram.forEach((count, n) => {
      const tall = (height * Math.log1p(count)) / most; // rare values are seen, too
      painter.fillRect(n * step, height - tall, Math.max(1, step - 0.5), tall);
    });
  }

  private place(level: ShownLevel): void {
    const [low, high] = this.field.range;
    let handle = this.handles.get(level.path);
    if (!handle) {
      handle = this.new_handle(level.path);
      this.handles.set(level.path, handle);
      this.canvas.parentElement!.append(handle);
    }
    const share = clamp((level.value - low) / (high > low ? high - low : 1), 0, 1);
    handle.style.left = `${100 * share}%`;
    handle.style.setProperty('--of-mode', mode_color(level.mode));
    handle.setAttribute('aria-label', `Level ${level.name}`);
    handle.setAttribute('aria-valuemin', String(low));
    handle.setAttribute('aria-valuemax', String(high));
    handle.setAttribute('aria-valuenow', String(level.value));
    handle.setAttribute('aria-valuetext', `${number_words(level.value)} ${this.field.unit}`);
    handle.title = `${level.name}: ${number_words(level.value)} ${this.field.unit}`;
    handle.firstElementChild!.textContent = level.name;
    handle.classList.toggle('late', share > 0.6);
  }

  private new_handle(path: string): HTMLElement {
    const handle = element('div', { class: 'level', role: 'slider', tabindex: 0 }, element('span'));
    const [low, high] = this.field.range;
    const change = (value: number) => {
      const level = this.levels.find((one) => one.path === path);
      if (!level) return;
      level.value = clamp(value, low, high);
      this.place(level);
      this.on_level(path, level.value);
    };
    handle.addEventListener('pointerdown', (event) => {
      event.preventDefault();
      handle.focus();
      handle.setPointerCapture(event.pointerId);
    });
    handle.addEventListener('pointermove', (event) => {
      if (!handle.hasPointerCapture(event.pointerId)) return;
      const box = this.canvas.getBoundingClientRect();
      change(low + clamp((event.clientX - box.left) / box.width, 0, 1) * (high - low));
    });
    handle.addEventListener('keydown', (event) => {
      const steps: Record<string, number> = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 };
      const level = this.levels.find((one) => one.path === path);
      if (!(event.key in steps) || !level) return;
      event.preventDefault();
      event.stopPropagation();
      change(level.value + (steps[event.key] * (high - low)) / 200);
    });
    return handle;
  }
}
