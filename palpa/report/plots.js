'use strict';
// Plots with a common time range, and a line at the chosen moment.
const Plots = (() => {
  const dashes = {solid: null, dashed: [7, 3], dotted: [2, 3]};
  const markColors = {onset: 'green', break_through: 'vermilion', limited: 'orange', fault: 'ink'};
  const graphs = [];

  /** Index of the last row not after a time. */
  const rowAt = (rows, time) => {
    let low = 0;
    let high = rows.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (rows[middle][0] <= time) low = middle;
      else high = middle;
    }
    return rows[high][0] <= time ? high : low;
  };

  const drawMarks = (canvas, area, graph) => {
    for (const event of (Report.view && Report.view.events) || []) {
      const x = graph.toDomXCoord(event.t);
      if (!(x >= area.x && x <= area.x + area.w)) continue;
      canvas.fillStyle = Report.color(markColors[event.kind]);
      canvas.globalAlpha = 0.35;
      canvas.fillRect(x - 0.5, area.y, 1, area.h);
      canvas.globalAlpha = 1;
      canvas.fillRect(x - 2, area.y, 4, 4);
    }
  };

  const placeCursor = (one) => {
    const moment = Report.moment();
    if (!moment) return;
    const area = one.graph.getArea();
    const x = one.graph.toDomXCoord(moment.t);
    const seen = x >= area.x - 0.5 && x <= area.x + area.w + 0.5;
    one.cursor.hidden = !seen;
    if (!seen) return;
    one.cursor.style.left = x + 'px';
    one.cursor.style.top = area.y + 'px';
    one.cursor.style.height = area.h + 'px';
  };

  /** Legend with the curves' values at a time. */
  const read = (one, time) => {
    const row = one.plot.rows[rowAt(one.plot.rows, time)];
    one.values.textContent = '';
    one.values.append(Report.element('span', 'time', row[0].toFixed(3) + ' s'));
    one.plot.curves.forEach((curve, i) => {
      const entry = Report.element('span', 'curve');
      const sign = Report.element('span', 'sign ' + curve.stroke);
      sign.style.borderColor = Report.color(curve.color);
      const value = row[i + 1];
      entry.append(sign, curve.name + ' ', Report.element('b', '', value === null ? '–' : Report.digits(value)));
      one.values.append(entry);
    });
  };

  const colorsOf = (plot) => plot.curves.map((curve) => Report.color(curve.color));

  const make = (plot) => {
    const root = document.getElementById('plot-' + plot.id);
    if (!root || plot.rows.length === 0) return;
    const one = {plot, values: document.getElementById('values-' + plot.id), cursor: Report.element('div', 'cursor')};
    const series = {};
    plot.curves.forEach((curve, i) => (series['c' + i] = {strokePattern: dashes[curve.stroke]}));
    one.graph = new Dygraph(root, plot.rows, {
      labels: ['t', ...plot.curves.map((curve, i) => 'c' + i)],
      colors: colorsOf(plot),
      series,
      ylabel: plot.y,
      xlabel: 'time / s',
      legend: 'never',
      includeZero: true,
      strokeWidth: 1.5,
      highlightCircleSize: 3,
      gridLineColor: Report.color('line'),
      axisLineColor: Report.color('line'),
      axisLabelFontSize: 12,
      axes: {y: {axisLabelWidth: 48}},
      underlayCallback: drawMarks,
      drawCallback: () => placeCursor(one),
      highlightCallback: (event, time) => read(one, time),
      unhighlightCallback: () => Report.moment() && read(one, Report.moment().t),
      clickCallback: (event, time) => Report.show(time),
    });
    root.append(one.cursor);
    graphs.push(one);
  };

  const start = () => {
    if (!window.Dygraph || Report.plots.length === 0) return;
    Report.live('plots');
    Report.plots.forEach(make);
    if (graphs.length > 1) Dygraph.synchronize(graphs.map((one) => one.graph), {selection: false, range: false});
    if (!Report.moment()) for (const one of graphs) read(one, one.plot.rows[0][0]);
    Report.onMoment((moment) => {
      for (const one of graphs) {
        placeCursor(one);
        read(one, moment.t);
      }
    });
    Report.onColors(() => {
      for (const one of graphs) {
        const line = Report.color('line');
        one.graph.updateOptions({colors: colorsOf(one.plot), gridLineColor: line, axisLineColor: line});
        if (Report.moment()) read(one, Report.moment().t);
      }
    });
  };

  return {start, graphs};
})();
