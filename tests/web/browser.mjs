// Browser of the page's tests: server, Chromium, what was requested, and what a person does.
import { spawn } from 'node:child_process';
import { existsSync, mkdirSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';

export const root = path.resolve(import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname), '../..');
export const chromium_path = process.env.PALPA_CHROMIUM ?? '/usr/bin/chromium';
export const switches = [
  '--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update',
  '--disable-sync',
];
const software_drawing = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
export const no_drawing = ['--disable-gpu', '--disable-3d-apis'];

/** Ends the test as skipped, with a reason. */
export function skip(reason) {
  console.log(`skipped: ${reason}`);
  process.exit(77);
}

/** Folder of the page, or the end of the test. */
export function page_folder() {
  const folder = path.resolve(process.env.PALPA_WEB ?? path.join(root, 'build/web'));
  if (!existsSync(chromium_path)) skip(`${chromium_path} is not there`);
  if (!existsSync(path.join(root, 'web/node_modules/playwright-core'))) skip('web/node_modules is not there; tools/make-web makes it');
  if (!existsSync(path.join(folder, 'index.html'))) skip(`${folder} has no page; tools/make-web makes it`);
  return folder;
}

/** Server of the page on a free port. */
export async function start_server(folder) {
  const server = spawn('python3', ['-B', path.join(root, 'web/serve.py'), folder, '--port', '0'], { stdio: ['ignore', 'pipe', 'inherit'] });
  const address = await new Promise((done, failed) => {
    server.stdout.once('data', (text) => done(String(text).trim()));
    server.once('exit', () => failed(new Error('serve.py ended')));
  });
  return { address, end: () => server.kill() };
}

/** draws: the picture by software, which takes all cores; false: without WebGL, so without a picture. */
export async function start_browser({ draws = true } = {}) {
  const { chromium } = createRequire(path.join(root, 'web/package.json'))('playwright-core');
  return chromium.launch({ executablePath: chromium_path, args: [...switches, ...(draws ? software_drawing : no_drawing)] });
}

const patience_ms = 180000; // a machine that builds meanwhile, without a graphics card

/** One page, with the complaints and the foreign requests that it made. */
export class Visit {
  static async begin(browser, address, { width = 1000, height = 640, dark = false, touch = false, hash = '' } = {}) {
    const visit = new Visit();
    visit.context = await browser.newContext({
      viewport: { width, height }, colorScheme: dark ? 'dark' : 'light', hasTouch: touch, isMobile: touch, acceptDownloads: true,
    });
    visit.complaints = [];
    visit.foreign = [];
    await visit.context.route('**/*', (route) => {
      const url = route.request().url();
      if (url.startsWith(address) || url.startsWith('blob:' + address.replace(/\/$/, ''))) return route.continue();
      visit.foreign.push(url);
      return route.abort();
    });
    visit.page = await visit.context.newPage();
    visit.page.on('pageerror', (error) => visit.complaints.push(String(error)));
    visit.page.on('console', (message) => {
      if (message.type() === 'error') visit.complaints.push(message.text());
    });
    visit.begun_ms = Date.now();
    await visit.page.goto(address + hash);
    return visit;
  }

  text(selector) {
    return this.page.textContent(selector);
  }

  async is_felt() {
    await this.page.waitForFunction(() => !/Loading/.test(document.getElementById('guard').textContent), null, { timeout: patience_ms });
  }

  /** Place on the picture by shares of its width and height. */
  async at(x, y) {
    const box = await this.page.locator('#marks').boundingBox();
    return [box.x + x * box.width, box.y + y * box.height];
  }

  /** The place where a press touches: the cursor's form says it. */
  async surface() {
    for (let ring = 0; ring < 12; ++ring)
      for (let side = 0; side < Math.max(1, 6 * ring); ++side) {
        const angle = (2 * Math.PI * side) / Math.max(1, 6 * ring);
        const at = await this.at(0.5 + 0.03 * ring * Math.cos(angle), 0.5 + 0.03 * ring * Math.sin(angle));
        await this.page.mouse.move(...at);
        await this.page.waitForTimeout(60);
        if ((await this.page.locator('#marks').evaluate((canvas) => canvas.style.cursor)) === 'pointer') return at;
      }
    throw new Error('no place of the picture can be touched');
  }

  /** Whether a force above so many newtons is shown in time. */
  async feels(least_n = 0.05) {
    const felt = (n) => parseFloat(document.getElementById('force').textContent) > n;
    return this.page.waitForFunction(felt, least_n, { timeout: patience_ms, polling: 50 }).then(() => true, () => false);
  }

  /** Whether something comes to hold in the page in time. */
  async holds(what, argument) {
    return this.page.waitForFunction(what, argument, { timeout: patience_ms }).then(() => true, () => false);
  }

  force() {
    return this.page.locator('#force').evaluate((output) => parseFloat(output.textContent));
  }

  /** Largest force shown within some time. */
  async largest_force(time_ms) {
    let most_n = 0;
    for (const end = Date.now() + time_ms; Date.now() < end; await this.page.waitForTimeout(40)) most_n = Math.max(most_n, await this.force());
    return most_n;
  }

  /** Whether the force falls to nothing within seconds. */
  async rests() {
    const calm = () => parseFloat(document.getElementById('force').textContent) < 0.02;
    return this.page.waitForFunction(calm, null, { timeout: patience_ms }).then(() => true, () => false);
  }

  /** Presses into the surface at a place, and holds; the largest force on the way. */
  async press(at, notches = 4) {
    let most_n = 0;
    await this.page.mouse.move(...at);
    await this.page.mouse.down();
    for (let n = 0; n < notches; ++n) {
      await this.page.mouse.wheel(0, -100);
      most_n = Math.max(most_n, await this.largest_force(250));
    }
    return most_n;
  }

  /** A picture for people to look at, if PALPA_PICTURES names a folder. */
  async picture(name, full = false) {
    const folder = process.env.PALPA_PICTURES;
    if (!folder) return;
    mkdirSync(folder, { recursive: true });
    await this.page.screenshot({ path: path.join(folder, `${name}.png`), fullPage: full });
  }

  async end() {
    await this.context.close();
  }
}

let failures = 0;

export function check(holds, words) {
  console.log(`${holds ? '  ok' : 'FAIL'}  ${words}`);
  if (!holds) ++failures;
}

/** Runs named cases one after the other; a thrown error fails its case alone. */
export async function run_cases(cases) {
  const only = process.argv[2];
  for (const [name, body] of Object.entries(cases)) {
    if (only && !name.includes(only)) continue;
    console.log(name);
    try {
      await body();
    } catch (error) {
      check(false, String(error.stack ?? error).split('\n').slice(0, 3).join(' '));
    }
  }
  console.log(failures === 0 ? 'passed' : `${failures} failed`);
  return failures === 0 ? 0 : 1;
}
