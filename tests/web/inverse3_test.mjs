// The page with an Inverse3, on the stand-in for Haply's Inverse Service that the native driver is tested with, in headless
// Chromium: when a force is sent, and that it ends.
//
// node tests/web/inverse3_test.mjs [PART OF A CASE'S NAME]; PALPA_INVERSE3_SERVICE: the stand-in; PALPA_WEB, PALPA: as in
// page_test.mjs; PALPA_SECONDS: of the measurement, 10. Exit code 77: skipped.
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { createInterface } from 'node:readline';
import { check, page_folder, root, run_cases, skip, start_browser, start_server, Visit } from './browser.mjs';
import { Tabs } from './devtools.mjs';

const port = 10001; // that the page's Content-Security-Policy opens
const patience_ms = 90000; // far above any run; only a failure takes it
const palpa = process.env.PALPA ?? path.join(root, 'build/release/bin/palpa');
const stand_in = process.env.PALPA_INVERSE3_SERVICE ?? path.join(root, 'build/release/tests/inverse3_service');
const outside = 'hold 0 -0.09 0', inside = 'hold 0 -0.05 0'; // of the head's face; y leads away from the user

const wait = (time_ms) => new Promise((done) => setTimeout(done, time_ms));

/** The stand-in: commands, and its log. */
class Service {
  static async begin() {
    const service = new Service();
    service.process = spawn(stand_in, [String(port)], { stdio: ['pipe', 'pipe', 'ignore'] });
    service.lines = createInterface({ input: service.process.stdout })[Symbol.asyncIterator]();
    const first = await service.lines.next();
    if (first.done) skip(`port ${port} is in use`);
    return service;
  }
  async tell(...commands) {
    this.process.stdin.write(commands.map((command) => command + '\n').join(''));
    const answers = [];
    for (const command of commands) {
      const answer = JSON.parse((await this.lines.next()).value);
      if (answer.error || answer.ok === false) throw new Error(`${command}: ${JSON.stringify(answer)}`);
      answers.push(answer);
    }
    return answers.at(-1);
  }
  log() {
    return this.tell('log');
  }
  end() {
    this.process.stdin.end();
  }
}

const folder = page_folder();
if (!existsSync(stand_in)) skip(`${stand_in} is not there`);
const server = await start_server(folder);
const browser = await start_browser({draws:false});
const service = await Service.begin();

/** A page that feels the head with the device. */
async function feeling(body, prepare = async () => {}) {
  await service.tell('send paced', 'say', 'power on', 'calibrated on', 'device on', outside);
  const one = await Visit.begin(browser, server.address, { width: 800, height: 600 });
  try {
    await one.is_felt();
    await prepare(one);
    await one.page.selectOption('#device', 'inverse3');
    await touch();
    await body(one);
  } finally {
    await one.end();
  }
}

const choose = (tabs, device) =>
  tabs.value(`document.getElementById('device').value = '${device}'; document.getElementById('device').dispatchEvent(new Event('change'))`);

/** Likewise in a tab that may be hidden. */
async function feeling_in_tabs(body) {
  await service.tell('send paced', 'say', 'power on', 'calibrated on', 'device on', outside);
  const tabs = await Tabs.begin();
  try {
    await tabs.open(server.address);
    if (!(await ends_within(() => tabs.value("!/Loading/.test(document.getElementById('guard')?.textContent ?? 'Loading')"))))
      throw new Error('the page is not loaded');
    await choose(tabs, 'inverse3');
    await touch();
    await body(tabs);
  } finally {
    await tabs.end();
  }
}

/** The hand comes from outside and presses, until the motors make a force. */
async function touch(time_ms = patience_ms) {
  for (const end = Date.now() + time_ms; Date.now() < end; ) {
    await service.tell(outside);
    await wait(1500); // the guard's ramp
    for (let y = -0.09; y <= -0.05; y += 0.002) {
      await service.tell(`hold 0 ${y} 0`);
      await wait(20);
    }
    await service.tell(inside);
    await wait(100);
    if ((await service.log()).force_n > 0.1) return;
  }
  throw new Error('the device makes no force');
}

/** A force is felt and shown, at the latest by the fifth touch: a busy machine's pause costs the one before. */
async function shows_force(one) {
  for (let n = 0; n < 5; ++n) {
    await touch();
    if ((await one.largest_force(500)) > 0.1) return true;
  }
  return false;
}

async function ends_within(condition) {
  for (const end = Date.now() + patience_ms; Date.now() < end; await wait(50)) if (await condition()) return true;
  return false;
}

/** No force from the third message after a fault's first answer on: one message may come between the two commands. */
async function costs_the_force(name, begin, time_ms = 1200) {
  await service.tell('begin', begin);
  await wait(150);
  const soon = await service.log();
  await wait(time_ms);
  const { forces_n, force_n } = await service.log();
  const last = forces_n.findLastIndex((force) => force > 0);
  check(last <= 3 && soon.force_n === 0 && force_n === 0, `${name}: ${last + 1} messages with a force, then none of ${forces_n.length}`);
}

