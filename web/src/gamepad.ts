// Game controller by the Gamepad API, as the native driver has its sticks: left to the right and towards the user, right up.

import { clamp } from './geometry';
import type { ToWorker, Vec3 } from './protocol';

const dead_share = 0.15; // of a stick. More: small motions are lost; less: the hand drifts

const stick = (axis: number): number => {
  const share = clamp(axis || 0, -1, 1), size = Math.abs(share);
  return size < dead_share ? 0 : (Math.sign(share) * (size - dead_share)) / (1 - dead_share);
};

export class Gamepad {
  private last = '';

  constructor(private readonly send: (message: ToWorker) => void) {}

  /** Reads the first controller; a lost one is at rest. */
  poll(): void {
    const pad = [...navigator.getGamepads()].find((one) => one?.connected && one.mapping === 'standard');
    const share: Vec3 = pad ? [stick(pad.axes[0]), -stick(pad.axes[3]), stick(pad.axes[1])] : [0, 0, 0];
    const held = pad ? pad.buttons.map((button, n) => (button.pressed && n < 16 ? 1 << n : 0)) : [];
    const buttons = held.reduce((all, one) => all | one, 0);
    const now = `${share} ${buttons}`;
    if (now === this.last) return;
    this.last = now;
    this.send({ kind: 'deflection', share, buttons });
  }

  /** The next reading is sent even if it is the same. */
  restart(): void {
    this.last = '';
  }

  static get is_there(): boolean {
    return [...navigator.getGamepads()].some((one) => one?.connected && one.mapping === 'standard');
  }
}
