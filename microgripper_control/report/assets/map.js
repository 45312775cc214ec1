"use strict";
// A figure of coloured cells: a mean over two quantities, below zero blue, above it orange.

const ENDS = [[0, 68, 136], [238, 240, 242], [179, 76, 0]]; // at -limit, 0 and +limit
const FRAME = { left: 56, right: 8, top: 42, bottom: 34, height: 300 };

function colour(value, limit) {
  const t = clamp(value / limit, -1, 1);
  const [from, to] = [ENDS[1], t < 0 ? ENDS[0] : ENDS[2]];
  const parts = from.map((part, i) => Math.round(part + (to[i] - part) * Math.abs(t) ** 0.8));
  return `rgb(${parts.join(",")})`;
}

class MapChart {
  constructor(box, spec, title) {
    Object.assign(this, { box, spec, title });
    this.output = make("p", { class: "readout" });
    this.holders = spec.panels.map(() => make("div", { class: "plot" }));
    box.replaceChildren(make("div", { class: "pair" }, ...this.holders), this.key(), this.output);
    this.draw();
  }

  draw(width) {
    this.holders.forEach((holder, i) => this.panel(holder, this.spec.panels[i], width));
  }

  panel(holder, { name, values }, width = holder.clientWidth) {
    if (width === 0) return; // not to be seen now
    const { x: xAxis, y: yAxis, columns, limit } = this.spec;
    const rows = values.length / columns;
    const x = new Scale(xAxis.low, xAxis.high, FRAME.left, width - FRAME.right, false);
    const y = new Scale(0, 1, FRAME.height - FRAME.bottom, FRAME.top, false);
    const [cellWidth, cellHeight] = [(x.to - x.from) / columns, (y.from - y.to) / rows];
    const svg = make("svg:svg", {
      viewBox: `0 0 ${width} ${FRAME.height}`, width, height: FRAME.height, role: "img",
      "aria-label": `${this.title}, ${name}: mean residual over ${xAxis.label} and ${yAxis.label}`,
    });
    svg.append(make("svg:text", { class: "panel", x: 2, y: 13 }, name));
    values.forEach((value, i) => {
      if (value === null) return;
      const [column, row] = [i % columns, Math.floor(i / columns)];
      svg.append(make("svg:rect", {
        x: (x.from + column * cellWidth).toFixed(1), width: (cellWidth + 0.3).toFixed(1),
        y: (y.from - (row + 1) * cellHeight).toFixed(1), height: (cellHeight + 0.3).toFixed(1),
        fill: colour(value, limit),
      }));
    });
    svg.append(...this.frame(x, y));
    svg.addEventListener("pointermove", (event) => {
      const area = svg.getBoundingClientRect();
      const scale = width / area.width;
      const across = (event.clientX - area.left) * scale;
      const column = Math.floor((across - x.from) / cellWidth);
      const row = Math.floor((y.from - (event.clientY - area.top) * scale) / cellHeight);
      const inside = column >= 0 && column < columns && row >= 0 && row < rows;
      this.read(inside ? values[row * columns + column] : null, x.value(across));
    });
    holder.replaceChildren(svg);
  }

  read(value, at) {
    const { x, unit } = this.spec;
    const place = `${formatted(at, 3)} ${x.unit}`;
    this.output.textContent = value === null ? "" : `At ${place}: ${formatted(value, 3)} ${unit}`;
  }

  frame(x, y) {
    const { x: xAxis, y: yAxis } = this.spec;
    const text = (attributes, content) => make("svg:text", attributes, content);
    const drawn = x.ticks(48).map((value) =>
      text({ class: "tick", x: x.pixel(value), y: y.from + 14, "text-anchor": "middle" },
        formatted(value)));
    for (const [at, label] of yAxis.ticks) {
      const level = y.pixel(at);
      drawn.push(text({ class: "tick", x: x.from - 6, y: level + 4, "text-anchor": "end" }, label));
      drawn.push(make("svg:line",
        { class: "grid", x1: x.from - 4, x2: x.from, y1: level, y2: level }));
    }
    const edges = { x: x.from, y: y.to, width: x.to - x.from, height: y.from - y.to };
    drawn.push(make("svg:rect", { class: "edge", ...edges }));
    for (const [low, high] of xAxis.bands) {
      drawn.push(make("svg:line", { class: "where", y1: y.from, y2: y.from,
        x1: x.pixel(Math.max(low, x.low)), x2: x.pixel(Math.min(high, x.high)) }));
    }
    drawn.push(text({ class: "axis", x: x.to, y: FRAME.height - 4, "text-anchor": "end" },
      named(xAxis)));
    drawn.push(text({ class: "axis", x: 2, y: 32 },
      named(yAxis)));
    return drawn;
  }

  /** The colours and what they stand for. */
  key() {
    const { limit, unit } = this.spec;
    const steps = Array.from({ length: 41 }, (_, i) => (i / 20 - 1) * limit);
    const bar = make("svg:svg", { width: 164, height: 12, "aria-hidden": "true" });
    steps.forEach((value, i) => bar.append(make("svg:rect",
      { x: 4 * i, y: 0, width: 4.3, height: 12, fill: colour(value, limit) })));
    const end = `${formatted(limit, 2)} ${unit}`;
    return make("p", { class: "key" }, `${MINUS}${end}`, bar, end);
  }
}
