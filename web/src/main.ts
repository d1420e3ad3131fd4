// Start of the page: the Worker first, then the picture.

import type { App } from './app';
import { by_id } from './dom';
import type { FromWorker } from './protocol';
import { scene_of } from './share';

const first_example = 'head_phantom.toml';

async function text_of_example(name: string): Promise<string> {
  const answer = await fetch(`scenes/${name}`);
  if (!answer.ok) throw new Error(`The example ${name} is not there.`);
  return answer.text();
}

async function open_example(app: App, name: string): Promise<void> {
  try {
    app.open(name, await text_of_example(name));
  } catch {
    app.say(`The example ${name} cannot be loaded; is the page's server there?`);
  }
}

/** Opens the scene of the address, else the example. \param first  its text, if it is there already */
async function open_first(app: App, first: Promise<string | null>): Promise<void> {
  try {
    const shared = await scene_of(location.hash);
    if (shared !== null) return app.open('shared.toml', shared);
  } catch (problem) {
    app.say((problem as Error).message);
  }
  const text = await first;
  if (text !== null) app.open(first_example, text);
  else await open_example(app, first_example);
}

/** The Worker compiles the library and the example travels while the page's larger part is loaded. */
async function start(): Promise<void> {
  if (typeof WebAssembly !== 'object') {
    by_id('no-wasm').hidden = false;
    return;
  }
  const worker = new Worker(new URL('worker.js', import.meta.url), { type: 'module' });
  const is_ready = new Promise<void>((done) => {
    const listen = ({ data }: MessageEvent<FromWorker>) => {
      if (data.kind !== 'ready') return;
      worker.removeEventListener('message', listen);
      by_id('version').textContent = data.version;
      done();
    };
    worker.addEventListener('message', listen);
  });
  const first = text_of_example(first_example).catch(() => null);
  const { App } = await import('./app');
  const app = new App(worker);
  const examples = by_id('examples-box').querySelector('select')!;
  examples.addEventListener('change', () => void open_example(app, examples.value));
  window.addEventListener('hashchange', () => void open_first(app, Promise.resolve(null)));
  await is_ready;
  await open_first(app, first);
}

void start();
