// Ticks of a trace by the module, in node or in a page.

const vectors = { force: 'coupling_n', command: 'force_n', proxy: 'proxy_m' };

/** Difference of the first tick that the module feels otherwise, in words; '': all are equal to the bit. */
function first_difference(page, feeler, ticks) {
  const { probe_layout, command_layout } = page;
  const { module } = feeler;
  for (const tick of ticks) {
    const view = module.view();
    probe_layout.put(view, feeler.probe, 'valid', tick.probe_valid);
    probe_layout.put(view, feeler.probe, 'has_velocity', 1);
    probe_layout.put(view, feeler.probe, 'buttons', tick.buttons);
    probe_layout.put(view, feeler.probe, 'position_m', tick.probe_x_m, tick.probe_y_m, tick.probe_z_m);
    probe_layout.put(view, feeler.probe, 'velocity_m_per_s', tick.probe_velocity_x_m_per_s, tick.probe_velocity_y_m_per_s, tick.probe_velocity_z_m_per_s);
    probe_layout.put(view, feeler.probe, 'turn', 1, 0, 0, 0);
    feeler.tick(tick.dt_s, tick.circumstances);
    for (const [name, field] of Object.entries(vectors)) {
      const unit = name === 'proxy' ? 'm' : 'n';
      const felt = command_layout.vector(module.view(), feeler.command, field);
      const recorded = ['x', 'y', 'z'].map((axis) => tick[`${name}_${axis}_${unit}`]);
      if (felt.some((value, i) => value !== recorded[i])) return `tick ${tick.tick}: ${name} ${felt} against ${recorded}`;
    }
  }
  return '';
}

/** Limits of a trace's device, without motors. */
function limit(page, feeler, device) {
  const { limits_layout } = page;
  const view = feeler.module.view();
  limits_layout.put(view, feeler.limits, 'has_motors', 0);
  limits_layout.put(view, feeler.limits, 'max_force_n', device.max_force_n);
  limits_layout.put(view, feeler.limits, 'max_stiffness_n_per_m', device.max_stiffness_n_per_m);
  limits_layout.put(view, feeler.limits, 'max_damping_ns_per_m', Infinity);
  limits_layout.put(view, feeler.limits, 'continuous_force_n', Infinity);
  limits_layout.put(view, feeler.limits, 'encoder_step_m', device.encoder_step_m);
}

/** Feels traces of a scene, each with its device and ticks, in a new module; the first difference of each in words. With
 * `is_timed` each once more, by code that is compiled by then: time [ms] in the module's ticks. */
export async function feel(page, compiled, { text, files, traces, is_timed }) {
  const feeler = new page.Feeler(await page.Module.make(compiled));
  files.forEach((file) => feeler.give_again(file));
  limit(page, feeler, traces[0].device);
  feeler.open(text);
  const differences = [];
  let time_ms = 0;
  for (const { device, ticks } of traces) {
    limit(page, feeler, device);
    feeler.begin_again();
    differences.push(first_difference(page, feeler, ticks));
    if (!is_timed) continue;
    feeler.moment(''); // sets the time to 0
    feeler.begin_again();
    first_difference(page, feeler, ticks);
    time_ms += feeler.spent_ms;
  }
  return { differences, time_ms };
}
