// The page, driven as a person would: by pointer, fingers and keys, in headless Chromium.
//
// node tests/web/page_test.mjs [PART OF A CASE'S NAME]; PALPA_WEB: folder of the page; PALPA: the native program; PALPA_PICTURES:
// folder for pictures. Exit code 77: skipped.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { check, page_folder, root, run_cases, start_browser, start_server, Visit } from './browser.mjs';

const loose_first_touch_ms = 300000; // a busy machine without a graphics card; the time itself is printed
const palpa = process.env.PALPA ?? path.join(root, 'build/release/bin/palpa');

const folder = page_folder();
const server = await start_server(folder);
const browser = await start_browser();
const visit = (options) => Visit.begin(browser, server.address, options);

/** A visit that ends with no complaint and no foreign request. */
async function visiting(options, body) {
  const one = await visit(options);
  try {
    await one.is_felt();
    await body(one);
    check(one.foreign.length === 0, `no request leaves the machine ${one.foreign.join(' ')}`);
    check(one.complaints.length === 0, `the browser has no complaint ${one.complaints.join(' | ')}`);
  } finally {
    await one.end();
  }
}

async function first_touch(options, name) {
  await visiting(options, async (one) => {
    const at = await one.surface();
    await one.press(at);
    check(await one.feels(), 'a force is felt');
    const touch_ms = Date.now() - one.begun_ms;
    console.log(`      first felt force ${touch_ms} ms after the address was opened, with the search for the surface`);
    check(touch_ms < loose_first_touch_ms, 'a force is felt soon');
    check((await one.text('#guard')).startsWith('Force'), 'the state of the force is in words');
    await one.page.waitForTimeout(1200);
    await one.picture(name, options.width < 500);
    await one.page.mouse.up();
    check(await one.rests(), 'after the release there is no force');
  });
}

/** Time from the load to a touch of the middle of the head, as the native film's person does it: without a search. */
async function time_to_touch() {
  const one = await visit({});
  const middle = await one.at(0.5, 0.5);
  await one.page.mouse.move(...middle);
  await one.holds(() => document.getElementById('marks').style.cursor === 'pointer');
  const touchable_ms = Date.now() - one.begun_ms;
  await one.page.mouse.down();
  await one.page.mouse.wheel(0, -300);
  check(await one.feels(0.02), 'a force is felt');
  const touch_ms = Date.now() - one.begun_ms;
  const load_ms = await one.page.evaluate(() => performance.getEntriesByType('navigation')[0].loadEventEnd);
  console.log(`      page loaded after ${Math.round(load_ms)} ms, touchable after ${touchable_ms} ms, force felt after ${touch_ms} ms`);
  check(touch_ms < loose_first_touch_ms, 'a force is felt soon after the load');
  await one.end();
}

