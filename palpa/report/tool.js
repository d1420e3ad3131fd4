'use strict';
// Tool in the interactive view: its feet at the proxy, red by the force on each, and paler at the probe; torques in the table.
// Pages on points are without this script.
(() => {
  const data = Report.view;
  const startView = View3d.start;
  const most = Math.max(1e-3, ...Report.moments.flatMap((moment) => moment.feet.map(([, force]) => force)));
  const red = new THREE.Color('#d7191c');
  let front, feet;
  const shown = {proxy: true, probe: true};

  /** Dot with a rim, for points of any colour. */
  const dot = () => {
    const canvas = document.createElement('canvas');
    canvas.width = canvas.height = 32;
    const pen = canvas.getContext('2d');
    pen.arc(16, 16, 14, 0, 2 * Math.PI);
    pen.fillStyle = '#ffffff';
    pen.fill();
    return new THREE.CanvasTexture(canvas);
  };
  const sprite = window.THREE ? dot() : null;

  const turned = (lever, turn) =>
    new THREE.Vector3(...lever).applyQuaternion(new THREE.Quaternion(turn[1], turn[2], turn[3], turn[0]));

  /** Feet about a place as dots of constant size on the screen. */
  const dots = (at, turn, color, size, opacity) => {
    const positions = [], colors = [];
    data.feet.forEach((lever, foot) => {
      const place = turned(lever, turn);
      positions.push(at[0] + place.x, at[1] + place.y, at[2] + place.z);
      const shade = color(foot);
      colors.push(shade.r, shade.g, shade.b);
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.Float32BufferAttribute(positions, 3));
    geometry.setAttribute('color', new THREE.Float32BufferAttribute(colors, 3));
    return new THREE.Points(geometry, new THREE.PointsMaterial({size: size * Math.min(2, window.devicePixelRatio || 1),
      sizeAttenuation: false, map: sprite, vertexColors: THREE.VertexColors, transparent: true, opacity, depthTest: false,
      depthWrite: false}));
  };

  const makeFeet = (now) => {
    if (feet) {
      front.remove(feet);
      feet.traverse((part) => part.geometry && part.geometry.dispose());
    }
    feet = new THREE.Group();
    front.add(feet);
    if (!now || !now.valid) return;
    const forces = new Map(now.feet);
    const ink = new THREE.Color(Report.color('ink')), grey = new THREE.Color(Report.color('grey'));
    // A foot that bears a little differs from one that bears nothing.
    const share = (force) => (force > 1e-3 ? 0.35 + 0.65 * Math.min(1, force / most) : 0);
    if (shown.probe) feet.add(dots(now.probe, now.probe_turn, () => grey, 5, 0.45));
    if (shown.proxy)
      feet.add(dots(now.proxy, now.proxy_turn, (foot) => ink.clone().lerp(red, share(forces.get(foot) || 0)), 8, 1));
  };

  const tellTorque = (now) => {
    const body = document.querySelector('#moment tbody');
    if (!body) return;
    const row = (name, value) => {
      const line = Report.element('tr');
      line.append(Report.element('th', '', name), Report.element('td', '', Report.digits(value) + ' mN\u00b7m'));
      return line;
    };
    const rows = [row('torque on the hand', now.torque)];
    if (now.coupling_torque !== now.torque) rows.push(row('torque of the coupling', now.coupling_torque));
    body.children[1].after(...rows);
  };

  const makeKey = () => {
    const key = document.getElementById('key');
    const entry = (words, name, color) => {
      const label = Report.element('label'), box = document.createElement('input');
      box.type = 'checkbox';
      box.checked = shown[name];
      box.addEventListener('change', () => {
        shown[name] = box.checked;
        makeFeet(Report.moment());
        redraw();
      });
      const sign = Report.element('span', 'sign bare', '\u25cf');
      sign.style.color = color;
      label.append(box, sign, words);
      key.append(label);
    };
    entry('feet of the tool at the proxy, red by force', 'proxy', '#' + red.getHexString());
    entry('the tool as the hand holds it', 'probe', Report.color('grey'));
  };

  /** Has the view draw again, by the first box of its own key, which stays as it is. */
  const redraw = () => document.querySelector('#key input').dispatchEvent(new Event('change'));

  View3d.start = () => {
    // three.js hands new scenes to its developer tools: the last one is in front of all.
    const tools = new EventTarget();
    tools.addEventListener('observe', (event) => {
      if (event.detail.isScene || event.detail.type === 'Scene') front = event.detail;
    });
    window.__THREE_DEVTOOLS__ = tools;
    startView();
    delete window.__THREE_DEVTOOLS__;
    if (!front) return;
    Report.onMoment((now) => {
      makeFeet(now);
      tellTorque(now);
    });
    Report.onColors(() => {
      makeKey();
      makeFeet(Report.moment());
    });
    makeKey();
  };
})();
