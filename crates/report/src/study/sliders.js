// Sliders for the factors and the parameters of the model, and figures that follow them. Without it the page has its figures and tables.
(() => {
  const section = document.getElementById('sliders'), model = JSON.parse(document.getElementById('model').textContent);
  const rig = solver(model), { axes } = model.table, COLOURS = ['#2b4c7e', '#3c7bb0', '#2f9c95', '#6a9c3f', '#c29a1b', '#de6f26', '#b3202c'];
  const STEPS = 200, CURVE = 15, HZ = 1 / (2 * Math.PI), p = rig.fitted.slice();
  const SVG = 'http://www.w3.org/2000/svg';
  const make = (parent, tag, attributes = {}, text) => {
    const element = tag.startsWith('svg:') ? document.createElementNS(SVG, tag.slice(4)) : document.createElement(tag);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    if (text !== undefined) element.textContent = text;
    parent.append(element);
    return element;
  };
  const printed = (name) => name.replace(/\^(-?\d+)/g, (_, power) => [...power].map((c) => '\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079'['-0123456789'.indexOf(c)]).join(''));
  const digits = (value, count = 4) => {
    if (!Number.isFinite(value)) return 'none';
    if (value !== 0 && Math.abs(value) < 1e-3) return printed(value.toExponential(count - 1).replace('e', ' \u00d7 10^')).replace(/^-/, '\u2212');
    return Number(value.toPrecision(count)).toString().replace('-', '\u2212');
  };
  // With two digits of what is uncertain of it.
  const uncertain = (value, sd) => {
    if (!(sd > 0)) return digits(value);
    const place = (of) => Math.floor(Math.log10(of));
    return digits(value, Math.min(Math.max(2 + place(Math.max(Math.abs(value), sd)) - place(sd), 2), 6));
  };
  // Letters that stand alone are symbols, with what stands below them; other names are words.
  const typeset = (element, name) => {
    const svg = element.namespaceURI === SVG;
    name.split(/((?<![\p{L}\p{N}_])\p{L}(?:_[\p{L}\p{N},]+)?(?![\p{L}\p{N}_]))/u).forEach((part, k) => {
      if (k % 2 === 0) { if (part) element.append(part.replaceAll('_', ' ')); return; }
      const [letter, below] = part.split(/_(.*)/);
      make(element, svg ? 'svg:tspan' : 'var', svg ? { 'font-style': 'italic' } : {}, letter);
      if (below === undefined) return;
      make(element, svg ? 'svg:tspan' : 'sub', svg ? { dy: '0.25em', 'font-size': '75%' } : {}, below);
      if (svg) make(element, 'svg:tspan', { dy: '-0.19em' }, '\u200b');
    });
  };
  const unit = (name) => (name === '1' || name === '' ? '' : ` ${printed(name)}`);

  // The axis along the figures is the one with the most values; every setting of the others that was measured is a series.
  const main = axes.reduce((best, axis, a) => (axis.levels.length > axes[best].levels.length ? a : best), 0);
  // The curve goes through the measured places and, where these are few, between them.
  const { levels } = axes[main], parts = Math.ceil((CURVE - 1) / (levels.length - 1));
  const along = levels.flatMap((x, k) => (k === 0 ? [x] : Array.from({ length: parts }, (_, j) => levels[k - 1] + (x - levels[k - 1]) * (j + 1) / parts)));
  const factorOf = (a) => model.factors[axes[a].factor];
  // A value of an axis in the unit in which it is shown.
  const unitOf = (a) => factorOf(a).shown?.unit ?? factorOf(a).unit;
  const inUnit = (a, value) => (value - (factorOf(a).shown?.zero ?? 0)) / (factorOf(a).shown?.one ?? 1);
  const settingOf = (node) => {
    const setting = [];
    for (let a = axes.length - 1; a >= 0; a -= 1) {
      const { levels } = axes[a];
      setting[a] = levels[node % levels.length];
      node = Math.floor(node / levels.length);
    }
    return setting;
  };
  const settings = model.nodes.map((_, node) => settingOf(node));
  const others = axes.map((_, a) => a).filter((a) => a !== main);
  const tellSetting = (element, setting) => others.forEach((a, k) => {
    if (k > 0) element.append(', ');
    typeset(element, factorOf(a).name);
    element.append(` = ${digits(inUnit(a, setting[a]))}${unit(unitOf(a))}`);
  });
  const nameOf = (setting) => others.map((a) => `${factorOf(a).name} = ${digits(inUnit(a, setting[a]))}${unit(unitOf(a))}`).join(', ');
  const series = [...new Set(settings.map(nameOf))].map((name) => ({ name, nodes: settings.flatMap((s, node) => (nameOf(s) === name ? [node] : [])) }));
  series.forEach((s, k) => {
    s.colour = series.length === 1 ? COLOURS[0] : COLOURS[Math.round(k * (COLOURS.length - 1) / (series.length - 1))];
    s.nodes.sort((a, b) => settings[a][main] - settings[b][main]);
  });

  // What is solved: every measured point, a curve along the axis at the setting, and the setting itself.
  // In the middle of the points at which a mode was measured.
  const seen = (m) => {
    const all = settings.filter((_, k) => model.nodes[k].modes[m]?.s);
    return (all.length > 0 ? all : settings)[Math.floor((all.length > 0 ? all : settings).length / 2)].slice();
  };
  let mode = 0, setting = seen(0), own = null, ownRoot = null, curve = null;
  const chains = settings.map((s) => rig.chain(s)), roots = model.modes.map(() => []);
  const found = (root) => root && Number.isFinite(root.sr);
  const ofNodes = () => {
    model.nodes.forEach((node, k) => {
      const known = node.modes[mode];
      if (!known) return;
      const before = roots[mode][k];
      roots[mode][k] = rig.solve(chains[k], p, found(before) ? before : { sr: known.s[0], si: known.s[1] });
    });
  };
  const between = (at, of) => rig.cornersOf(at).reduce((sum, [node, w]) => (w === 0 ? sum : sum + w * of(node)), 0);
  const guess = (at) => {
    const near = roots[mode][rig.cornersOf(at).reduce((a, b) => (b[1] > a[1] ? b : a))[0]];
    return { ...near, sr: between(at, (node) => roots[mode][node]?.sr ?? NaN), si: between(at, (node) => roots[mode][node]?.si ?? NaN) };
  };
  const solveAt = (chain, at) => {
    const near = guess(at);
    return found(near) ? rig.solve(chain, p, near) : near;
  };
  // What the training found of errors that all points share is added, as in every prediction.
  const shown = (root, shift) => [root.sr + shift[0], (root.si + shift[1]) * HZ];
  const shiftAt = (at) => [0, 1].map((i) => between(at, (node) => model.nodes[node].modes[mode]?.shift[i] ?? NaN));

  // ---- figures ----
  const holder = make(section, 'div', { class: 'live' });
  const WIDE = 520, HIGH = 330, LEFT = 64, RIGHT = 12, TOP = 12, BOTTOM = 52;
  const plot = (label, x, y) => {
    const svg = make(holder, 'svg:svg', { viewBox: `0 0 ${WIDE} ${HIGH}`, role: 'img', 'aria-label': label });
    const grid = make(svg, 'svg:g', { class: 'grid' }), body = make(svg, 'svg:g');
    const [name, rest] = x, below = make(svg, 'svg:text', { x: (LEFT + WIDE - RIGHT) / 2, y: HIGH - 10, 'text-anchor': 'middle' });
    typeset(below, name);
    below.append(rest);
    make(svg, 'svg:text', { x: 0, y: 0, transform: `translate(16 ${(TOP + HIGH - BOTTOM) / 2}) rotate(-90)`, 'text-anchor': 'middle' }, y);
    const layers = new Map();
    const layer = (key, tag, attributes) => {
      if (!layers.has(key)) layers.set(key, make(body, `svg:${tag}`, attributes));
      return layers.get(key);
    };
    let ticks = '';
    const frame = ([x0, x1], [y0, y1]) => {
      const pad = 0.06 * (y1 - y0 || Math.abs(y1) || 1), low = y0 - pad, high = y1 + pad;
      const X = (value) => LEFT + (value - x0) / (x1 - x0) * (WIDE - LEFT - RIGHT), Y = (value) => HIGH - BOTTOM - (value - low) / (high - low) * (HIGH - BOTTOM - TOP);
      const steps = (a, b) => {
        const rough = (b - a) / 5, ten = 10 ** Math.floor(Math.log10(rough)), step = [1, 2, 5, 10].find((k) => k * ten >= rough) * ten;
        const all = [];
        for (let k = Math.ceil(a / step - 1e-9); k * step <= b + 1e-9 * step; k += 1) all.push(k * step);
        return all;
      };
      const xs = steps(x0, x1), ys = steps(low, high), key = `${xs} ${ys} ${low} ${high}`;
      if (key !== ticks) {
        ticks = key;
        grid.replaceChildren();
        make(grid, 'svg:rect', { x: LEFT, y: TOP, width: WIDE - LEFT - RIGHT, height: HIGH - BOTTOM - TOP });
        for (const value of xs) {
          make(grid, 'svg:path', { d: `M${X(value)},${HIGH - BOTTOM}v-5` });
          make(grid, 'svg:text', { x: X(value), y: HIGH - BOTTOM + 18, 'text-anchor': 'middle' }, digits(value, 6));
        }
        for (const value of ys) {
          make(grid, 'svg:path', { d: `M${LEFT},${Y(value)}h5` });
          make(grid, 'svg:text', { x: LEFT - 7, y: Y(value) + 5, 'text-anchor': 'end' }, digits(value, 6));
        }
        if (low < 0 && high > 0) make(grid, 'svg:path', { d: `M${LEFT},${Y(0)}H${WIDE - RIGHT}`, class: 'zero' });
      }
      const path = (points) => points.map(([a, b], k) => (Number.isFinite(b) ? `${k > 0 && Number.isFinite(points[k - 1][1]) ? 'L' : 'M'}${X(a).toFixed(1)},${Y(b).toFixed(1)}` : '')).join('');
      return { X, Y, path };
    };
    return { svg, layer, frame };
  };
  const axisName = factorOf(main).name, axisUnit = unitOf(main), axisLabel = [axisName, axisUnit === '1' ? '' : ` / ${printed(axisUnit)}`];
  const plots = [
    plot(`Growth rate over ${axisName}: measured points and the model`, axisLabel, 'Growth rate / s\u207b\u00b9'),
    plot(`Frequency over ${axisName}: measured points and the model`, axisLabel, 'Frequency / Hz'),
  ];
  const shape = plot('Mode shape: pressure along the rig', ['x', ' / m'], '|p| / largest');
  const keys = make(section, 'p', { class: 'keys' });
  for (const s of series.filter((s) => s.name)) {
    const key = make(keys, 'span');
    make(key, 'i', { style: `background:${s.colour}` });
    tellSetting(key, settings[s.nodes[0]]);
  }
  const line = make(keys, 'span');
  make(line, 'i', { class: 'own' });
  line.append('the setting below; dots are measured');

  const measured = (node, part) => {
    const known = model.nodes[node].modes[mode], value = known && [known.growth_rate, known.angular_frequency][part];
    return value ? value[0] * [1, HZ][part] : NaN;
  };
  const draw = () => {
    const values = settings.map((_, k) => (found(roots[mode][k]) ? shown(roots[mode][k], model.nodes[k].modes[mode].shift) : [NaN, NaN]));
    const onAxis = (value) => inUnit(main, value), span = [onAxis(levels[0]), onAxis(levels.at(-1))], here = found(ownRoot) ? shown(ownRoot, shiftAt(setting)) : [NaN, NaN];
    plots.forEach((figure, part) => {
      const all = [...values.map((v) => v[part]), ...curve.map((c) => c.values[part]), ...settings.map((_, k) => measured(k, part)), here[part]].filter(Number.isFinite);
      const margin = 0.03 * (span[1] - span[0]), range = [span[0] - margin, span[1] + margin];
      const { X, Y, path } = figure.frame(range, [Math.min(...all), Math.max(...all)]);
      series.forEach((s, k) => {
        figure.layer(`line${k}`, 'path', { stroke: s.colour, class: 'series' }).setAttribute('d', path(s.nodes.map((node) => [onAxis(settings[node][main]), values[node][part]])));
        const dots = s.nodes.map((node) => [onAxis(settings[node][main]), measured(node, part)]).filter((dot) => Number.isFinite(dot[1]));
        const ring = dots.map(([a, b]) => `M${(X(a) - 2.5).toFixed(1)},${Y(b).toFixed(1)}a2.5,2.5 0 1 0 5,0a2.5,2.5 0 1 0 -5,0`).join('');
        figure.layer(`dots${k}`, 'path', { fill: s.colour, class: 'dots' }).setAttribute('d', ring);
      });
      figure.layer('curve', 'path', { class: 'own' }).setAttribute('d', path(curve.map((c) => [onAxis(c.at[main]), c.values[part]])));
      const mark = figure.layer('here', 'circle', { r: 6, class: 'own' });
      mark.setAttribute('visibility', Number.isFinite(here[part]) ? 'visible' : 'hidden');
      if (Number.isFinite(here[part])) { mark.setAttribute('cx', X(onAxis(setting[main]))); mark.setAttribute('cy', Y(here[part])); }
    });
    const points = found(ownRoot) ? rig.shape(own, p, ownRoot, 80) : [[0, NaN]];
    const { X, path } = shape.frame([0, own.position.at(-1)], [0, 1]);
    shape.layer('parts', 'path', { class: 'parts' }).setAttribute('d', own.devices.map((x) => `M${X(x).toFixed(1)},${TOP}V${HIGH - BOTTOM}`).join(''));
    shape.layer('shape', 'path', { class: 'own' }).setAttribute('d', path(points));
    return here;
  };

  // ---- what is said ----
  const steer = make(section, 'div', { class: 'steer' });
  const readout = make(steer, 'p', { class: 'readout' }), status = make(section, 'p', { role: 'status', class: 'unseen' });
  // Abramowitz and Stegun 7.1.26: to 1.5e-7.
  const normal = (x) => {
    const t = 1 / (1 + 0.3275911 * Math.abs(x) / Math.SQRT2), tail = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429)))) * Math.exp(-x * x / 2);
    return x > 0 ? 1 - 0.5 * tail : 0.5 * tail;
  };
  const say = (here) => {
    if (!found(ownRoot)) { readout.textContent = 'The search finds no mode near the measured one at this setting.'; return; }
    const g = rig.slopes(own, p, ownRoot), { covariance } = model;
    let variance = between(setting, (node) => model.nodes[node].modes[mode]?.other_sd ?? NaN) ** 2;
    g.forEach((a, i) => g.forEach((b, j) => { variance += a * covariance[i][j] * b; }));
    const sd = Math.sqrt(variance), probability = normal(here[0] / Math.hypot(sd, model.misfit));
    const chance = probability < 5e-4 ? 'less than 0.001' : probability > 1 - 5e-4 ? 'more than 0.999' : probability.toFixed(3);
    readout.textContent = `Growth rate ${digits(here[0])} \u00b1 ${digits(sd, 2)} 1/s, frequency ${digits(here[1], 6)} Hz. Unstable with probability ${chance}.`;
  };

  // ---- frames ----
  let due = null, stale = { nodes: true, curve: true };
  const frame = () => {
    const begun = performance.now();
    due = null;
    if (stale.nodes) ofNodes();
    if (stale.curve || !curve) {
      curve = along.map((x) => setting.map((value, a) => (a === main ? x : value))).map((at) => ({ at, chain: rig.chain(at) }));
    }
    if (stale.curve || stale.nodes) for (const c of curve) { c.root = solveAt(c.chain, c.at); c.values = found(c.root) ? shown(c.root, shiftAt(c.at)) : [NaN, NaN]; }
    if (stale.own) own = rig.chain(setting);
    ownRoot = solveAt(own, setting);
    say(draw());
    stale = {};
    section.dataset.ms = (performance.now() - begun).toFixed(2);
  };
  const change = (what) => {
    Object.assign(stale, what);
    due ??= requestAnimationFrame(frame);
  };
  const announce = () => { requestAnimationFrame(() => { status.textContent = readout.textContent; }); };

  // ---- sliders ----
  let count = 0;
  const slider = (parent, words, low, middle, high, show, set) => {
    const row = make(parent, 'div', { class: 'slider' }), id = `slider-${count}`;
    count += 1;
    typeset(make(row, 'label', { for: id }), words);
    const input = make(row, 'input', { type: 'range', id, min: 0, max: STEPS, step: 1 }), said = make(row, 'span');
    // Halfway stands what was found; at the end if that is an end of the prior.
    const half = middle === high ? STEPS : middle === low ? 0 : STEPS / 2;
    const value = (k) => (k <= half && half > 0 ? low + (middle - low) * k / half : middle + (high - middle) * (k - half) / (STEPS - half));
    const tell = (v) => { said.textContent = show(v); input.setAttribute('aria-valuetext', show(v)); };
    input.addEventListener('input', () => { const v = value(Number(input.value)); tell(v); set(v); });
    input.addEventListener('change', announce);
    return (v) => {
      input.value = v <= middle && half > 0 ? half * (v - low) / (middle - low) : half + (STEPS - half) * (v - middle) / (high - middle);
      tell(v);
    };
  };
  const controls = make(section, 'div', { class: 'controls' });
  const choices = make(controls, 'p');
  const choose = (words, id, options, set) => {
    make(choices, 'label', { for: id }, words);
    const select = make(choices, 'select', { id });
    options.forEach(([value, text]) => make(select, 'option', { value }, text));
    select.addEventListener('change', () => { set(select.value); announce(); });
    return select;
  };
  if (model.modes.length > 1) {
    choose('Mode ', 'slider-mode', model.modes.map((label, k) => [k, label]), (value) => {
      mode = Number(value);
      // A mode that was measured at some points only is shown at one of them.
      if (model.nodes.some((node) => !node.modes[mode]?.s)) {
        setting = seen(mode);
        point.value = '';
        place.forEach((move, a) => move(setting[a]));
      }
      change({ nodes: true, curve: true, own: true });
    });
  }
  const point = choose(' Measured point ', 'slider-point', [['', 'none'], ...model.nodes.map((node, k) => [k, node.point])], (value) => {
    if (value === '') return;
    setting = settings[Number(value)].slice();
    place.forEach((move, a) => move(setting[a]));
    change({ curve: true, own: true });
  });
  const place = axes.map((axis, a) => {
    const low = axis.levels[0], high = axis.levels.at(-1);
    return slider(steer, factorOf(a).name, low, (low + high) / 2, high, (v) => `${digits(inUnit(a, v))}${unit(unitOf(a))}`, (v) => {
      setting[a] = v;
      point.value = '';
      change(a === main ? { own: true } : { curve: true, own: true });
    });
  });
  const details = make(controls, 'details');
  make(details, 'summary', {}, `Parameters of the model (${model.parameters.length})`);
  details.open = window.matchMedia('(min-width: 700px)').matches;
  const list = make(details, 'div', { class: 'parameters' });
  const back = model.parameters.map((q, k) => slider(list, q.symbol || q.name, q.range[0], q.value, q.range[1], (v) => `${uncertain(v, Math.sqrt(model.covariance[k][k]))}${unit(q.unit)}`, (v) => {
    p[k] = v;
    change({ nodes: true });
  }));
  const button = make(details, 'button', { type: 'button' }, 'Back to the fit');
  const fit = () => { back.forEach((move, k) => { p[k] = rig.fitted[k]; move(p[k]); }); change({ nodes: true }); };
  button.addEventListener('click', () => { fit(); announce(); });
  place.forEach((move, a) => move(setting[a]));
  back.forEach((move, k) => move(p[k]));
  stale.own = true;
  frame();

  // The page's own difference to the program's numbers.
  let apart = 0, compared = 0;
  for (mode = model.modes.length - 1; ; mode -= 1) {
    ofNodes();
    model.nodes.forEach((node, k) => {
      const known = node.modes[mode]?.s;
      if (!known) return;
      compared += 1;
      apart = Math.max(apart, Math.hypot(roots[mode][k].sr - known[0], roots[mode][k].si - known[1]) / Math.hypot(...known));
    });
    if (mode === 0) break;
  }
  section.dataset.apart = apart;
  make(section, 'p', {}, `At the fit, this page's eigenvalues of the ${compared} measured modes differ from the program's by at most ${digits(apart, 1)} of |s|. `
    + `The page takes the states of the gas from a table, linear between the measured points; that moves growth rates by up to ${digits(model.tabulated[0], 2)} 1/s and frequencies by up to ${digits(model.tabulated[1] * HZ, 2)} Hz there. `
    + `The probability is that of a growth rate above zero, if the parameters scatter about the sliders as in the posterior, with the misfit that the training found, ${digits(model.misfit, 2)} 1/s.`);
  section.querySelector('.unscripted').remove();
})();
