// Draws each <figure class="plot"> from the numbers inside it. Drag to zoom, double click to see
// everything again, move to read values. Without scripts the still picture beside them is shown.
"use strict";
(() => {
  const WIDEST = 880, NARROWEST = 340, HEIGHT = 200, RIGHT = 14, BELOW = 40, ROW = 16, LETTER = 6.3;
  const NS = "http://www.w3.org/2000/svg";
  const make = (name, attributes, parent, text) => {
    const node = document.createElementNS(NS, name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    if (text !== undefined) node.textContent = text;
    if (parent) parent.appendChild(node);
    return node;
  };
  const ends = (values, log) => {
    let low = Infinity, high = -Infinity;
    for (const v of values) {
      if (v === null || (log && v <= 0)) continue;
      if (v < low) low = v;
      if (v > high) high = v;
    }
    if (!(low <= high)) return log ? [0.1, 1] : [0, 1];
    if (log) return [low / 1.15, high * 1.15];
    const room = low === high ? Math.abs(low) || 1 : high - low;
    return [low - 0.04 * room, high + 0.04 * room];
  };
  const raised = (n) => String(n).replace(/./g, (c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻");
  const plain = (v) => v === 0 || (Math.abs(v) < 1e5 && Math.abs(v) >= 1e-3);
  // powers of ten for all of an axis, or for none
  const number = (v, decimal = plain(v)) => {
    if (decimal || v === 0) return String(+v.toPrecision(5)).replace("-", "−");
    const [digits, power] = v.toExponential(2).split("e"), short = String(+digits).replace("-", "−");
    return `${short === "1" ? "" : `${short}·`}10${raised(+power)}`;
  };
  const numbers = (values) => values.map((v) => number(v, values.every(plain)));
  const ticks = ([low, high], log) => {
    const found = [];
    if (log && high / low > 5) {
      for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); e++)
        for (const m of high / low > 1e3 ? [1] : [1, 2, 5]) {
          const v = m * 10 ** e;
          if (v >= low && v <= high) found.push(v);
        }
      return found;
    }
    const raw = (high - low) / 6, size = 10 ** Math.floor(Math.log10(raw));
    const step = size * [1, 2, 5, 10].find((m) => m * size >= raw);
    for (let k = Math.ceil(low / step); k * step <= high; k++) found.push(k * step);
    return found;
  };

  const draw = (figure) => {
    const panels = JSON.parse(figure.querySelector("script").textContent);
    // evenly spaced values are three numbers
    for (const s of panels.flatMap((p) => p.series))
      if (!Array.isArray(s.x)) s.x = Array.from({ length: s.x.count }, (_, k) => s.x.from + k * s.x.step);
    const W = Math.min(WIDEST, Math.max(NARROWEST, figure.clientWidth || WIDEST));
    // a picture a panel, so that a page can break between them
    const pictures = panels.map(() => {
      const svg = make("svg", { role: "img" });
      return figure.insertBefore(svg, figure.querySelector("figcaption"));
    });
    const whole = panels.map((p) => ({
      x: ends(p.series.flatMap((s) => s.x), p.x.log),
      y: ends(p.series.flatMap((s) => (s.y || []).concat(s.low || [], s.high || [])), p.y.log),
    }));
    let seen = whole.map((r) => ({ ...r })), LEFT = 0;

    const panel = (p, i) => {
      const { x, y } = seen[i], svg = pictures[i];
      // the legend stands above the axes, in as many rows as it takes
      const named = p.series.filter((s) => s.name), places = [];
      let column = LEFT, row = 0;
      for (const s of named) {
        const width = 34 + LETTER * s.name.length;
        if (column > LEFT && column + width > W) { column = LEFT; row += 1; }
        places.push([column, 6 + ROW * row]);
        column += width;
      }
      const top = 10 + (named.length ? ROW * (row + 1) : 0), bottom = top + HEIGHT;
      svg.setAttribute("viewBox", `0 0 ${W} ${bottom + BELOW}`);
      const at = (v, [low, high], log, from, to) => {
        const part = log ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low);
        return from + part * (to - from);
      };
      const px = (v) => at(v, x, p.x.log, LEFT, W - RIGHT), py = (v) => at(v, y, p.y.log, bottom, top);
      const value = (pixel, [low, high], log, from, to) => {
        const part = (pixel - from) / (to - from);
        return log ? low * (high / low) ** part : low + part * (high - low);
      };
      const group = make("g", {}, svg);
      const clip = make("clipPath", { id: `${figure.id}-${i}` }, group);
      make("rect", { x: LEFT, y: top, width: W - LEFT - RIGHT, height: bottom - top }, clip);
      const across = ticks(x, p.x.log), up = ticks(y, p.y.log);
      const [below, beside] = [numbers(across), numbers(up)];
      across.forEach((v, k) => {
        make("line", { x1: px(v), x2: px(v), y1: top, y2: bottom, class: "grid" }, group);
        make("text", { x: px(v), y: bottom + 14, "text-anchor": "middle" }, group, below[k]);
      });
      up.forEach((v, k) => {
        make("line", { x1: LEFT, x2: W - RIGHT, y1: py(v), y2: py(v), class: "grid" }, group);
        make("text", { x: LEFT - 6, y: py(v) + 4, "text-anchor": "end" }, group, beside[k]);
      });
      make("text", { x: (LEFT + W - RIGHT) / 2, y: bottom + 31, "text-anchor": "middle" }, group, p.x.label);
      make("text", { x: 14, y: (top + bottom) / 2, "text-anchor": "middle", transform: `rotate(-90 14 ${(top + bottom) / 2})` }, group, p.y.label);
      const inside = make("g", { "clip-path": `url(#${figure.id}-${i})` }, group);
      for (const m of p.marks) {
        make("line", { x1: px(m.x), x2: px(m.x), y1: top, y2: bottom, class: "mark" }, inside);
        const late = px(m.x) + 8 + LETTER * m.name.length > W - RIGHT;
        make("text", { x: px(m.x) + (late ? -3 : 3), y: bottom - 4, "text-anchor": late ? "end" : "start" }, inside, m.name);
      }
      for (const s of p.series) {
        const shown = (v, log) => v !== null && !(log && v <= 0);
        if (s.kind === "band") {
          const up = s.x.map((v, k) => `${px(v)},${py(s.high[k])}`);
          const down = s.x.map((v, k) => `${px(v)},${py(s.low[k])}`).reverse();
          make("polygon", { points: up.concat(down).join(" "), fill: s.colour, opacity: 0.18 }, inside);
        } else if (s.kind === "dots") {
          s.x.forEach((v, k) => shown(s.y[k], p.y.log) && make("circle", { cx: px(v), cy: py(s.y[k]), r: 2.4, fill: s.colour }, inside));
        } else {
          let path = "", pen = "M";
          s.x.forEach((v, k) => {
            if (!shown(s.y[k], p.y.log)) { pen = "M"; return; }
            path += `${pen}${px(v).toFixed(1)} ${py(s.y[k]).toFixed(1)}`;
            pen = "L";
          });
          make("path", { d: path, fill: "none", stroke: s.colour, "stroke-width": 1.3, "stroke-dasharray": s.kind === "dashes" ? "5 4" : "none" }, inside);
        }
      }
      make("rect", { x: LEFT, y: top, width: W - LEFT - RIGHT, height: bottom - top, class: "frame" }, group);
      named.forEach((s, k) => {
        const [left, high] = places[k];
        make("rect", { x: left, y: high, width: 14, height: 4, fill: s.colour, opacity: s.kind === "band" ? 0.35 : 1 }, group);
        make("text", { x: left + 18, y: high + 6 }, group, s.name);
      });
      return { value, top, bottom };
    };

    const render = () => {
      const longest = Math.max(...panels.flatMap((p, i) => numbers(ticks(seen[i].y, p.y.log)).map((text) => text.length)), 1);
      LEFT = 32 + LETTER * longest;
      panels.forEach((p, i) => listen(p, i, pictures[i]));
    };
    const listen = (p, i, svg) => {
      svg.replaceChildren();
      const d = panel(p, i);
      const mouse = (event) => {
        const box = svg.getBoundingClientRect(), scale = W / box.width;
        return { x: (event.clientX - box.left) * scale, y: (event.clientY - box.top) * scale };
      };
      const box = make("rect", { class: "zoom", visibility: "hidden" }, svg);
      const line = make("line", { class: "mark", visibility: "hidden" }, svg);
      const words = make("text", { class: "read", "text-anchor": "end" }, svg);
      let start = null;
      svg.onpointerdown = (event) => { start = mouse(event); svg.setPointerCapture(event.pointerId); };
      svg.onpointermove = (event) => {
        const now = mouse(event);
        if (start) {
          const set = { x: Math.min(start.x, now.x), y: Math.min(start.y, now.y), width: Math.abs(now.x - start.x), height: Math.abs(now.y - start.y), visibility: "visible" };
          for (const key in set) box.setAttribute(key, set[key]);
          return;
        }
        const x = d.value(now.x, seen[i].x, p.x.log, LEFT, W - RIGHT);
        const near = (s) => s.x.reduce((best, v, k) => (Math.abs(v - x) < Math.abs(s.x[best] - x) ? k : best), 0);
        const read = p.series.filter((s) => s.name && s.x.length).map((s) => {
          const k = near(s), value = s.kind === "band" ? `${number(s.low[k])} to ${number(s.high[k])}` : s.y[k] === null ? "–" : number(s.y[k]);
          return `${s.name} ${value}`;
        });
        words.textContent = [number(x), ...read].join("   ");
        words.setAttribute("x", W - RIGHT - 6);
        words.setAttribute("y", d.bottom - 6);
        for (const [key, v] of [["x1", now.x], ["x2", now.x], ["y1", d.top], ["y2", d.bottom], ["visibility", "visible"]]) line.setAttribute(key, v);
      };
      svg.onpointerleave = () => { line.setAttribute("visibility", "hidden"); words.textContent = ""; };
      svg.onpointerup = (event) => {
        if (!start) return;
        const from = start, to = mouse(event);
        start = null;
        box.setAttribute("visibility", "hidden");
        if (Math.abs(to.x - from.x) < 6 || Math.abs(to.y - from.y) < 6) return;
        const clamp = (v, low, high) => Math.min(high, Math.max(low, v));
        const [a, b] = [from.x, to.x].sort((m, n) => m - n).map((v) => clamp(v, LEFT, W - RIGHT));
        const [c, e] = [from.y, to.y].sort((m, n) => n - m).map((v) => clamp(v, d.top, d.bottom));
        const old = seen[i];
        const x = [a, b].map((v) => d.value(v, old.x, p.x.log, LEFT, W - RIGHT));
        const y = [c, e].map((v) => d.value(v, old.y, p.y.log, d.bottom, d.top));
        // panels over the same quantity move together
        seen = seen.map((r, k) => ({ x: panels[k].x.label === p.x.label ? x : r.x, y: k === i ? y : r.y }));
        render();
      };
      svg.ondblclick = () => { seen = whole.map((r) => ({ ...r })); render(); };
    };
    render();
  };
  document.querySelectorAll("figure.plot").forEach(draw);
})();
