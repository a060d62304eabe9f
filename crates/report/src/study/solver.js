// Solves the model of this page: the chain of ducts of crates/network with the laws, the rig and the states of the gas that the program wrote
// here. `model` is the record `Sliders` of crates/engine. Without a page: solver(model).solve(...) is what the figures below stand on.
const solver = (model) => {
  const { table, script } = model, TEMPERATURE_AFTER = 16, AMBIENT = 18, LENGTH = 19, DENSITY_AFTER = 24;
  // Names that depend on s and their places in `z`: s, loss of the wall, reflection of open ends.
  const ANALYTIC = { 0: 0, 20: 2, 21: 4, 22: 6, 23: 8 };

  // Complex functions leave their value in M.x + i M.y. Roots and logarithms take principal branches.
  const M = {
    x: 0, y: 0,
    set(x, y) { M.x = x; M.y = y; },
    times(a, b, c, d) { M.set(a * c - b * d, a * d + b * c); },
    over(a, b, c, d) { const n = c * c + d * d; M.set((a * c + b * d) / n, (b * c - a * d) / n); },
    sqrt(a, b) {
      const long = Math.sqrt(0.5 * (Math.hypot(a, b) + Math.abs(a))), short = long === 0 ? 0 : 0.5 * Math.abs(b) / long;
      const sign = b < 0 || Object.is(b, -0) ? -1 : 1;
      if (a >= 0) M.set(long, sign * short); else M.set(short, sign * long);
    },
    exp(a, b) { const r = Math.exp(a); M.set(r * Math.cos(b), r * Math.sin(b)); },
    ln(a, b) { M.set(Math.log(Math.hypot(a, b)), Math.atan2(b, a)); },
    sinh(a, b) { M.set(Math.sinh(a) * Math.cos(b), Math.cosh(a) * Math.sin(b)); },
    cosh(a, b) { M.set(Math.cosh(a) * Math.cos(b), Math.sinh(a) * Math.sin(b)); },
    tanh(a, b) {
      M.cosh(a, b);
      const c = M.x, d = M.y;
      M.sinh(a, b);
      M.over(M.x, M.y, c, d);
    },
    // sin z = -i sinh iz, cos z = cosh iz, tan z = -i tanh iz.
    sin(a, b) { M.sinh(-b, a); M.set(M.y, -M.x); },
    cos(a, b) { M.cosh(-b, a); },
    tan(a, b) { M.tanh(-b, a); M.set(M.y, -M.x); },
    pow(a, b, c, d) {
      if (d === 0 && Number.isInteger(c) && Math.abs(c) <= 64) {
        let x = 1, y = 0;
        for (let k = Math.abs(c); k > 0; k -= 1) { M.times(x, y, a, b); x = M.x; y = M.y; }
        if (c < 0) M.over(1, 0, x, y); else M.set(x, y);
      } else if (a === 0 && b === 0) {
        M.set(c > 0 ? 0 : NaN, 0);
      } else {
        M.ln(a, b);
        M.times(M.x, M.y, c, d);
        M.exp(M.x, M.y);
      }
    },
    // I1(z)/I0(z) for Re z >= 0: where exp(-2z) is below rounding and z is far, Hankel's series (DLMF 10.40.1), elsewhere
    // z/(2 + z^2/(4 + z^2/(6 + ...))) (DLMF 10.33.1).
    bessel_ratio(a, b) {
      const square = a * a + b * b;
      if (square > 1600 && a > 18) {
        M.over(1, 0, a, b);
        const u = M.x, v = M.y;
        const series = (mu) => {
          let [tx, ty, x, y] = [1, 0, 1, 0];
          for (let k = 1; k <= 24; k += 1) {
            const f = -(mu - (2 * k - 1) ** 2) / (8 * k);
            [tx, ty] = [f * (tx * u - ty * v), f * (tx * v + ty * u)];
            x += tx; y += ty;
            if (tx * tx + ty * ty < 1e-34) break;
          }
          return [x, y];
        };
        M.over(...series(4), ...series(0));
        return;
      }
      const qx = a * a - b * b, qy = 2 * a * b;
      let x = 0, y = 0;
      for (let k = 20 + Math.ceil(2 * Math.sqrt(square)); k > 0; k -= 1) { M.over(qx, qy, 2 * k + x, y); x = M.x; y = M.y; }
      M.over(x, y, a, b);
    },
  };

  // A formula in words, operands before their operation, as a function of names n, parameters p and what depends on s, z.
  const compile = (words) => {
    const lines = [], stack = [];
    let count = 0, analytic = new Set();
    const real = (re, value) => ({ re, im: null, value });
    const name = (expression) => { count += 1; lines.push(`const t${count}=${expression};`); return `t${count}`; };
    const complex = (call) => { lines.push(`${call};`); return { re: name('M.x'), im: name('M.y') }; };
    const im = (a) => a.im ?? '0';
    for (const word of words.split(' ')) {
      if (word === 'neg') {
        const a = stack.pop();
        stack.push({ re: `(-${a.re})`, im: a.im && `(-${a.im})`, value: a.value === undefined ? undefined : -a.value });
      } else if ('+-*/^'.includes(word)) {
        const b = stack.pop(), a = stack.pop(), both = a.im || b.im;
        if (word === '^') {
          stack.push(both ? complex(`M.pow(${a.re},${im(a)},${b.re},${im(b)})`) : real(name(`Math.pow(${a.re},${b.re})`)));
        } else if (word === '+' || word === '-') {
          stack.push({ re: name(`${a.re}${word}${b.re}`), im: both ? name(`${im(a)}${word}${im(b)}`) : null });
        } else if (!a.im && !b.im) {
          stack.push(real(name(`${a.re}${word}${b.re}`)));
        } else if (!b.im) {
          stack.push({ re: name(`${a.re}${word}${b.re}`), im: name(`${a.im}${word}${b.re}`) });
        } else if (word === '*') {
          stack.push(a.im
            ? { re: name(`${a.re}*${b.re}-${a.im}*${b.im}`), im: name(`${a.re}*${b.im}+${a.im}*${b.re}`) }
            : { re: name(`${a.re}*${b.re}`), im: name(`${a.re}*${b.im}`) });
        } else {
          stack.push(complex(`M.over(${a.re},${im(a)},${b.re},${b.im})`));
        }
      } else if (/^n\d/.test(word)) {
        const k = Number(word.slice(1)), at = ANALYTIC[k];
        if (at === undefined) stack.push(real(`n[${k}]`));
        else { analytic.add(k); stack.push({ re: `z[${at}]`, im: `z[${at + 1}]` }); }
      } else if (/^p\d/.test(word)) {
        stack.push(real(`p[${Number(word.slice(1))}]`));
      } else if (/^[-\d]/.test(word)) {
        const [re, imaginary] = word.split(',').map(Number);
        stack.push({ re: `(${re})`, im: imaginary === undefined ? null : `(${imaginary})`, value: imaginary === undefined ? re : undefined });
      } else if (['re', 'im', 'conj', 'abs', 'arg'].includes(word)) {
        const a = stack.pop();
        if (word === 'conj') stack.push({ re: a.re, im: a.im && `(-${a.im})` });
        else stack.push(real({ re: a.re, im: im(a), abs: name(`Math.hypot(${a.re},${im(a)})`), arg: name(`Math.atan2(${im(a)},${a.re})`) }[word]));
      } else if (word in M && word !== 'x' && word !== 'y') {
        const a = stack.pop(), own = { ln: 'log' }[word] ?? word;
        if (a.im) stack.push(complex(`M.${word}(${a.re},${a.im})`));
        else if (word === 'bessel_ratio') stack.push(real(complex(`M.bessel_ratio(${a.re},0)`).re));
        else stack.push(real(name(`Math.${own}(${a.re})`)));
      } else {
        stack.push(real('NaN'));
      }
    }
    const found = stack.pop();
    const run = new Function('M', 'n', 'p', 'z', `${lines.join('')}M.x=${found.re};M.y=${im(found)};`);
    return { run: (n, p, z) => run(M, n, p, z), uses: (k) => analytic.has(k) };
  };

  // Numbers of the rig: known, formulas of real names, tables over a factor.
  const none = new Float64Array(10);
  const number = (source) => {
    if (typeof source === 'number') return () => source;
    if (typeof source === 'string') {
      const formula = compile(source);
      return (n) => { formula.run(n, none, none); return M.y === 0 ? M.x : NaN; };
    }
    const { over, rows } = source;
    return (n) => {
      const x = n[over];
      if (!(rows.length > 1) || Number.isNaN(x)) return rows.length === 1 && !Number.isNaN(x) ? rows[0][1] : NaN;
      let k = rows.findIndex((row) => row[0] > x);
      k = Math.min(Math.max(k < 0 ? rows.length : k, 1), rows.length - 1);
      const [[x0, y0], [x1, y1]] = [rows[k - 1], rows[k]];
      return y0 + Math.min(Math.max((x - x0) / (x1 - x0), 0), 1) * (y1 - y0);
    };
  };
  const parts = script.parts.map((part) => ({
    ...part, numbers: part.numbers.map(([name, value]) => [name, number(value)]), at: part.at.map(number),
  }));
  const effects = script.effects.map((effect) => {
    const [kind, part] = effect.place, duct = kind === 'duct';
    const wall = duct && { mu: 20, ep: 21 }[effect.coefficient];
    return { ...effect, kind, part, wall, along: duct || kind === 'along', end: ['upstream', 'downstream', 'ends'].includes(kind), formula: compile(effect.law) };
  });
  const walls = effects.filter((effect) => effect.wall);

  // Properties at a temperature: T, rho, c, mu, k, c_p, gamma, Pr (crates/rig, Gas; crates/study, GasModel).
  const { gas, pressure } = script;
  const [c0, c1, c2, c3] = gas.heat_capacity ?? [];
  const heat = (T) => (gas.gamma ? gas.gamma * gas.constant / (gas.gamma - 1) : (c0 + T * (c1 + T * (c2 + T * c3))) / gas.molar_mass);
  const gasAt = (T) => {
    const cp = heat(T), r = gas.constant, gamma = cp / (cp - r);
    const sutherland = ([reference, constant]) => reference * (T / 273.15) ** 1.5 * (273.15 + constant) / (T + constant);
    const mu = gas.gamma ? gas.viscosity[0] * (T / gas.viscosity[1]) ** 0.7 : sutherland(gas.viscosity);
    const k = gas.gamma ? mu * cp / gas.prandtl : sutherland(gas.conductivity);
    return { T, rho: pressure / (r * T), c: Math.sqrt(gamma * r * T), mu, k, cp, gamma, Pr: mu * cp / k };
  };

  // The state of the gas at a setting of the axes, linear between the nodes, and the rig there (crates/engine, run/sliders/table.rs; crates/study,
  // rig/resolve.rs).
  const cornersOf = (setting) => {
    let corners = [[0, 1]];
    table.axes.forEach(({ levels }, a) => {
      const above = levels.findIndex((l) => l > setting[a]);
      const upper = Math.min(Math.max(above < 0 ? levels.length : above, 1), levels.length - 1);
      const share = (setting[a] - levels[upper - 1]) / (levels[upper] - levels[upper - 1]);
      corners = corners.flatMap(([node, w]) => [[node * levels.length + upper - 1, w * (1 - share)], [node * levels.length + upper, w * share]]);
    });
    return corners;
  };
  const conditions = (setting) => {
    const corners = cornersOf(setting);
    const between = (of) => corners.reduce((sum, [node, w]) => sum + w * of(table.states[node]), 0);
    const list = (key) => {
      const all = new Array(table.states[0][key].length).fill(0);
      for (const [node, w] of corners) {
        const own = table.states[node][key];
        for (let k = 0; k < all.length; k += 1) all[k] += w * (own[k] ?? NaN);
      }
      return all;
    };
    const factors = list('factors');
    table.axes.forEach((axis, a) => { factors[axis.factor] = setting[a]; });
    const n = new Float64Array(script.names).fill(NaN);
    script.factors.forEach((name, k) => { n[name] = factors[k]; });
    n[AMBIENT] = between((state) => state.ambient);
    parts.forEach((part) => part.numbers.forEach(([name, value]) => { n[name] = value(n); }));
    const ducts = [], places = [];
    const absent = (part) => part.present !== null && !(n[part.present] > 0);
    let end = 0;
    parts.forEach((part, k) => {
      if (part.shape !== 'duct' || absent(part)) return;
      const [length, from, to] = part.at.map((value) => value(n));
      ducts.push({ part: k, span: [end, end + length], area: [from, to], pieces: part.pieces[from === to ? 0 : 1] });
      end += length;
    });
    n[LENGTH] = end;
    let before = 0;
    for (const [k, part] of parts.entries()) {
      const duct = ducts.find((d) => d.part === k);
      if (duct) { before = duct.span[1]; places.push({ span: duct.span }); continue; }
      const at = part.at.map((value) => value(n));
      if (absent(part) || at.some(Number.isNaN)) places.push({});
      else if (part.shape === 'insert') places.push({ span: [Math.min(...at), Math.max(...at)] });
      else places.push({ at: at.length ? at : [before] });
    }
    const borders = list('borders'), edges = [0, ...borders, end];
    const x = table.shares.flatMap((shares, zone) => shares.map((share) => edges[zone] + share * (edges[zone + 1] - edges[zone])));
    const T = list('temperature');
    return {
      n, length: end, ducts, places, x, T, kinks: table.kinks.map(([a, b]) => [borders[a], borders[b]]),
      flow: between((state) => state.mass_flow), brought: list('numbers'), uniform: T.every((t) => t === T[0]),
    };
  };

  // Temperatures just upstream and just downstream of a place (crates/study, base.rs).
  const count = (x, before) => {
    let [low, high] = [0, x.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (before(x[middle])) low = middle + 1; else high = middle;
    }
    return low;
  };
  const onPiece = ({ x, T }, upper, at) => {
    const k = Math.min(Math.max(upper, 1), x.length - 1), [x0, x1] = [x[k - 1], x[k]];
    const share = x1 > x0 ? Math.min(Math.max((at - x0) / (x1 - x0), 0), 1) : 1;
    return T[k - 1] + share * (T[k] - T[k - 1]);
  };
  const temperatures = (c, at) => {
    const slack = 1e-9 * c.length;
    return [onPiece(c, count(c.x, (x) => x < at - slack), at), onPiece(c, count(c.x, (x) => x <= at + slack), at)];
  };
  // Averages of the density and of 1/(rho c^2) = 1/(gamma p) over a stretch by three-point Gauss quadrature on each linear piece.
  const GAUSS = [[-Math.sqrt(0.6), 5 / 9], [0, 8 / 9], [Math.sqrt(0.6), 5 / 9]];
  const stretch = (c, from, to) => {
    let left = from, k = count(c.x, (x) => x <= from), rho = 0, compliance = 0;
    while (left < to) {
      const right = Math.min(to, k < c.x.length ? c.x[k] : to), middle = 0.5 * (left + right), half = 0.5 * (right - left);
      for (const [node, weight] of GAUSS) {
        const T = onPiece(c, k, middle + node * half);
        rho += half * weight * pressure / (gas.constant * T);
        const cp = heat(T);
        compliance += half * weight * (cp - gas.constant) / (cp * pressure);
      }
      left = right;
      k += 1;
    }
    rho /= to - from;
    return { from, to, rho, compliance: compliance / (to - from), gas: gasAt(pressure / (gas.constant * rho)) };
  };
  // An element as two halves that have the first moments of the gas along it (crates/engine, point/cuts.rs).
  const halves = (c, from, to) => {
    const middle = 0.5 * (from + to), [lower, upper] = [stretch(c, from, middle), stretch(c, middle, to)];
    const mean = 0.5 * (lower.rho + upper.rho), own = gasAt(pressure / (gas.constant * mean));
    const apart = (key) => 2 / 3 * (upper[key] - lower[key]), mid = (key) => 0.5 * (lower[key] + upper[key]);
    const half = (part, sign) => ({ ...part, rho: mean + sign * apart('rho'), compliance: mid('compliance') + sign * apart('compliance'), gas: own });
    return [half(lower, -1), half(upper, 1)];
  };
  const areaAt = ({ span, area: [a, b] }, x) => {
    const share = Math.min(Math.max((x - span[0]) / (span[1] - span[0]), 0), 1), [start, end] = [Math.sqrt(a), Math.sqrt(b)];
    return start === end ? a : (start + share * (end - start)) ** 2;
  };
  const areas = (c, x) => {
    const slack = 1e-9 * c.length;
    const before = c.ducts.find((d) => x <= d.span[1] + slack) ?? c.ducts.at(-1);
    const after = c.ducts.findLast((d) => x >= d.span[0] - slack) ?? c.ducts[0];
    return [areaAt(before, x), areaAt(after, x)];
  };
  // Where an effect acts: places with their shares, and stretches.
  const placesOf = (c, { kind, part }) => {
    const there = part === null ? {} : c.places[part];
    if (kind === 'upstream') return [[0, 1]];
    if (kind === 'downstream') return [[c.length, 1]];
    if (kind === 'ends') return [[0, 1], [c.length, 1]];
    if (kind === 'start' || kind === 'end') return there.span ? [[there.span[kind === 'end' ? 1 : 0], 1]] : [];
    if (!there.at) return [];
    if (kind === 'middle') return [[there.at.reduce((a, b) => a + b, 0) / there.at.length, 1]];
    return there.at.map((x) => [x, kind === 'shared' ? 1 / there.at.length : 1]);
  };
  const stretchesOf = (c, { kind, part, along }) => {
    if (!along) return [];
    if (part === null) return [[0, c.length]];
    return c.places[part].span ? [c.places[part].span] : [];
  };
  // What a law sees (crates/engine, conditions.rs).
  const around = (c, gas, area, [after, areaAfter]) => {
    const n = c.n.slice(), flux = c.flow / area, velocity = flux / gas.rho, diameter = 2 * Math.sqrt(area / Math.PI);
    const own = [gas.rho, gas.c, gas.T, pressure, gas.mu, gas.k, gas.cp, gas.gamma, gas.Pr, velocity, velocity / gas.c, flux, diameter, area, Math.PI * diameter];
    own.forEach((value, k) => { n[k + 1] = value; });
    n[TEMPERATURE_AFTER] = after;
    n[TEMPERATURE_AFTER + 1] = areaAfter;
    n[DENSITY_AFTER] = pressure / (script.gas.constant * after);
    table.brought.forEach((name, k) => { n[name] = c.brought[k]; });
    return n;
  };

  // The network at a setting: segments, and laws with their weights on its coefficients (crates/engine, point/cuts.rs and attach.rs).
  const chain = (setting) => {
    const c = conditions(setting), L = c.length;
    const cuts = [0, L, 0.3719 * L];
    for (const effect of effects) {
      cuts.push(...placesOf(c, effect).map(([x]) => x), ...stretchesOf(c, effect).flat());
    }
    for (const { span: [from, to], pieces } of c.ducts) {
      for (let k = 0; k <= pieces; k += 1) cuts.push(from + (to - from) * k / pieces);
    }
    if (!c.uniform) {
      for (let k = 1; k < 10; k += 1) cuts.push(L * k / 10);
      cuts.push(1e-3, L - 1e-3);
      for (const [from, to] of c.kinks) for (const d of [0, 0.02, 0.06]) cuts.push(from - d, to + d);
      c.x.forEach((x, k) => { if (k > 0 && c.x[k - 1] === x) cuts.push(x); });
    }
    const inside = cuts.filter((x, k) => k < 2 || (x > 0 && x < L)).sort((a, b) => a - b), edges = [];
    for (const x of inside) if (!(Math.abs(x - edges.at(-1)) < 1e-9 * L)) edges.push(x);
    edges[edges.length - 1] = L;
    const pieces = edges.slice(1).flatMap((to, k) => (c.uniform ? [stretch(c, edges[k], to)] : halves(c, edges[k], to)));
    const N = pieces.length, area = pieces.map((p) => areas(c, 0.5 * (p.from + p.to))[0]);
    const position = [0];
    pieces.forEach((p, i) => position.push(position[i] + p.to - p.from));
    const placeAt = (x) => position.findIndex((at) => Math.abs(at - x) <= 1e-9 * L);

    const laws = [], target = [], source = [], weights = [];
    const law = (effect, n) => laws.push({ effect, n }) - 1;
    // Coefficients lie in one array of complex numbers: two per segment, four per place, one per end.
    const joint = (coefficient, j) => 2 * N + 4 * j + ({ mp: 1, eu: 2, ep: 3 }[coefficient] ?? 0);
    const attach = (coefficient, number, weight) => { target.push(2 * coefficient); source.push(2 * number); weights.push(weight); };
    const surroundings = [];
    pieces.forEach((p, i) => {
      const same = i > 0 && pieces[i - 1].gas.T === p.gas.T && area[i - 1] === area[i];
      surroundings.push(same ? surroundings[i - 1] : around(c, p.gas, area[i], [p.gas.T, area[i]]));
    });
    const aroundPlace = (x) => {
      const [before, after] = areas(c, x), T = temperatures(c, x), first = x <= 0;
      return around(c, gasAt(T[first ? 1 : 0]), first ? after : before, [T[1], after]);
    };
    for (const effect of effects) {
      if (effect.along) {
        for (const [from, to] of stretchesOf(c, effect)) {
          let shared = null, last = null;
          pieces.forEach((p, i) => {
            const middle = 0.5 * (p.from + p.to);
            if (!(middle >= from && middle < to)) return;
            let found = last && last.n === surroundings[i] ? last : null;
            if (!found && effect.proportional) {
              const value = sample(effect, surroundings[i]);
              if (shared) {
                const weight = value[shared.part] / shared.value;
                if (Number.isFinite(weight) && weight !== 0) found = { number: shared.number, weight };
              } else {
                const part = Math.abs(value[0]) > Math.abs(value[1]) ? 0 : 1;
                if (Number.isFinite(value[0] + value[1]) && value[part] !== 0) {
                  shared = { number: law(effect, surroundings[i]), part, value: value[part] };
                  found = { number: shared.number, weight: 1 };
                }
              }
            }
            found ??= { number: law(effect, surroundings[i]), weight: 1 };
            last = { ...found, n: surroundings[i] };
            if (effect.coefficient === 'mu') attach(2 * i, found.number, found.weight);
            else if (effect.coefficient === 'ep') attach(2 * i + 1, found.number, found.weight);
            else for (const j of [i, i + 1]) attach(joint(effect.coefficient, j), found.number, 0.5 * found.weight * (p.to - p.from));
          });
        }
        continue;
      }
      for (const [x, share] of placesOf(c, effect)) {
        const number = law(effect, aroundPlace(x));
        attach(effect.end ? 2 * N + 4 * (N + 1) + (x > 0 ? 1 : 0) : joint(effect.coefficient, placeAt(x)), number, share);
      }
    }
    const jumps = new Uint8Array(N + 1), length = new Float64Array(N), rho = new Float64Array(N), compliance = new Float64Array(N);
    let travel = 0;
    for (let i = 0; i < N; i += 1) {
      const p = pieces[i];
      length[i] = p.to - p.from; rho[i] = p.rho; compliance[i] = p.compliance;
      travel += length[i] * Math.sqrt(p.rho * p.compliance);
      if (i > 0 && area[i - 1] !== area[i]) jumps[i] = 1;
    }
    for (const at of target) if (at >= 4 * N && at < 12 * N + 8) jumps[(at - 4 * N) >> 3] = 1;
    return {
      N, laws, jumps, position, length, rho, compliance, area, devices: c.places.flatMap((place) => place.at ?? []), spacing: Math.PI / travel,
      target: new Int32Array(target), source: new Int32Array(source), weight: new Float64Array(weights),
      values: new Float64Array(2 * laws.length), k: new Float64Array(2 * (6 * N + 6)),
    };
  };

  // Reflection coefficients at ka = s a/(i c): Levine and Schwinger's by its series, and Rayleigh's piston.
  const radiation = (which, n, sr, si, z) => {
    const a = 0.5 * n[13] / n[2], kr = si * a, ki = -sr * a;
    if (which === 22) {
      M.ln(kr, ki);
      const apart = ({ centre }) => Math.abs(M.x - Math.log(centre));
      const { centre, terms } = script.radiation.reduce((a, b) => (apart(b) < apart(a) ? b : a));
      const wr = M.x - Math.log(centre), wi = M.y;
      let x = Math.hypot(wr, wi) < 1 ? 0 : NaN, y = 0;
      for (let k = terms.length - 1; k >= 0; k -= 1) [x, y] = [x * wr - y * wi + terms[k][0], x * wi + y * wr + terms[k][1]];
      M.times(kr, ki, x, y);
      M.exp(M.x, M.y);
      z[6] = -M.x; z[7] = -M.y;
      return;
    }
    // Z/(rho c) = 1 - J1(2ka)/ka + i H1(2ka)/ka by their power series (crates/network, laws/ends.rs).
    const xr = 2 * kr, xi = 2 * ki, qr = xr * xr - xi * xi, qi = 2 * xr * xi;
    let [tr, ti, rr, ri] = [1, 0, 0, 0], f = 4 / (3 * Math.PI), [ur, ui] = [xr * f, xi * f];
    let [er, ei] = [ur, ui];
    for (let m = 1; m < 40; m += 1) {
      f = -0.25 / (m * (m + 1));
      [tr, ti] = [f * (tr * qr - ti * qi), f * (tr * qi + ti * qr)];
      rr -= tr; ri -= ti;
      f = -1 / ((2 * m + 1) * (2 * m + 3));
      [ur, ui] = [f * (ur * qr - ui * qi), f * (ur * qi + ui * qr)];
      er += ur; ei += ui;
    }
    M.over(rr - ei - 1, ri + er, rr - ei + 1, ri + er);
    z[8] = M.x; z[9] = M.y;
  };
  // A law at s, in M; the loss of the wall where it acts is known to it.
  const zWall = new Float64Array(10), zLaw = new Float64Array(10);
  const evaluate = (effect, n, p, sr, si) => {
    const z = zLaw, { formula } = effect;
    if (!effect.wall && (formula.uses(20) || formula.uses(21))) {
      zWall[0] = sr; zWall[1] = si;
      const sum = [0, 0, 0, 0];
      for (const wall of walls) {
        wall.formula.run(n, p, zWall);
        sum[wall.wall === 20 ? 0 : 2] += M.x;
        sum[wall.wall === 20 ? 1 : 3] += M.y;
      }
      sum.forEach((value, k) => { z[2 + k] = value; });
    }
    z[0] = sr; z[1] = si;
    if (formula.uses(22)) radiation(22, n, sr, si, z);
    if (formula.uses(23)) radiation(23, n, sr, si, z);
    formula.run(n, p, z);
  };
  const fitted = Float64Array.from(model.parameters, (parameter) => parameter.value);
  // Laws that are a number of the gas times what is everywhere the same are told apart by their values at one s.
  const sample = (effect, n) => { evaluate(effect, n, fitted, -10, 1000); return [M.x, M.y]; };

  // Coefficients of C = cosh sqrt q and S = sinh(sqrt q)/sqrt q, entire functions of q (crates/network, chain/line.rs).
  const COSH = [1], SINH = [1];
  for (let k = 1; k < 13; k += 1) {
    COSH.push(COSH[k - 1] / ((2 * k - 1) * 2 * k));
    SINH.push(SINH[k - 1] / (2 * k * (2 * k + 1)));
  }
  const line = new Float64Array(4);
  const lineAt = (qr, qi) => {
    const size = Math.abs(qr) + Math.abs(qi);
    if (size < 2) {
      let cr = 0, ci = 0, sr = 0, si = 0, old;
      for (let k = size < 0.01 ? 4 : size < 0.1 ? 6 : 12; k >= 0; k -= 1) {
        old = cr; cr = cr * qr - ci * qi + COSH[k]; ci = old * qi + ci * qr;
        old = sr; sr = sr * qr - si * qi + SINH[k]; si = old * qi + si * qr;
      }
      line[0] = cr; line[1] = ci; line[2] = sr; line[3] = si;
    } else {
      M.sqrt(qr, qi);
      const wr = M.x, wi = M.y;
      M.cosh(wr, wi);
      line[0] = M.x; line[1] = M.y;
      M.sinh(wr, wi);
      M.over(M.x, M.y, wr, wi);
      line[2] = M.x; line[3] = M.y;
    }
  };

  // F(s) = g - R_d f at the downstream end for a wave g = 1 at the upstream end, in M (crates/network, chain/sweep.rs). `visit` sees the state before
  // every segment.
  const characteristic = (chain, p, sr, si, visit) => {
    const { N, laws, values, k, target, source, weight, area, jumps } = chain;
    for (let l = 0; l < laws.length; l += 1) {
      evaluate(laws[l].effect, laws[l].n, p, sr, si);
      values[2 * l] = M.x; values[2 * l + 1] = M.y;
    }
    k.fill(0);
    for (let a = 0; a < target.length; a += 1) {
      k[target[a]] += weight[a] * values[source[a]];
      k[target[a] + 1] += weight[a] * values[source[a] + 1];
    }
    const ends = 2 * (6 * N + 4), impedance = (i) => Math.sqrt(chain.rho[i] / chain.compliance[i]), z0 = impedance(0);
    let pr = 1 + k[ends], pi = k[ends + 1], ur = (k[ends] - 1) / z0, ui = k[ends + 1] / z0;
    for (let i = 0; i <= N; i += 1) {
      if (jumps[i]) {
        const j = 4 * N + 8 * i, ratio = i > 0 && i < N ? area[i - 1] / area[i] : 1;
        const ar = pr - (k[j] * ur - k[j + 1] * ui) - (k[j + 2] * pr - k[j + 3] * pi);
        const ai = pi - (k[j] * ui + k[j + 1] * ur) - (k[j + 2] * pi + k[j + 3] * pr);
        const br = ratio * ur - (k[j + 4] * ur - k[j + 5] * ui) - (k[j + 6] * pr - k[j + 7] * pi);
        const bi = ratio * ui - (k[j + 4] * ui + k[j + 5] * ur) - (k[j + 6] * pi + k[j + 7] * pr);
        pr = ar; pi = ai; ur = br; ui = bi;
      }
      if (i === N) break;
      const l = chain.length[i], at = 4 * i;
      const Pr = l * (sr * chain.rho[i] + k[at]), Pi = l * (si * chain.rho[i] + k[at + 1]);
      const Qr = l * (sr * chain.compliance[i] + k[at + 2]), Qi = l * (si * chain.compliance[i] + k[at + 3]);
      if (visit) visit(i, pr, pi, ur, ui, Pr, Pi, Qr, Qi);
      lineAt(Pr * Qr - Pi * Qi, Pr * Qi + Pi * Qr);
      const cr = line[0], ci = line[1], sr_ = line[2], si_ = line[3];
      const br = Pr * sr_ - Pi * si_, bi = Pr * si_ + Pi * sr_, er = Qr * sr_ - Qi * si_, ei = Qr * si_ + Qi * sr_;
      const ar = cr * pr - ci * pi - (br * ur - bi * ui), ai = cr * pi + ci * pr - (br * ui + bi * ur);
      const vr = cr * ur - ci * ui - (er * pr - ei * pi), vi = cr * ui + ci * ur - (er * pi + ei * pr);
      pr = ar; pi = ai; ur = vr; ui = vi;
    }
    const z = impedance(N - 1), dr = k[ends + 2], di = k[ends + 3];
    M.set(
      0.5 * ((1 - dr) * pr + di * pi - z * ((1 + dr) * ur - di * ui)),
      0.5 * ((1 - dr) * pi - di * pr - z * ((1 + dr) * ui + di * ur)),
    );
  };

  // The eigenvalue near a guess by the secant method; NaN where there is none within the spacing of modes. `guess` may bring F' from before.
  const solve = (chain, p, guess) => {
    let { sr, si } = guess, { dr, di } = guess;
    const start = [sr, si], longest = 0.5 * chain.spacing;
    characteristic(chain, p, sr, si);
    let fr = M.x, fi = M.y;
    if (!(dr || di)) {
      const h = 1e-6 * Math.hypot(sr, si);
      characteristic(chain, p, sr, si + h);
      // F' is dF/d(i h).
      M.over(M.x - fr, M.y - fi, 0, h);
      dr = M.x; di = M.y;
    }
    for (let steps = 0; steps < 30; steps += 1) {
      M.over(-fr, -fi, dr, di);
      let hr = M.x, hi = M.y;
      const size = Math.hypot(hr, hi), shorter = size > longest ? longest / size : 1;
      hr *= shorter; hi *= shorter;
      sr += hr; si += hi;
      if (size < 1e-8 * Math.hypot(sr, si)) {
        return Math.hypot(sr - start[0], si - start[1]) > chain.spacing ? { sr: NaN, si: NaN } : { sr, si, dr, di };
      }
      const [lr, li] = [fr, fi];
      characteristic(chain, p, sr, si);
      fr = M.x; fi = M.y;
      M.over(fr - lr, fi - li, hr, hi);
      dr = M.x; di = M.y;
      if (!Number.isFinite(dr + di)) break;
    }
    return { sr: NaN, si: NaN };
  };

  // Derivatives of the growth rate in the parameters: ds/dp = -(dF/dp)/(dF/ds), by central differences.
  const slopes = (chain, p, { sr, si, dr, di }) => model.parameters.map(({ range, sd }, k) => {
    const own = p[k], h = 1e-4 * (sd || range[1] - range[0] || 1);
    const at = (value) => { p[k] = value; characteristic(chain, p, sr, si); return [M.x, M.y]; };
    const up = at(own + h), down = at(own - h);
    p[k] = own;
    M.over(down[0] - up[0], down[1] - up[1], 2 * h * dr, 2 * h * di);
    return M.x;
  });

  // |p| along the rig, in `count` steps at least.
  const shape = (chain, p, { sr, si }, count) => {
    const points = [], each = Math.ceil(count / chain.N);
    characteristic(chain, p, sr, si, (i, pr, pi, ur, ui, Pr, Pi, Qr, Qi) => {
      for (let k = i === 0 ? 0 : 1; k <= each; k += 1) {
        const t = k / each;
        lineAt(t * t * (Pr * Qr - Pi * Qi), t * t * (Pr * Qi + Pi * Qr));
        const br = t * (Pr * line[2] - Pi * line[3]), bi = t * (Pr * line[3] + Pi * line[2]);
        const re = line[0] * pr - line[1] * pi - (br * ur - bi * ui), im = line[0] * pi + line[1] * pr - (br * ui + bi * ur);
        points.push([chain.position[i] + t * chain.length[i], Math.hypot(re, im)]);
      }
    });
    const most = Math.max(...points.map((point) => point[1]));
    return points.map(([x, size]) => [x, size / most]);
  };
  const bessel_ratio = (a, b) => { M.bessel_ratio(a, b); return [M.x, M.y]; };
  return { chain, solve, slopes, shape, fitted, cornersOf, bessel_ratio };
};
