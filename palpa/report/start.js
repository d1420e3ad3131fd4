'use strict';
// Time bar, links to moments, initial moment.
(() => {
  const get = (id) => document.getElementById(id);
  const slider = get('time');

  Plots.start();
  View3d.start();
  if (Report.moments.length === 0) return;
  Report.live('time');

  slider.max = Report.moments.length - 1;
  slider.addEventListener('input', () => Report.choose(+slider.value));
  Report.onMoment((moment, number) => {
    slider.value = number;
    get('now').textContent = moment.t.toFixed(3) + ' s';
  });

  const times = Report.view.events.map((event) => event.t);
  const now = () => Report.moment().t;
  const hair = 1e-6;
  get('before').addEventListener('click', () => {
    const earlier = times.filter((time) => time < now() - hair);
    if (earlier.length > 0) Report.show(Math.max(...earlier));
  });
  get('after').addEventListener('click', () => {
    const later = times.filter((time) => time > now() + hair);
    if (later.length > 0) Report.show(Math.min(...later));
  });
  get('before').hidden = get('after').hidden = times.length === 0;

  // Plays at recorded speed, from the start if the end was reached.
  let began = null;
  const step = (clock) => {
    if (began === null) return;
    const last = Report.moments[Report.moments.length - 1].t;
    const time = began.time + (clock - began.clock) / 1000;
    Report.show(time);
    if (time >= last) stop();
    else requestAnimationFrame(step);
  };
  const stop = () => {
    began = null;
    get('play').textContent = '\u25b6';
  };
  get('play').addEventListener('click', () => {
    if (began !== null) return stop();
    const atEnd = Report.number() === Report.moments.length - 1;
    began = {time: atEnd ? Report.moments[0].t : now(), clock: performance.now()};
    get('play').textContent = '\u23f8';
    requestAnimationFrame(step);
  });

  for (const link of document.querySelectorAll('a[data-time]')) {
    link.addEventListener('click', () => Report.show(+link.dataset.time));
  }
  const first = Report.view.first_look_s;
  if (first === undefined) Report.choose(0);
  else Report.show(first);
})();
