// Force on the hand over the last seconds, by uPlot.

import uPlot from 'uplot';

const shown_s = 6;
const ticks_per_s = 1000;
const ticks_per_point = 4; // each point is the largest force of so many ticks: no blow is lost

export class ForceCurve {
  private readonly plot: uPlot;
  private readonly time_s: Float64Array;
  private readonly force_n: Float64Array;
  private of_point_n = 0;
  private ticks = 0;
  private was_flat = false;

  constructor(private readonly box: HTMLElement) {
    const count = (shown_s * ticks_per_s) / ticks_per_point;
    this.time_s = Float64Array.from({ length: count }, (_, n) => ((n - count) * ticks_per_point) / ticks_per_s);
    this.force_n = new Float64Array(count);
    this.plot = new uPlot(options(box), [this.time_s, this.force_n], box);
    this.recolor();
  }

  clear(): void {
    this.force_n.fill(0);
    this.draw();
  }

  /** \param force_n  of each tick */
  take(force_n: Float32Array): void {
    const points: number[] = [];
    for (const force of force_n) {
      this.of_point_n = Math.max(this.of_point_n, force);
      if (++this.ticks < ticks_per_point) continue;
      points.push(this.of_point_n);
      this.of_point_n = this.ticks = 0;
    }
    const kept = points.slice(-this.force_n.length);
    if (kept.length === 0) return;
    this.force_n.copyWithin(0, kept.length);
    this.force_n.set(kept, this.force_n.length - kept.length);
  }

  /** Nothing moves in a curve at zero. */
  draw(): void {
    const is_flat = this.force_n.every((force_n) => force_n < 1e-4);
    if (is_flat && this.was_flat) return;
    this.was_flat = is_flat;
    this.plot.setData([this.time_s, this.force_n]);
  }

  resize(): void {
    this.plot.setSize({ width: this.box.clientWidth, height: this.box.clientHeight });
  }

  recolor(): void {
    this.plot.redraw(false);
  }
}

const css = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function options(box: HTMLElement): uPlot.Options {
  const axis = (label: string, size: number): uPlot.Axis => ({
    label,
    labelSize: 16,
    labelFont: '12px system-ui, sans-serif',
    font: '11px system-ui, sans-serif',
    size,
    stroke: () => css('--quiet'),
    grid: { stroke: () => css('--line'), width: 1 },
    ticks: { show: false },
  });
  return {
    width: Math.max(50, box.clientWidth),
    height: Math.max(50, box.clientHeight),
    legend: { show: false },
    cursor: { show: false },
    padding: [10, 12, 0, 0],
    scales: {
      x: { time: false, range: [-shown_s, 0] },
      y: { range: (_, __, most) => [0, Math.max(0.5, 1.1 * most)] },
    },
    axes: [axis('time [s]', 26), axis('force [N]', 34)],
    series: [{}, { stroke: () => css('--accent'), width: 1.5, fill: () => css('--accent-faint'), points: { show: false } }],
  };
}
