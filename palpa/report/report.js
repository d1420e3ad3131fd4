'use strict';
// State shared by view and plots: data, chosen moment, colours.
const Report = (() => {
  const json = (id) => {
    const element = document.getElementById(id);
    return element ? JSON.parse(element.textContent) : null;
  };
  const view = json('view-data');
  const plots = json('plots-data') || [];
  const moments = (view && view.moments) || [];
  const listeners = [];
  let chosen = -1;

  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const dark = window.matchMedia('(prefers-color-scheme: dark)');

  /** Index of the moment nearest to a time [s]. */
  const nearest = (time) => {
    let low = 0;
    let high = moments.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (moments[middle].t <= time) low = middle;
      else high = middle;
    }
    return Math.abs(moments[high].t - time) < Math.abs(moments[low].t - time) ? high : low;
  };

  const choose = (number) => {
    if (moments.length === 0) return;
    const next = Math.max(0, Math.min(moments.length - 1, number));
    if (next === chosen) return;
    chosen = next;
    for (const listener of listeners) listener(moments[chosen], chosen);
  };

  return {
    view, plots, moments,
    bytes,
    dark,
    /** Called with each chosen moment. */
    onMoment: (listener) => listeners.push(listener),
    /** Called when the colour scheme changes between light and dark. */
    onColors: (listener) => dark.addEventListener('change', listener),
    choose,
    show: (time) => { if (moments.length > 0) choose(nearest(time)); },
    number: () => chosen,
    moment: () => moments[chosen],
    /** Colour of report.css. */
    color: (name) => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim(),
    element: (tag, name, text) => {
      const element = document.createElement(tag);
      if (name) element.className = name;
      if (text !== undefined) element.textContent = text;
      return element;
    },
    /** Three significant digits. */
    digits: (value) => (value === 0 ? '0' : Math.abs(value) >= 1000 ? value.toFixed(0) : String(+value.toPrecision(3))),
    live: (name) => document.documentElement.classList.add('with-' + name),
  };
})();
