'use strict';
// Values under the pointer, the time slider and the switch between problems. Without it the page shows the same figures and tables.
(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const make = (parent, tag, attributes) => {
    const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
    for (const name in attributes) element.setAttribute(name, attributes[name]);
    parent.appendChild(element);
    return element;
  };
  const set = (element, attributes) => {
    for (const name in attributes) element.setAttribute(name, attributes[name].toFixed(2));
  };
  const text = x => x === null || !Number.isFinite(x) ? '–' : String(Number(x.toPrecision(9))).replace('-', '−');

  // a pair of axes: from values to places and back
  const axes = g => {
    const [left, top, width, height] = g.dataset.area.split(' ').map(Number);
    const side = told => {
      const [scale, from, to] = told.split(' ');
      const log = scale === 'logarithmic', a = Number(from), b = Number(to);
      return {
        part: x => log ? Math.log(x / a) / Math.log(b / a) : (x - a) / (b - a),
        value: p => log ? a * Math.pow(b / a, p) : a + p * (b - a),
      };
    };
    const x = side(g.dataset.x), y = side(g.dataset.y);
    return {
      top, bottom: top + height,
      across: v => left + width * x.part(v),
      down: v => top + height * (1 - y.part(v)),
      inside: (px, py) => px >= left && px <= left + width && py >= top && py <= top + height,
      values: (px, py) => [x.value((px - left) / width), y.value(1 - (py - top) / height)],
    };
  };
  const place = (svg, event) => {
    const box = svg.getBoundingClientRect(), view = svg.viewBox.baseVal;
    const scale = Math.min(box.width / view.width, box.height / view.height);
    return [
      (event.clientX - box.left - (box.width - scale * view.width) / 2) / scale,
      (event.clientY - box.top - (box.height - scale * view.height) / 2) / scale,
    ];
  };
  const tip = (figure, event, words) => {
    let box = figure.querySelector('.tip');
    if (!words) { if (box) box.remove(); return; }
    if (!box) {
      box = document.createElement('div');
      box.className = 'tip';
      figure.appendChild(box);
    }
    box.textContent = words;
    const frame = figure.getBoundingClientRect();
    const left = Math.min(event.clientX - frame.left + 14, frame.width - box.offsetWidth - 2);
    box.style.left = Math.max(0, left) + 'px';
    box.style.top = Math.max(0, event.clientY - frame.top - box.offsetHeight - 10) + 'px';
  };

  // bodies in space: the faces that look at the eye, those of the farthest body first
  const inSpace = (motion, group, spots, x, y) => {
    const { centre, axes, distance, light, shade, shapes } = motion.space;
    const polygons = [...group.querySelectorAll('polygon')];
    const inner = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const less = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    const eye = centre.map((x, i) => x + distance * axes[2][i]), touches = 1e-4 * distance;
    const seen = p => {
      const from = less(p, centre), near = inner(axes[2], from), scale = distance / (distance - near);
      return [scale * inner(axes[0], from), scale * inner(axes[1], from), near];
    };
    const sum = (list, of) => list.reduce((sum, one, i) => sum + of(one, list[(i + 1) % list.length]), 0);
    const far = places => -places.reduce((sum, a) => sum + a[2], 0) / places.length;
    const side = (plane, point) => inner(plane[0], less(point, plane[1]));
    const beyond = (plane, part) => part.corners.every(corner => side(plane, corner) > -touches);
    const cannotHide = (one, other) => one.planes.some(plane => side(plane, eye) > 0 && beyond(plane, other))
      || other.planes.some(plane => side(plane, eye) < 0 && beyond(plane, one));
    const contains = (one, other) => one.planes.length > 0
      && other.corners.every(corner => one.planes.every(plane => side(plane, corner) < touches));
    const before = (one, other) => {
      if (one.ground || other.ground) return other.ground && !one.ground;
      if (!one.planes.length && !other.planes.length || contains(other, one)) return false;
      if (contains(one, other)) return true;
      if (cannotHide(one, other)) return false;
      return cannotHide(other, one) || one.far < other.far;
    };
    const part = faces => {
      const all = { corners: [], planes: [], seen: [], ground: faces.every(face => face[1]) };
      for (const [colour, ground, corners] of faces) {
        const places = corners.map(seen), line = corners.length === 2;
        all.corners.push(...corners);
        let bright = 1;
        if (!line) {
          const normal = [0, 1, 2].map(i => sum(corners, (a, b) => cross(a, b)[i])), size = Math.hypot(...normal);
          all.planes.push([normal.map(n => n / size), corners[0]]);
          if (!(sum(places, (a, b) => a[0] * b[1] - a[1] * b[0]) > 0)) continue;
          const falls = light.reduce((falls, part, i) => falls + part * inner(axes[i], normal), 0);
          bright = shade + (1 - shade) * Math.max(0, falls / size);
        }
        const paint = 'rgb(' + colour.map(part => Math.round(bright * part)) + ')';
        all.seen.push([far(places), places, paint, line ? ground ? 'edge ground' : 'edge' : 'face']);
      }
      all.seen.sort((one, other) => other[0] - one[0]);
      all.far = far(all.corners.map(seen));
      return all;
    };
    return index => {
      const numbers = motion.frames[index], parts = [], faces = [];
      let at = 0, spot = 0;
      for (const shape of shapes) {
        if (!shape) {
          const [a, b] = seen(numbers.slice(at, at += 3));
          set(spots[spot++], { cx: x(a), cy: y(b) });
          continue;
        }
        const [px, py, pz, w, ...u] = numbers.slice(at, at += 7);
        const stand = v => {
          const t = cross(u, v).map(x => 2 * x), s = cross(u, t);
          return [px + v[0] + w * t[0] + s[0], py + v[1] + w * t[1] + s[1], pz + v[2] + w * t[2] + s[2]];
        };
        const placed = shape.map(([colour, ground, flat]) => {
          const corners = [];
          for (let i = 0; i < flat.length; i += 3) corners.push(stand(flat.slice(i, i + 3)));
          return [colour, ground, corners];
        });
        const lines = placed.filter(face => face[2].length === 2), rest = placed.filter(face => face[2].length > 2);
        parts.push(...lines.map(line => part([line])));
        if (rest.length) parts.push(part(rest));
      }
      const hidden = parts.map(one => parts.map(other => one !== other && before(one, other)));
      let left = parts.map((_, i) => i);
      while (left.length) {
        let last = left.find(one => !left.some(other => hidden[one][other]));
        if (last === undefined) last = left.reduce((one, other) => parts[other].far > parts[one].far ? other : one);
        faces.push(...parts[last].seen);
        left = left.filter(one => one !== last);
      }
      while (polygons.length < faces.length) {
        const polygon = make(group, 'polygon', {});
        group.insertBefore(polygon, polygons.length ? polygons[polygons.length - 1].nextSibling : group.firstChild);
        polygons.push(polygon);
      }
      polygons.forEach((polygon, place) => {
        const [, places, colour, look] = faces[place] || [0, [], 'none', 'face'];
        polygon.setAttribute('class', look);
        polygon.setAttribute('points', places.map(([a, b]) => x(a).toFixed(2) + ',' + y(b).toFixed(2)).join(' '));
        polygon.style.fill = look === 'face' ? colour : 'none';
        polygon.style.stroke = look === 'face' ? '' : colour;
      });
    };
  };

  const motion = data.motion;
  let now = 0, go = () => {};
  const nearest = t => {
    let low = 0, high = motion.t.length - 1;
    const rising = motion.t[high] >= motion.t[0];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if ((motion.t[middle] <= t) === rising) low = middle; else high = middle;
    }
    return Math.abs(motion.t[low] - t) < Math.abs(motion.t[high] - t) ? low : high;
  };
  const movers = [];

  for (const figure of document.querySelectorAll('figure')) {
    const svg = figure.querySelector('svg.figure');
    const panels = svg ? [...svg.querySelectorAll('g.axes')].map(axes) : [];
    if (!panels.length) continue;
    const column = motion && motion.columns[figure.dataset.column];
    const path = motion && figure.dataset.path && figure.dataset.path.split(' ').map(name => motion.columns[name]);
    const points = data.points && data.points[figure.dataset.points];
    const output = figure.querySelector('output');
    if (column) {
      const [panel] = panels;
      const line = make(svg, 'line', { class: 'cursor', y1: panel.top, y2: panel.bottom });
      const dot = make(svg, 'circle', { class: 'now', r: 3.5 });
      movers.push(index => {
        const x = panel.across(motion.t[index]), value = column.values[index];
        set(line, { x1: x, x2: x });
        dot.style.display = value === null ? 'none' : '';
        if (value !== null) set(dot, { cx: x, cy: panel.down(value) });
        output.textContent = text(value) + (column.unit ? ' ' + column.unit : '');
      });
    } else if (path) {
      const dot = make(svg, 'circle', { class: 'now', r: 5 });
      movers.push(index => {
        const [x, y] = path.map(of => of.values[index]);
        set(dot, { cx: panels[0].across(x), cy: panels[0].down(y) });
        output.textContent = '(' + text(x) + ', ' + text(y) + ')';
      });
    }
    const says = (px, py) => {
      const panel = panels.find(panel => panel.inside(px, py));
      if (!panel) return null;
      const [x, y] = panel.values(px, py);
      if (column) {
        const index = nearest(x);
        return ['t = ' + text(motion.t[index]) + ' s\n' + column.label + ' = ' + text(column.values[index]), index];
      }
      const among = points || (path && motion.t.map((t, index) =>
        [path[0].values[index], path[1].values[index], 't = ' + text(t) + ' s']));
      if (!among) return ['(' + Number(x.toPrecision(4)) + ', ' + Number(y.toPrecision(4)) + ')', null];
      let best = Infinity, found = null;
      among.forEach(([a, b, words], index) => {
        const distance = Math.hypot(panel.across(a) - px, panel.down(b) - py);
        if (distance < best) { best = distance; found = [words, path ? index : null]; }
      });
      return best < 40 ? found : null;
    };
    svg.addEventListener('pointermove', event => {
      const found = says(...place(svg, event));
      tip(figure, event, found && found[0]);
      if (found && found[1] !== null && event.buttons) go(found[1]);
    });
    svg.addEventListener('pointerdown', event => {
      const found = says(...place(svg, event));
      if (found && found[1] !== null) go(found[1]);
    });
    svg.addEventListener('pointerleave', event => tip(figure, event, null));
  }

  const scene = document.getElementById('mechanism');
  if (scene && motion) {
    const [scale, left, top] = scene.dataset.scale.split(' ').map(Number);
    const x = v => left + scale * v, y = v => top - scale * v;
    const shapes = [...scene.querySelectorAll('.shape')];
    if (motion.space) movers.push(inSpace(motion, document.getElementById('moving'), shapes, x, y));
    else movers.push(index => {
      const numbers = motion.frames[index];
      let at = 0;
      for (const shape of shapes) {
        const take = count => numbers.slice(at, at += count);
        if (shape.dataset.kind === 'rod') {
          const [a, b, c, d] = take(4);
          set(shape, { x1: x(a), y1: y(b), x2: x(c), y2: y(d) });
        } else if (shape.dataset.kind === 'wheel') {
          const [a, b, radius, angle] = take(4);
          set(shape.querySelector('circle'), { cx: x(a), cy: y(b), r: scale * radius });
          set(shape.querySelector('line'), {
            x1: x(a), y1: y(b), x2: x(a + radius * Math.cos(angle)), y2: y(b + radius * Math.sin(angle)),
          });
        } else {
          const [a, b] = take(2);
          set(shape, { cx: x(a), cy: y(b) });
        }
      }
    });
  }

  const slider = document.getElementById('time');
  if (slider && motion) {
    const said = document.getElementById('now'), play = document.getElementById('play');
    go = index => {
      now = index;
      slider.value = index;
      const words = 't = ' + text(motion.t[index]) + ' s';
      slider.setAttribute('aria-valuetext', words);
      said.textContent = words;
      for (const move of movers) move(index);
    };
    slider.addEventListener('input', () => go(Number(slider.value)));
    const last = motion.t.length - 1, span = Math.abs(motion.t[last] - motion.t[0]);
    let playing = null;
    const stop = () => { cancelAnimationFrame(playing); playing = null; play.textContent = 'Play'; };
    play.addEventListener('click', () => {
      if (playing !== null) return stop();
      if (now >= last) go(0);
      const from = motion.t[now], sign = motion.t[last] < motion.t[0] ? -1 : 1, rate = sign * Math.max(1, span / 30);
      let begun = null;
      const tick = time => {
        begun = begun === null ? time : begun;
        go(nearest(from + rate * (time - begun) / 1000));
        if (now >= last) stop(); else playing = requestAnimationFrame(tick);
      };
      play.textContent = 'Pause';
      playing = requestAnimationFrame(tick);
    });
    slider.closest('.controls').hidden = false;
    go(0);
  }

  for (const choice of document.querySelectorAll('fieldset.switch')) {
    const figures = document.querySelectorAll('figure[data-switch="' + choice.id + '"]');
    const choose = () => {
      const wanted = choice.querySelector('input:checked').value;
      for (const figure of figures) figure.hidden = figure.dataset.choice !== wanted;
    };
    choice.addEventListener('change', choose);
    choice.hidden = false;
    choose();
  }
})();