const faults = {
  'no power': ['power off', 'power on'],
  'not calibrated': ['calibrated off', 'calibrated on'],
  'the device leaves': ['device off', 'device on'],
  'the service ends': ['service off', 'service on'],
  'no JSON': ['say {', 'say'],
  'another text': ['say {"inverse3":7}', 'say'],
  'a list too deep': [`say ${'['.repeat(5000)}`, 'say'],
  ...Object.fromEntries(['silent', 'slow', 'drip', 'flood', 'binary', 'huge', 'endless', 'wrong_frame', 'goes_away', 'hangs_up']
    .map((manner) => [`answers: ${manner}`, [`send ${manner}`, 'send paced']])),
};

/**
 * The connection ends, and with it the force; of a page that lives on, behind a message without force. Then none is opened.
 * Returns whether the last message had no force.
 */
async function has_let_go(name, lives_on = true) {
  const has_ended = await ends_within(async () => (await service.log()).connections === 0);
  await service.tell('begin');
  await wait(800);
  const { messages, connections, force_n, last_n } = await service.log();
  check(has_ended && force_n === 0 && (last_n === 0 || !lives_on), `${name}: the last message had ${last_n} N, then the connection ended`);
  check(messages === 0 && connections === 0, `and no message comes: ${messages}`);
  return last_n === 0;
}

async function pause(pid, time_ms) {
  process.kill(pid, 'SIGSTOP');
  await wait(time_ms);
  const paused = await service.log();
  await service.tell('begin');
  process.kill(pid, 'SIGCONT');
  // It may have stood still while it sent one. A busy machine may cost the connection, too.
  await ends_within(async () => (await service.log()).forces_n.length > 10);
  const { forces_n } = await service.log();
  check(paused.force_n === 0, `the motors rest while the page stands still for ${time_ms} ms`);
  check(forces_n.length > 10 && forces_n.slice(1, 11).every((force) => force === 0), `and the ten after the one that was being sent have no force: ${forces_n.slice(0, 11)}`);
}

const worker_of = (one) => one.page.workers().find((worker) => worker.url().endsWith('/worker.js'));

/** Times from a message's event to the answer's sending, in the Worker. */
const note_reactions = (one) => worker_of(one).evaluate(() => {
  let came_ms = 0;
  self.reactions_ms = [];
  const { prototype } = WebSocket;
  const { send } = prototype;
  prototype.send = function (text) {
    if (came_ms > 0) self.reactions_ms.push(performance.now() - came_ms);
    came_ms = 0;
    return send.call(this, text);
  };
  const { set } = Object.getOwnPropertyDescriptor(prototype, 'onmessage');
  Object.defineProperty(prototype, 'onmessage', { set(take) {
    set.call(this, take && ((event) => (came_ms = performance.now(), take(event))));
  } });
});

