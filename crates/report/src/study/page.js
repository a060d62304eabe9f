// Shows what is known of a measured point under the pointer or the focus, and marks it in every figure. Without it the page has all that in tables and titles.
(() => {
  // A table that is wider than the window can be moved by the keyboard.
  const reach = () => {
    for (const wide of document.querySelectorAll('.wide')) {
      if (wide.scrollWidth > wide.clientWidth) wide.setAttribute('tabindex', '0'); else wide.removeAttribute('tabindex');
    }
  };
  reach();
  window.addEventListener('resize', reach);
  document.addEventListener('toggle', reach, true);
  const known = JSON.parse(document.getElementById('points').textContent);
  // The remark of a dot, or of another symbol, begins with the name of its point.
  const dots = [...document.querySelectorAll('figure circle, figure path')].filter((dot) => {
    const name = dot.querySelector('title')?.textContent.split(':')[0];
    if (known[name]) dot.dataset.point = name;
    return known[name];
  });
  if (dots.length === 0) return;
  const note = document.createElement('div');
  note.id = 'note';
  note.setAttribute('role', 'status');
  note.hidden = true;
  document.body.append(note);
  const stage = (dot) => dot.closest('figure').dataset.stage ?? '';
  const titles = new Map(Object.values(known).flat().map(([stage]) => [stage, document.getElementById(stage)?.textContent ?? stage]));
  const words = (what, unit, value, sd, predicted, residual) => {
    const left = residual === null ? '' : `, residual ${residual < 0 ? '-' : '+'}${Math.abs(residual).toFixed(1)} sd`;
    return `${what} ${value.toFixed(3)} \u00b1 ${sd.toFixed(3)} ${unit}, predicted ${predicted.toFixed(3)}${left}`;
  };
  const text = (dot) => {
    const all = known[dot.dataset.point];
    const own = all.filter((line) => line[0] === stage(dot));
    return (own.length ? own : all).map(([stage, mode, both]) => {
      const parts = both.flatMap((number, k) => (number ? [words(['growth rate', 'frequency'][k], ['1/s', 'Hz'][k], ...number)] : []));
      return `${titles.get(stage)}${mode && `, mode ${mode}`}: ${parts.join('; ')}`;
    });
  };
  const show = (dot) => {
    note.replaceChildren(...[dot.dataset.point, ...text(dot)].map((words, k) => {
      const line = document.createElement(k === 0 ? 'b' : 'div');
      line.textContent = words;
      return line;
    }));
    note.hidden = false;
    const at = dot.getBoundingClientRect(), own = note.getBoundingClientRect();
    const left = Math.min(Math.max(at.left - own.width / 2, 4), document.documentElement.clientWidth - own.width - 4);
    const above = at.top - own.height - 8;
    note.style.left = `${left + window.scrollX}px`;
    note.style.top = `${(above > 0 ? above : at.bottom + 8) + window.scrollY}px`;
  };
  const hide = () => { note.hidden = true; };
  const mark = (id) => {
    for (const dot of dots) {
      if (dot.dataset.point === id) dot.setAttribute('aria-pressed', String(dot.classList.toggle('marked')));
    }
  };
  // One stop of the tabulator for each panel; arrows go from point to point.
  const panels = new Map();
  for (const dot of dots) {
    const panel = dot.ownerSVGElement;
    if (!panels.has(panel)) panels.set(panel, []);
    panels.get(panel).push(dot);
  }
  for (const [panel, list] of panels) {
    // A picture may not hold what can be pressed.
    panel.ownerSVGElement?.setAttribute('role', 'group');
    const across = (dot) => Number(dot.getAttribute('cx') ?? dot.getBBox().x + dot.getBBox().width / 2);
    list.sort((a, b) => across(a) - across(b));
    list.forEach((dot, k) => {
      dot.setAttribute('tabindex', k === 0 ? '0' : '-1');
      dot.setAttribute('role', 'button');
      dot.setAttribute('aria-pressed', 'false');
      dot.setAttribute('aria-label', [dot.dataset.point, ...text(dot)].join('. '));
      dot.addEventListener('pointerenter', () => show(dot));
      dot.addEventListener('pointerleave', hide);
      dot.addEventListener('focus', () => show(dot));
      dot.addEventListener('blur', hide);
      dot.addEventListener('click', () => { mark(dot.dataset.point); show(dot); });
      dot.addEventListener('keydown', (event) => {
        const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
        if (event.key === 'Enter' || event.key === ' ') mark(dot.dataset.point);
        else if (event.key === 'Escape') hide();
        else if (step) {
          const next = list[(k + step + list.length) % list.length];
          dot.setAttribute('tabindex', '-1');
          next.setAttribute('tabindex', '0');
          next.focus();
        } else return;
        event.preventDefault();
      });
    });
  }
})();
