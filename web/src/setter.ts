// Changes of parameters on their way to the Worker: one at a time, of each path the newest.

import type { ToWorker } from './protocol';

export class Setter {
  private readonly waiting = new Map<string, string>();
  private is_busy = false;

  constructor(private readonly send: (message: ToWorker) => void) {}

  set(path: string, value: number | boolean): void {
    this.waiting.set(path, typeof value === 'number' ? plain(value) : String(value));
    this.next();
  }

  /** The last change was taken or refused. */
  answered(): void {
    this.is_busy = false;
    this.next();
  }

  clear(): void {
    this.waiting.clear();
    this.is_busy = false;
  }

  get is_waiting(): boolean {
    return this.waiting.size > 0;
  }

  private next(): void {
    const first = this.waiting.entries().next();
    if (this.is_busy || first.done) return;
    const [path, value] = first.value;
    this.waiting.delete(path);
    this.is_busy = true;
    this.send({ kind: 'set', path, value });
  }
}

/** Number of a scene: five digits are more than a slider has. */
const plain = (value: number): string => String(Number(value.toPrecision(5)));