const cases = {
  'a face is felt': () => feeling(async (one) => {
    check(await shows_force(one), 'the page shows the force');
    check(await ends_within(async () => (await one.text('#device-state')) === ''), 'and no fault of the device');
    await service.tell('power off');
    check(await ends_within(async () => /power supply/.test(await one.text('#device-state'))), 'the page shows the device\'s fault');
    await service.tell('power on');
    await one.picture('inverse3');
  }),

  'every fault costs the force until it is right again': () => feeling(async (one) => {
    for (const [name, [begin, end]] of Object.entries(faults)) {
      await costs_the_force(name, begin);
      await service.tell(end);
      await touch();
    }
    await service.tell('send twice');
    await wait(500);
    await service.tell('send paced');
    check(await shows_force(one), 'it is felt behind all of them');
  }),

  'a hidden page lets go': () => feeling_in_tabs(async (tabs) => {
    check(await ends_within(async () => (await service.log()).connections === 1), 'it is connected'); // a pause may cost a connection
    const before = await service.log();
    await tabs.cover();
    await has_let_go('hidden');
    const { good_byes } = await service.log();
    check(good_byes > before.good_byes, `it was closed in order: ${good_byes - before.good_byes} good-byes`);
    await tabs.freeze(true);
    await has_let_go('frozen');
    await tabs.freeze(false);
    await has_let_go('thawed, but hidden');
    await tabs.uncover();
    await touch();
    check(true, 'in front again it takes the device again');
  }),

  'a page that stands still has no force, nor when it goes on': () => feeling(async (one) => {
    const devtools = await browser.newBrowserCDPSession();
    const { processInfo } = await devtools.send('SystemInfo.getProcessInfo');
    const renderers = processInfo.filter((one) => one.type === 'renderer').sort((a, b) => b.cpuTime - a.cpuTime);
    for (const time_ms of [120, 700, 3000]) {
      await pause(renderers[0].id, time_ms);
      await touch();
    }
    check(await shows_force(one), 'it is felt again');
  }),

  'a page that is left lets go': async () => {
    let in_order = 0; // a busy browser may end the Worker before its last message
    for (const [name, leave] of [
      ['another address', (tabs) => tabs.open('about:blank')],
      ['loaded anew', (tabs) => tabs.send('Page.reload', {}, tabs.session)],
      ['closed', (tabs) => tabs.close_first()],
    ])
      await feeling_in_tabs(async (tabs) => {
        await tabs.value('window.is_left = true');
        await leave(tabs);
        in_order += await has_let_go(name, false);
        if (name !== 'another address') return;
        await tabs.value('history.back()');
        const is_anew = await ends_within(() => tabs.value("document.getElementById('device') !== null && window.is_left === undefined").catch(() => false));
        check(is_anew, 'and Back loads it anew');
      });
    check(in_order >= 2, `${in_order} of 3 wrote zero first`);
  },

  'a page without motors is kept, and felt again': () => feeling_in_tabs(async (tabs) => {
    await choose(tabs, 'mouse');
    await has_let_go('mouse');
    await tabs.value('window.is_left = true');
    await tabs.open('about:blank');
    await wait(500);
    await tabs.value('history.back()');
    const is_felt = await ends_within(async () => {
      if (!(await tabs.value("document.getElementById('marks')?.focus() === undefined").catch(() => false))) return false;
      for (const [key, number] of [['Escape', 27], ['Enter', 13], ['PageDown', 34], ['PageDown', 34]]) {
        await tabs.key(key, number);
        await wait(300);
      }
      return (await tabs.value("parseFloat(document.getElementById('force').textContent)")) > 0.05;
    });
    const is_kept = await tabs.value('window.is_left === true');
    check(is_felt, `Back: it is felt, ${is_kept ? 'as it was' : 'loaded anew, as this browser keeps no pages'}`);
  }),

  'a module that fails lets go': () => feeling(async (one) => {
    await worker_of(one).evaluate(() => {
      const { getUint32 } = DataView.prototype;
      DataView.prototype.getUint32 = () => {
        DataView.prototype.getUint32 = getUint32;
        throw new WebAssembly.RuntimeError('made by the test');
      };
    });
    await wait(200);
    check((await service.log()).force_n === 0, 'the motors rest');
    check(await shows_force(one), 'a new module feels the scene with the device');
  }),

  'another device lets go': () => feeling(async (one) => {
    await one.page.selectOption('#device', 'mouse');
    await has_let_go('mouse');
    await one.page.selectOption('#device', 'inverse3');
    check(await shows_force(one), 'and back');
  }),

  'a recorded touch is replayed natively': () => feeling(async (one) => {
    await one.page.click('#record');
    const is_felt = await touch(10000).then(() => true, () => false);
    console.log(`      recorded ${is_felt ? 'with' : 'without'} a force`);
    const download = one.page.waitForEvent('download');
    await one.page.click('#record');
    const saved = await download;
    const work = mkdtempSync(path.join(tmpdir(), 'palpa-page-'));
    const zip = path.join(work, saved.suggestedFilename());
    await saved.saveAs(zip);
    execFileSync('python3', ['-c', 'import sys, zipfile; zipfile.ZipFile(sys.argv[1]).extractall(sys.argv[2])', zip, work]);
    if (!existsSync(palpa)) console.log(`      not replayed: ${palpa} is not there`);
    else {
      const said = execFileSync(palpa, ['replay', zip.replace('.zip', '')], { encoding: 'utf8' });
      console.log(said.trim().split('\n').slice(0, 4).map((line) => '      ' + line).join('\n'));
      check(/to the bit|identical|equal/i.test(said), 'palpa replay: the same forces, to the bit');
    }
    rmSync(work, { recursive: true });
  }),

  'time from a message to its answer': () => feeling(async (one) => {
    const time_s = Number(process.env.PALPA_SECONDS ?? 10);
    await service.tell('begin');
    await worker_of(one).evaluate(() => (self.reactions_ms = []));
    await wait(1000 * time_s);
    const { messages, reaction_us, force_n } = await service.log();
    const own_ms = await worker_of(one).evaluate(() => self.reactions_ms.sort((a, b) => a - b));
    const own = [['p50', 0.5], ['p99', 0.99], ['p999', 0.999], ['max', 1]].map(([name, share]) => [name, own_ms[Math.floor(share * (own_ms.length - 1))]]);
    const words = (times_ms) => times_ms.map(([name, time_ms]) => `${name} ${time_ms.toFixed(2)} ms`).join(', ');
    console.log(`      ${messages} messages in ${time_s} s at up to 1 kHz; then ${force_n.toFixed(2)} N`);
    console.log(`      in the Worker: ${words(own)}`);
    console.log(`      by the service, with the browser's transport: ${words(Object.entries(reaction_us).map(([name, time_us]) => [name, time_us / 1000]))}`);
    check(messages > 0, 'messages are answered');
  }, note_reactions),
};

const result = await run_cases(cases);
service.end();
await browser.close();
server.end();
process.exit(result);
