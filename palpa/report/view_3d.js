'use strict';
// Interactive view of the scene with the hand's path: millimetres of the hand frame, parallel projection.
const View3d = (() => {
  const data = Report.view;
  const vector = (a) => new THREE.Vector3(a[0], a[1], a[2]);
  /** Light scheme: towards dark, as in pictures; dark scheme: towards light, so that the largest force stands out. */
  const nightForces = ['#5d5a66', '#8a2a6b', '#c93a4a', '#ee7a2e', '#f9bd4a', '#fff3c4'];
  const forceColors = () => (Report.dark.matches ? nightForces : data.force_colors);
  const eventSigns = {
    onset: {letter: '\u25b2', color: 'green', words: 'onset'},
    break_through: {letter: '\u2716', color: 'vermilion', words: 'break-through'},
    limited: {letter: '\u25a0', color: 'orange', words: 'limited by the guard'},
    fault: {letter: '\u25c6', color: 'ink', words: 'fault'},
  };
  const mostLetters = 40;  // events drawn as letters. More: they cover the scene; fewer: dots, distinguished by colour only
  const dots = data && data.events.length > mostLetters;
  let stage, renderer, camera, controls, scene, front, moment, mostN;
  const lineMaterials = [];
  const groups = {};

  const hasWebGl = () => {
    try {
      return !!document.createElement('canvas').getContext('webgl');
    } catch (error) {
      return false;
    }
  };

  /** Lamps fixed to the camera: above left, and a weak one at the right. */
  const addLights = (to) => {
    to.add(new THREE.AmbientLight(0xffffff, 0.42));
    for (const [x, y, z, strength] of [[-0.5, 0.7, 1, 0.55], [0.8, -0.3, 0.7, 0.22]]) {
      const lamp = new THREE.DirectionalLight(0xffffff, strength);
      lamp.userData.seat = new THREE.Vector3(x, y, z);
      to.add(lamp);
      to.userData.lamps = (to.userData.lamps || []).concat(lamp);
    }
  };

  const between = (hexes, share) => {
    const at = Math.max(0, Math.min(1, share)) * (hexes.length - 1);
    const i = Math.min(hexes.length - 2, Math.floor(at));
    return new THREE.Color(hexes[i]).lerp(new THREE.Color(hexes[i + 1]), at - i);
  };
  const forceColor = (force) => between(forceColors(), mostN > 0 ? force / mostN : 0);

  const unpacked = (layer) => {
    const steps = new Uint16Array(Report.bytes(layer.points).buffer);
    const points = new Float32Array(steps.length);
    for (let i = 0; i < steps.length; ++i) points[i] = layer.low[i % 3] + layer.step * steps[i];
    return points;
  };

  const surface = (layer, number) => {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(unpacked(layer), 3));
    const corners = Report.bytes(layer.triangles).buffer;
    geometry.setIndex(new THREE.BufferAttribute(layer.wide ? new Uint32Array(corners) : new Uint16Array(corners), 1));
    if (layer.normals) {
      const normals = Float32Array.from(new Int8Array(Report.bytes(layer.normals).buffer), (n) => n / 127);
      geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3));
    } else {
      geometry.computeVertexNormals();
    }
    if (layer.colors) {
      const colors = Float32Array.from(Report.bytes(layer.colors), (c) => c / 255);
      geometry.setAttribute('color', new THREE.BufferAttribute(colors, 3));
    }
    const group = new THREE.Group();
    const add = (material, order) => {
      const mesh = new THREE.Mesh(geometry, material);
      mesh.renderOrder = order;
      group.add(mesh);
    };
    // Pushed back a little: the path on the surface would otherwise intersect its triangles.
    const place = {side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 4000};
    if (layer.colors) {
      add(new THREE.MeshBasicMaterial({...place, vertexColors: THREE.VertexColors}), 0);
      return group;
    }
    const material = new THREE.MeshPhongMaterial({...place, color: layer.color, shininess: 14, specular: 0x161616});
    if (layer.opacity < 1) {
      // Depth first, without colour; then only the front passes, denser where it turns away.
      add(new THREE.MeshBasicMaterial({...place, colorWrite: false, transparent: true}), 1000 - 10 * number);
      Object.assign(material, {transparent: true, opacity: layer.opacity});
      material.onBeforeCompile = (shader) => {
        shader.fragmentShader = shader.fragmentShader.replace('#include <normal_fragment_maps>',
          '#include <normal_fragment_maps>\nfloat aside = 1.0 - min(abs(normal.z), 1.0);\n' +
          'diffuseColor.a = mix(opacity, max(opacity, 0.85), aside * aside * aside);\n');
      };
    }
    add(material, layer.opacity < 1 ? 1001 - 10 * number : 0);
    return group;
  };

  /** Thick line segments with a colour at each end. */
  const thickLines = (positions, colors, width) => {
    const geometry = new THREE.LineSegmentsGeometry();
    geometry.setPositions(positions);
    geometry.setColors(colors);
    const material = new THREE.LineMaterial({linewidth: width, vertexColors: THREE.VertexColors});
    lineMaterials.push(material);
    return new THREE.LineSegments2(geometry, material);
  };

  const lineBundle = (layer) => {
    const points = unpacked(layer);
    const colors = layer.colors ? Report.bytes(layer.colors) : null;
    const plain = new THREE.Color(layer.color);
    const positions = [], shades = [];
    let at = 0;
    const put = (i) => {
      positions.push(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
      if (colors) shades.push(colors[3 * i] / 255, colors[3 * i + 1] / 255, colors[3 * i + 2] / 255);
      else shades.push(plain.r, plain.g, plain.b);
    };
    for (const count of layer.lines) {
      for (let i = at; i + 1 < at + count; ++i) {
        put(i);
        put(i + 1);
      }
      at += count;
    }
    return thickLines(positions, shades, 1.8);
  };

  /** Path of probe or proxy; `color`: function of a point. */
  const path = (column, width, color) => {
    const positions = [], shades = [];
    for (const stretch of data.path) {
      for (let i = 0; i + 1 < stretch.length; ++i) {
        for (const point of [stretch[i], stretch[i + 1]]) {
          const shade = color(point);
          positions.push(...point[column]);
          shades.push(shade.r, shade.g, shade.b);
        }
      }
    }
    return thickLines(positions, shades, width);
  };

  const makePaths = () => {
    for (const name of ['proxy', 'probe']) {
      const seen = groups[name] ? groups[name].visible : true;
      if (groups[name]) scene.remove(groups[name]);
      const grey = new THREE.Color(Report.color('grey'));
      groups[name] = name === 'proxy' ? path(2, 3.5, (point) => forceColor(point[3])) : path(1, 1.4, () => grey);
      groups[name].visible = seen;
      scene.add(groups[name]);
    }
    // Without contact both paths coincide: the proxy's is on top.
    Object.assign(groups.probe.material, {polygonOffset: true, polygonOffsetUnits: 1000});
  };

  const makeEvents = () => {
    for (const [kind, sign] of Object.entries(eventSigns)) {
      const events = data.events.filter((event) => event.kind === kind);
      const seen = groups[kind] ? groups[kind].visible : true;
      if (groups[kind]) front.remove(groups[kind]);
      if (events.length === 0) continue;
      const canvas = document.createElement('canvas');
      canvas.width = canvas.height = 64;
      const pen = canvas.getContext('2d');
      pen.font = '44px "DejaVu Sans", sans-serif';
      pen.textAlign = 'center';
      pen.textBaseline = 'middle';
      pen.lineWidth = 8;
      pen.strokeStyle = Report.color('ground');
      pen.fillStyle = Report.color(sign.color);
      if (dots) {
        pen.arc(32, 32, 26, 0, 2 * Math.PI);
        pen.stroke();
        pen.fill();
      } else {
        pen.strokeText(sign.letter, 32, 34);
        pen.fillText(sign.letter, 32, 34);
      }
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.Float32BufferAttribute([].concat(...events.map((event) => event.at)), 3));
      groups[kind] = new THREE.Points(geometry, new THREE.PointsMaterial({size: (dots ? 5 : 15) * renderer.getPixelRatio(), sizeAttenuation: false,
        map: new THREE.CanvasTexture(canvas), transparent: true, depthTest: false, depthWrite: false}));
      groups[kind].visible = seen;
      front.add(groups[kind]);
    }
  };

  // The moment: of constant size on the screen.

  const height = () => (camera.top - camera.bottom) / camera.zoom;
  const solid = (color) => new THREE.MeshPhongMaterial({color, shininess: 10, specular: 0x111111});
  const ball = (at, radius, color) => {
    const mesh = new THREE.Mesh(new THREE.SphereBufferGeometry(radius, 24, 16), solid(color));
    mesh.position.copy(at);
    return mesh;
  };
  const along = (mesh, direction) => {
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), direction.clone().normalize());
    return mesh;
  };
  const rod = (from, to, radius, color) => {
    const way = to.clone().sub(from);
    const mesh = new THREE.Mesh(new THREE.CylinderBufferGeometry(radius, radius, Math.max(way.length(), 1e-6), 16), solid(color));
    mesh.position.copy(from).addScaledVector(way, 0.5);
    return way.length() > 0 ? along(mesh, way) : mesh;
  };
  const arrow = (from, to, radius, color) => {
    const group = new THREE.Group();
    const way = to.clone().sub(from);
    const head = Math.min(5 * radius, 0.6 * way.length());
    const neck = to.clone().addScaledVector(way.clone().normalize(), -head);
    const cone = new THREE.Mesh(new THREE.ConeBufferGeometry(2.3 * radius, head, 20), solid(color));
    cone.position.copy(neck).addScaledVector(way.clone().normalize(), 0.5 * head);
    group.add(rod(from, neck, radius, color), along(cone, way));
    return group;
  };
  const disc = (at, normal, radius, color, opacity) => {
    const mesh = new THREE.Mesh(new THREE.CylinderBufferGeometry(radius, radius, 0.02 * radius, 64),
      new THREE.MeshPhongMaterial({color, opacity, transparent: true, depthWrite: false, shininess: 5}));
    mesh.position.copy(at);
    return along(mesh, normal);
  };

  const makeMoment = () => {
    const now = Report.moment();
    if (moment) {
      front.remove(moment);
      moment.traverse((part) => part.geometry && part.geometry.dispose());
    }
    moment = new THREE.Group();
    front.add(moment);
    if (!now || !now.valid) return;
    const unit = 0.5 * height();
    const proxy = vector(now.proxy), probe = vector(now.probe);
    if (groups.primitives === undefined || groups.primitives.visible) {
      const most = Math.max(1e-3, ...now.primitives.map((primitive) => primitive.force));
      for (const primitive of now.primitives) {
        const color = data.modes[primitive.mode] ? data.modes[primitive.mode].color : Report.color('grey');
        const at = vector(primitive.at), q = vector(primitive.along);
        const share = primitive.force / most;
        if (primitive.kind === 'plane' || primitive.kind === 'facet') {
          moment.add(disc(at, q, 0.13 * unit, color, primitive.force < 1e-3 ? 0.18 : 0.42));
          moment.add(arrow(at, at.clone().addScaledVector(q, (0.06 + 0.14 * share) * unit), 0.006 * unit, color));
        } else if (primitive.kind === 'line') {
          const half = q.clone().multiplyScalar(0.2 * unit);
          moment.add(rod(at.clone().sub(half), at.clone().add(half), 0.006 * unit, color));
        } else if (primitive.kind === 'point') {
          moment.add(ball(at, 0.02 * unit, color));
        } else if (q.length() > 0) {
          moment.add(arrow(at, at.clone().addScaledVector(q.normalize(), (0.08 + 0.16 * share) * unit), 0.008 * unit, color));
        }
      }
    }
    moment.add(rod(proxy, probe, 0.0045 * unit, Report.color('grey')));
    moment.add(ball(proxy, 0.014 * unit, Report.color('ink')), ball(probe, 0.014 * unit, Report.color('grey')));
    const force = vector(now.force);
    if (mostN > 0 && force.length() > 1e-3 && (!groups.force || groups.force.visible)) {
      const color = '#' + forceColor(force.length()).getHexString();
      moment.add(arrow(probe, probe.clone().addScaledVector(force, (0.3 * unit) / mostN), 0.01 * unit, color));
    }
  };

  /** Force of a primitive: of its strength, or split into strength and drag, or of a level that cannot be pressed through. */
  const forceWords = (primitive) => {
    const {force, strength, drag} = primitive;
    const round = (newtons) => Math.round(1e3 * newtons) / 1e3;
    if (primitive.holds) return Report.digits(force) + ' N (it holds)';
    if (!drag || round(force) <= round(strength))
      return Report.digits(force) + (strength > 0 ? ' of ' + Report.digits(strength) : '') + ' N';
    if (!(strength > 0)) return Report.digits(force) + ' N (drag)';
    const decimals = force < 0.1 ? 3 : 2;
    const whole = force.toFixed(decimals), hold = strength.toFixed(decimals);
    return whole + ' N (' + hold + ' strength + ' + (whole - hold).toFixed(decimals) + ' drag)';
  };

  const tellMoment = (now) => {
    const root = document.getElementById('moment');
    root.textContent = '';
    const table = Report.element('table'), body = Report.element('tbody');
    const row = (name, value, color) => {
      const line = Report.element('tr'), head = Report.element('th');
      if (color) {
        const dot = Report.element('span', 'dot');
        dot.style.background = color;
        head.append(dot);
      }
      head.append(name);
      line.append(head, Report.element('td', '', value));
      body.append(line);
    };
    const got = vector(now.force).length();
    row('time', now.t.toFixed(3) + ' s');
    row('force on the hand', Report.digits(got) + ' N');
    if (now.asked !== undefined) row('requested, before the guard', Report.digits(now.asked) + ' N');
    row('proxy from probe', Report.digits(vector(now.proxy).distanceTo(vector(now.probe))) + ' mm');
    for (const primitive of now.primitives) {
      const mode = data.modes[primitive.mode] || {name: 'mode ' + primitive.mode, color: Report.color('grey')};
      row(mode.name + ': ' + (primitive.kind === 'directed' ? 'directed force' : primitive.kind), forceWords(primitive), mode.color);
    }
    table.append(body);
    root.append(table);
    if (now.primitives.length === 0) root.append(Report.element('p', '', now.valid ? 'No contact here: no primitives.'
      : 'The position of the hand is not known here.'));
  };

  // Key.

  const bar = (title, colors, low, high) => {
    const root = Report.element('div', 'bar');
    const strip = Report.element('i');
    strip.style.background = 'linear-gradient(to right, ' + colors.join(', ') + ')';
    const ends = Report.element('span');
    ends.append(Report.element('span', '', Report.digits(low)), Report.element('span', '', title), Report.element('span', '', Report.digits(high)));
    root.append(strip, ends);
    return root;
  };

  const makeKey = () => {
    const key = document.getElementById('key');
    key.textContent = '';
    const entry = (words, objects, style, letter) => {
      const label = Report.element('label'), box = document.createElement('input');
      box.type = 'checkbox';
      box.checked = objects.every((object) => object.visible);
      box.addEventListener('change', () => {
        for (const object of objects) object.visible = box.checked;
        makeMoment();
        draw();
      });
      const sign = Report.element('span', letter ? 'sign bare' : 'sign', letter);
      Object.assign(sign.style, style);
      label.append(box, sign, words);
      key.append(label);
    };
    const named = new Map();
    data.layers.forEach((shape, i) => {
      if (!named.has(shape.layer)) named.set(shape.layer, {shape, objects: []});
      named.get(shape.layer).objects.push(groups['layer' + i]);
    });
    const explained = ({shape}) => shape.bar === undefined;  // by its colour alone
    for (const {shape, objects} of [...named.values()].sort((a, b) => explained(b) - explained(a))) {
      const one = data.bars[shape.bar];
      const shades = one ? one.points : [[0, shape.color]];
      entry(shape.words || (one ? one.title.split(' / ')[0] : 'data'), objects, {background: shades[shades.length >> 1][1]});
    }
    for (const one of data.bars) {
      const points = one.points;
      key.append(bar(one.title, points.map((point) => point[1]), points[0][0], points[points.length - 1][0]));
    }
    if (data.cloud) key.append(Report.element('p', 'hint', 'A cloud is drawn in the picture only.'));
    entry('path of the proxy', [groups.proxy], {background: '#' + forceColor(0.5 * mostN).getHexString()});
    if (mostN > 0) key.append(bar('force on the hand / N', forceColors(), 0, mostN));
    entry('path of the probe (the hand)', [groups.probe], {background: Report.color('grey')});
    for (const [kind, sign] of Object.entries(eventSigns)) {
      if (!groups[kind]) continue;
      const count = data.events.filter((event) => event.kind === kind).length;
      entry(sign.words + ' (' + count + ')', [groups[kind]], {color: Report.color(sign.color)}, dots ? '\u2022' : sign.letter);
    }
    entry('force on the hand, now', [groups.force], {color: '#' + forceColor(mostN).getHexString()}, '\u2192');
    if (data.moments.some((one) => one.primitives.length > 0))
      entry('primitives, in the colours below', [groups.primitives], {color: data.modes[0] ? data.modes[0].color : ''}, '\u25d1');
  };

  const makeSigns = () => {
    const scale = Report.element('div', 'scale');
    scale.append(Report.element('span'), Report.element('i'));
    const compass = Report.element('div', 'compass');
    const letters = data.medical ? [['R', 'L'], ['A', 'P'], ['I', 'S']] : [['', 'x'], ['', 'y'], ['', 'z']];
    letters.forEach((pair, axis) => {
      for (const end of [0, 1]) {
        if (!pair[end]) continue;
        const arm = Report.element('i'), letter = Report.element('span', '', pair[end]);
        compass.append(arm, letter);
        arm.signOf = letter.signOf = vector(data.axes[axis]).multiplyScalar(end === 1 ? 1 : -1);
      }
    });
    stage.append(scale, compass);
  };

  const length = (metres) => {
    if (data.file_unit_m) return Report.digits(metres / data.file_unit_m) + ' file units';
    const units = [[1e3, 'km'], [1, 'm'], [1e-3, 'mm'], [1e-6, '\u00b5m'], [1e-9, 'nm']];
    const [size, name] = units.find(([least]) => metres >= 0.9999 * least) || units[units.length - 1];
    return Report.digits(metres / size) + ' ' + name;
  };

  const drawSigns = () => {
    const worldPerPx = (height() / stage.clientHeight) * 1e-3 * data.world_per_hand;
    const most = 0.2 * stage.clientWidth * worldPerPx;
    const power = Math.pow(10, Math.floor(Math.log10(most)));
    const round = power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
    const scale = stage.querySelector('.scale');
    scale.children[0].textContent = length(round);
    scale.children[1].style.width = round / worldPerPx + 'px';
    const reach = 26;
    for (const part of stage.querySelector('.compass').children) {
      const seen = part.signOf.clone().transformDirection(camera.matrixWorldInverse);
      const x = reach * seen.x, y = -reach * seen.y;
      if (part.tagName === 'SPAN') {
        part.style.left = 1.35 * x + 'px';
        part.style.top = 1.35 * y + 'px';
        part.style.opacity = seen.z < -0.2 ? 0.45 : 1;
      } else {
        part.style.width = Math.hypot(x, y) + 'px';
        part.style.transform = 'rotate(' + Math.atan2(y, x) + 'rad)';
      }
    }
  };

  let waiting = false;
  const draw = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      camera.updateMatrixWorld();
      for (const lit of [scene, front])
        for (const lamp of lit.userData.lamps) lamp.position.copy(lamp.userData.seat).applyQuaternion(camera.quaternion);
      renderer.clear();
      renderer.render(scene, camera);
      renderer.clearDepth();
      renderer.render(front, camera);
      drawSigns();
    });
  };

  // Viewpoint.

  const box = new Float64Array([Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity]);
  const see = (x, y, z) => [x, y, z].forEach((value, axis) => {
    box[axis] = Math.min(box[axis], value);
    box[3 + axis] = Math.max(box[3 + axis], value);
  });
  const corners = () => [0, 1, 2, 3, 4, 5, 6, 7].map((i) =>
    new THREE.Vector3(box[i & 1 ? 3 : 0], box[i & 2 ? 4 : 1], box[i & 4 ? 5 : 2]));

  const fit = () => {
    const aspect = stage.clientWidth / stage.clientHeight;
    camera.updateMatrixWorld();
    camera.matrixWorldInverse.getInverse(camera.matrixWorld);
    let half = 1e-3;
    for (const corner of corners()) {
      const seen = corner.applyMatrix4(camera.matrixWorldInverse);
      half = Math.max(half, Math.abs(seen.y), Math.abs(seen.x) / aspect);
    }
    return 0.97 * half;
  };

  const lookFrom = (from) => {
    const centre = new THREE.Vector3(0.5 * (box[0] + box[3]), 0.5 * (box[1] + box[4]), 0.5 * (box[2] + box[5]));
    const reach = centre.distanceTo(new THREE.Vector3(box[3], box[4], box[5]));
    camera.position.copy(centre).addScaledVector(vector(from).normalize(), 4 * reach + 1);
    camera.near = 0.1;
    camera.far = 12 * reach + 2;
    controls.target.copy(centre);
    camera.lookAt(centre);
    camera.zoom = 1;
    camera.userData.half = fit();
    resize();
    controls.update();
  };

  const closeUp = () => {
    const now = Report.moment();
    const proxy = vector(now.proxy);
    const way = camera.position.clone().sub(controls.target);
    controls.target.copy(proxy);
    camera.position.copy(proxy).add(way);
    const half = Math.max(6, Math.min(40, 4 * proxy.distanceTo(vector(now.probe))));
    camera.zoom = camera.userData.half / half;
    camera.updateProjectionMatrix();
    controls.update();
    makeMoment();
    draw();
  };

  const resize = () => {
    const width = Math.max(1, stage.clientWidth), high = Math.max(1, stage.clientHeight);
    renderer.setSize(width, high);
    const half = camera.userData.half || 100;
    camera.top = half;
    camera.bottom = -half;
    camera.right = (half * width) / high;
    camera.left = -camera.right;
    camera.updateProjectionMatrix();
    for (const material of lineMaterials) material.resolution.set(width, high);
    makeMoment();
    draw();
  };

  /** Time of the event or path point under a click. */
  const timeAt = (x, y) => {
    const seen = new THREE.Vector3();
    const distance = (at) => {
      seen.set(at[0], at[1], at[2]).project(camera);
      return Math.hypot((0.5 + 0.5 * seen.x) * stage.clientWidth - x, (0.5 - 0.5 * seen.y) * stage.clientHeight - y);
    };
    let best = null, least = 12;
    const take = (time, apart) => {
      if (apart < least) [best, least] = [time, apart];
    };
    for (const event of data.events) if (groups[event.kind].visible) take(event.t, distance(event.at) - 6);
    for (const stretch of data.path) for (const point of stretch) take(point[0], distance(point[2]));
    return best;
  };

  const listen = () => {
    controls.addEventListener('change', () => {
      if (camera.zoom !== camera.userData.zoom) {
        camera.userData.zoom = camera.zoom;
        makeMoment();
      }
      draw();
    });
    // The wheel scrolls the page until a click activates the view.
    const canvas = renderer.domElement;
    controls.enableZoom = false;
    canvas.addEventListener('focus', () => (controls.enableZoom = true));
    canvas.addEventListener('blur', () => (controls.enableZoom = false));
    canvas.addEventListener('touchstart', () => (controls.enableZoom = true), {passive: true});
    let down = null;
    canvas.addEventListener('pointerdown', (event) => (down = [event.clientX, event.clientY]));
    canvas.addEventListener('pointerup', (event) => {
      if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
      const edge = canvas.getBoundingClientRect();
      const time = timeAt(event.clientX - edge.left, event.clientY - edge.top);
      if (time !== null) Report.show(time);
    });
    new ResizeObserver(resize).observe(stage);
    Report.onMoment((now) => {
      makeMoment();
      tellMoment(now);
      draw();
    });
    Report.onColors(() => {
      makePaths();
      makeEvents();
      makeKey();
      makeMoment();
      resize();
    });
    const looks = document.getElementById('looks');
    const button = (words, act) => {
      const made = Report.element('button', '', words);
      made.type = 'button';
      made.addEventListener('click', act);
      looks.append(made);
    };
    button('initial view', () => lookFrom(data.from));
    button('front', () => lookFrom([0, 0, 1]));
    button('right', () => lookFrom([1, 0, 0]));
    button('above', () => lookFrom([0, 1, 0.001]));
    button('this moment', closeUp);
  };

  const start = () => {
    stage = document.getElementById('stage');
    if (!data || !stage) return;
    if (!window.THREE || !hasWebGl()) {
      document.getElementById('no-view').hidden = false;
      return;
    }
    Report.live('view');
    renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    renderer.autoClear = false;
    stage.append(renderer.domElement);
    renderer.domElement.setAttribute('aria-label', 'The scene with the path of the hand; drag to turn it');
    camera = new THREE.OrthographicCamera(-1, 1, 1, -1);
    controls = new THREE.OrbitControls(camera, renderer.domElement);
    scene = new THREE.Scene();
    front = new THREE.Scene();
    addLights(scene);
    addLights(front);
    mostN = data.most_n;
    groups.force = new THREE.Group();
    groups.primitives = new THREE.Group();

    data.layers.forEach((layer, i) => {
      groups['layer' + i] = layer.lines ? lineBundle(layer) : surface(layer, i);
      scene.add(groups['layer' + i]);
      const points = unpacked(layer);
      for (let p = 0; p < points.length; p += 3) see(points[p], points[p + 1], points[p + 2]);
    });
    makePaths();
    for (const stretch of data.path) for (const point of stretch) [point[1], point[2]].forEach((at) => see(...at));
    if (!(box[0] <= box[3])) [-50, 50].forEach((edge) => see(edge, edge, edge));
    makeEvents();
    makeSigns();
    makeKey();
    listen();
    lookFrom(data.from);
  };

  return {start};
})();
