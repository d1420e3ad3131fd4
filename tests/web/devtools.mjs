// Tabs of a headless Chromium that are hidden and frozen as a person's are: by its DevTools protocol over a pipe, for Playwright
// keeps every page visible.
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { chromium_path, no_drawing, switches } from './browser.mjs';

export class Tabs {
  #calls = new Map();
  #number = 0;

  static async begin() {
    const tabs = new Tabs();
    tabs.profile = mkdtempSync(path.join(tmpdir(), 'palpa-tabs-'));
    tabs.process = spawn(chromium_path, ['--headless', ...switches, ...no_drawing, `--user-data-dir=${tabs.profile}`, '--remote-debugging-pipe', 'about:blank'],
      { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
    let rest = '';
    tabs.process.stdio[4].on('data', (bytes) => {
      const messages = (rest + bytes).split('\0');
      rest = messages.pop();
      for (const message of messages) tabs.#take(JSON.parse(message));
    });
    const { targetInfos } = await tabs.send('Target.getTargets');
    tabs.first = targetInfos.find((target) => target.type === 'page').targetId;
    tabs.session = (await tabs.send('Target.attachToTarget', { targetId: tabs.first, flatten: true })).sessionId;
    return tabs;
  }
  #take({ id, result, error }) {
    const call = this.#calls.get(id);
    this.#calls.delete(id);
    if (error) call?.failed(new Error(error.message));
    else call?.done(result);
  }

  /** A method of the protocol; of the first tab with its session. */
  send(method, params = {}, sessionId = undefined) {
    const id = ++this.#number;
    this.process.stdio[3].write(JSON.stringify({ id, method, params, sessionId }) + '\0');
    return new Promise((done, failed) => this.#calls.set(id, { done, failed }));
  }
  /** Value of an expression in the first tab. */
  async value(expression) {
    const { result } = await this.send('Runtime.evaluate', { expression, returnByValue: true }, this.session);
    return result.value;
  }
  /** A key of the first tab. number: its virtual key code. */
  async key(name, number) {
    for (const type of ['keyDown', 'keyUp'])
      await this.send('Input.dispatchKeyEvent', { type, key: name, code: name, windowsVirtualKeyCode: number }, this.session);
  }
  open(address) {
    return this.send('Page.navigate', { url: address }, this.session);
  }
  /** Another tab covers the first. */
  async cover() {
    await this.send('Target.createTarget', { url: 'about:blank' });
  }
  /** The first tab comes to the front again. */
  async uncover() {
    await this.send('Target.activateTarget', { targetId: this.first });
  }
  async freeze(on) {
    await this.send('Page.setWebLifecycleState', { state: on ? 'frozen' : 'active' }, this.session);
  }
  async close_first() {
    await this.send('Target.closeTarget', { targetId: this.first });
  }
  async end() {
    const ended = new Promise((done) => this.process.once('exit', done));
    this.send('Browser.close');
    await ended;
    rmSync(this.profile, { recursive: true, force: true, maxRetries: 5 });
  }
}
