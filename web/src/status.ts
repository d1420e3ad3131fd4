// State of force, guard, energy and device in words.

import { by_id, number_words } from './dom';
import { norm } from './geometry';
import type { Moment } from './protocol';

const shown_events = 4;

const guard_words: Record<string, string> = {
  pass: 'Force on',
  limited: 'Force on, at a limit',
  damped: 'Force on, damped: the energy balance is uneven',
  ramp: 'Force grows',
  waiting: 'No force yet',
  falling: 'Force falls',
  fault: 'No force',
  off: 'Force off',
};

export class Status {
  private readonly events: string[] = [];

  begin(): void {
    this.events.length = 0;
    by_id('events').textContent = '–';
  }

  /** Keeps a moment's events, also of moments that are not shown. */
  note(moment: Moment): void {
    for (const event of moment.events) this.events.push(`${moment.t_s.toFixed(1)} s  ${event}`);
    if (this.events.length > shown_events) this.events.splice(0, this.events.length - shown_events);
  }

  show(moment: Moment): void {
    const force_n = norm(moment.command_n);
    put('force', `${force_n.toFixed(2)} N`);
    const words = guard_words[moment.guard] ?? moment.guard;
    put('guard', moment.cause ? `${words}: ${moment.cause}` : words);
    by_id('guard').dataset.state = moment.guard;
    put('events', this.events.length > 0 ? this.events.slice().reverse().join('\n') : '–');
    const { stored, dissipated, injected, released, damper } = moment.energy_j;
    const mj = (energy_j: number) => number_words(1e3 * energy_j);
    put('energy', `stored ${mj(stored)} · lost ${mj(dissipated)} · damper ${mj(damper)} · released ${mj(released)} · by sampling ${mj(injected)} mJ`);
    put('tick', `${moment.tick_us.toFixed(1)} µs a tick`);
    put('device-state', moment.device);
  }
}

/** Text of an element, if it is another: readers of screens hear changes alone, and nothing is drawn without one. */
function put(id: string, words: string): void {
  const box = by_id(id);
  if (box.textContent !== words) box.textContent = words;
}