const cases = {
  'time to the first touch': time_to_touch,
  'wide, light': () => first_touch({ width: 1440, height: 900 }, 'wide-light'),
  'wide, dark': () => first_touch({ width: 1440, height: 900, dark: true }, 'wide-dark'),
  'narrow, light': () => first_touch({ width: 390, height: 844 }, 'narrow-light'),
  'narrow, dark': () => first_touch({ width: 390, height: 844, dark: true }, 'narrow-dark'),

  'a finger': () => visiting({ width: 390, height: 844, touch: true }, async (one) => {
    const fingers = await one.context.newCDPSession(one.page);
    const touch = (type, points) => fingers.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    const [x, y] = await one.at(0.5, 0.5);
    await touch('touchStart', [[x, y]]);
    for (let n = 0; n < 20; ++n) await touch('touchMove', [[x + n, y]]);
    await one.page.locator('#press').fill('4');
    check(await one.feels(), 'a finger feels a force');
    await touch('touchEnd', []);
    await touch('touchStart', [[x, y], [x + 60, y]]);
    for (let n = 0; n < 10; ++n) await touch('touchMove', [[x - n, y], [x + 60 + n, y]]);
    await touch('touchEnd', []);
    check(await one.rests(), 'two fingers turn and zoom, without a force');
  }),

  'keys alone': () => visiting({}, async (one) => {
    await one.page.waitForTimeout(1500);
    await one.page.locator('#marks').focus();
    for (const key of ['Enter', 'PageDown', 'PageDown', 'PageDown', 'ArrowLeft', 'ArrowLeft']) {
      await one.page.keyboard.press(key);
      await one.page.waitForTimeout(100);
    }
    check(await one.feels(), 'Enter touches, Page Down presses');
    await one.picture('keys');
    await one.page.keyboard.press('Space');
    check((await one.rests()) && (await one.text('#off-words')) === 'Force on', 'Space takes the force away');
    // The hand is behind the surface then, as in the native window: release and press again.
    for (const key of ['Space', 'Escape', 'Enter', 'PageDown', 'PageDown']) {
      await one.page.keyboard.press(key);
      await one.page.waitForTimeout(300);
    }
    check(await one.feels(), 'and brings it back at the next touch');
    await one.page.keyboard.press('Escape');
    for (const key of ['2', '3', '1', 'Home', '+', 'Shift+ArrowLeft', 'm', 'm']) await one.page.keyboard.press(key);
    await one.page.keyboard.press('Shift+1');
    check(await one.holds(() => !document.getElementById('mode-0').checked), 'Shift and 1 switches the first mode off');
  }),

  'a strength and a level change the force': () => visiting({}, async (one) => {
    const at = await one.surface();
    await one.press(at, 4);
    const before_n = await one.largest_force(2000);
    const firm = one.page.locator('input[type=range][data-path$="skin.strength_n"]');
    await firm.focus();
    for (let n = 0; n < 40; ++n) await one.page.keyboard.press('ArrowLeft');
    await one.holds((most_n) => parseFloat(document.getElementById('force').textContent) < most_n, 0.6 * before_n);
    const after_n = await one.largest_force(800);
    check(before_n > 0.1 && after_n < 0.6 * before_n, `less strength, less force: ${before_n} N, then ${after_n} N`);
    const level = one.page.getByRole('slider', { name: 'Level skin' });
    await level.focus();
    for (let n = 0; n < 10; ++n) await one.page.keyboard.press('ArrowRight');
    check(await one.holds(() => /value = -2\d\d/.test(document.getElementById('text').value)), 'the moved level is in the scene\'s text');
    await one.page.mouse.up();
  }),

  'a shared address opens the same scene': () => visiting({}, async (one) => {
    const firm = one.page.locator('input[type=range][data-path$="skin.strength_n"]');
    await firm.focus();
    for (let n = 0; n < 5; ++n) await one.page.keyboard.press('ArrowRight');
    const strength_n = await one.page.locator(`input[type=number][aria-label="${await firm.getAttribute('aria-label')}"]`).inputValue();
    const is_set = (number) => document.getElementById('text').value.includes(`strength_n = ${number}\n`);
    check(await one.holds(is_set, strength_n), `a strength of ${strength_n} N is in the scene's text`);
    await one.page.click('#share');
    await one.page.waitForFunction(() => location.hash.startsWith('#scene='));
    const text = await one.page.inputValue('#text');
    const hash = await one.page.evaluate(() => location.hash);
    console.log(`      an address of ${hash.length} characters`);
    const other = await visit({ hash });
    await other.is_felt();
    check((await other.page.inputValue('#text')) === text, 'the other page has the same text');
    await other.page.evaluate((cut) => (location.hash = cut), hash.slice(0, hash.length / 2));
    await other.page.waitForSelector('#said:not([hidden])');
    check(/damaged/.test(await other.text('#said-words')), 'half an address ends in one line');
    await other.is_felt();
    await other.end();
  }),

  'a recorded touch is replayed natively': () => visiting({}, async (one) => {
    const at = await one.surface();
    await one.page.click('#record');
    await one.press(at, 5);
    for (let n = 0; n < 40; ++n) {
      await one.page.mouse.move(at[0] + n, at[1] + 10 * Math.sin(n / 5));
      await one.page.waitForTimeout(25);
    }
    await one.page.mouse.up();
    const question = one.page.waitForEvent('dialog');
    await one.page.close({ runBeforeUnload: true });
    const dialog = await question;
    check(dialog.type() === 'beforeunload', 'the browser asks before a recording is lost');
    await dialog.dismiss();
    check((await one.press(at)) > 0.05 || (await one.feels()), 'and a page that stays feels on');
    await one.page.mouse.up();
    const download = one.page.waitForEvent('download');
    await one.page.click('#record');
    const saved = await download;
    const name = saved.suggestedFilename();
    check(/^palpa-[\d-]+\.zip$/.test(name), `the file's name has the date: ${name}`);
    const work = mkdtempSync(path.join(tmpdir(), 'palpa-page-'));
    await saved.saveAs(path.join(work, name));
    const unpack = 'import sys, zipfile; zipfile.ZipFile(sys.argv[1]).extractall(sys.argv[2])';
    execFileSync('python3', ['-c', unpack, path.join(work, name), work]);
    if (!existsSync(palpa)) console.log(`      not replayed: ${palpa} is not there`);
    else {
      const said = execFileSync(palpa, ['replay', path.join(work, name.replace('.zip', ''))], { encoding: 'utf8' });
      console.log(said.trim().split('\n').slice(0, 4).map((line) => '      ' + line).join('\n'));
      check(/to the bit|identical|equal/i.test(said), 'palpa replay: the same forces, to the bit');
    }
    rmSync(work, { recursive: true });
  }),

  'every example opens and is drawn': () => visiting({}, async (one) => {
    for (const name of await one.page.locator('#examples-box option').evaluateAll((all) => all.map((option) => option.value).filter(Boolean))) {
      await one.page.selectOption('#examples-box select', name);
      await one.page.waitForFunction((text) => document.getElementById('text').value.includes(text),
        readFileSync(path.join(folder, 'scenes', name), 'utf8').match(/^title = "(.*)"/m)[1], { timeout: 60000 });
      await one.page.waitForTimeout(2500);
      await one.picture('example-' + name.replace('.toml', ''));
      check(!(await one.page.isVisible('#said')), `${name} opens without a complaint`);
    }
  }),

  'a wrong scene ends in one line': () => visiting({}, async (one) => {
    const title = await one.text('#title');
    await one.page.click('text=Scene as text');
    await one.page.fill('#text', 'palpa = 1\n[coupling]\nstiffness_n_per_m = "<img src=x onerror=document.title=1>"\n');
    await one.page.click('#apply');
    await one.page.waitForSelector('#said:not([hidden])');
    check((await one.text('#said-words')).length > 10 && (await one.page.locator('#said img').count()) === 0, 'it is text, not markup');
    check((await one.text('#title')) === title, 'the scene before is still there');
    const at = await one.surface();
    await one.press(at);
    check(await one.feels(), 'and still felt');
    await one.page.mouse.up();
  }),

  'the page is found by name and policy': async () => {
    const answer = await fetch(server.address);
    const policy = answer.headers.get('content-security-policy');
    check(policy.includes("script-src 'self' 'wasm-unsafe-eval'") && policy.includes("frame-ancestors 'none'"), 'the server sends the policy');
    const page = await answer.text();
    check(page.includes('script-src &#x27;self&#x27; &#x27;wasm-unsafe-eval&#x27;'), 'the page has it, too');
    check(answer.headers.get('x-content-type-options') === 'nosniff', 'nosniff');
    check(answer.headers.get('referrer-policy') === 'no-referrer', 'no referrer');
  },

  'a hidden page is at rest': () => visiting({}, async (one) => {
    await one.press(await one.surface(), 5);
    check(await one.feels(), 'a force is felt');
    const sent = await one.page.evaluate(async () => {
      const kinds = [], post = Worker.prototype.postMessage;
      Worker.prototype.postMessage = function (message, ...more) {
        kinds.push(message.kind);
        return post.call(this, message, ...more);
      };
      const show = (hidden) => {
        Object.defineProperty(document, 'hidden', { value: hidden, configurable: true });
        document.dispatchEvent(new Event('visibilitychange'));
      };
      show(true);
      await new Promise((done) => setTimeout(done, 500));
      const while_hidden = [...kinds];
      show(false);
      return while_hidden;
    });
    check(sent[0] === 'rest' && !sent.includes('pointer') && !sent.includes('wake'), `hidden: rest comes first, and no motion: ${sent}`);
    check(await one.rests(), 'shown again: no force, as the hand was let go');
  }),
};

const code = await run_cases(cases);
await browser.close();
server.end();
process.exit(code);
