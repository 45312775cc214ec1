"use strict";
// A figure of lines: legend that shows and hides them, a cursor that reads them, zoom by dragging.

const MARGIN = { left: 52, right: 10, top: 24, bottom: 34 };
const HEIGHT = { low: 190, high: 330, flat: 126, share: 0.42 };
const DRAG = 8; // pixels; less is a click
let clips = 0;

/** Figures over one axis: they zoom and are read together. */
class Group {
  constructor() {
    Object.assign(this, { charts: [], range: null, cursor: null });
  }
  zoom(range) {
    this.range = range;
    this.charts.forEach((chart) => chart.draw());
  }
  read(x) {
    this.cursor = x;
    this.charts.forEach((chart) => chart.showCursor());
  }
}

class LineChart {
  constructor(box, spec, group, title, time) {
    Object.assign(this, { box, spec, group, title, yRange: null });
    this.series = spec.series.map((line) => {
      const [x, y] = [unpackAxis(line.x ?? spec.across), unpack(line.y)];
      return { ...line, x, y, even: line.x !== null && line.x.base64 === undefined, shown: !line.hidden };
    });
    this.whole = spec.reach ?? extent(this.series.map((line) => line.x));
    const single = spec.series.length === 1 ? " single" : "";
    this.legend = make("div", { class: `legend${single}` });
    this.holder = make("div", { class: "plot" });
    box.replaceChildren(this.legend, this.holder);
    this.makeLegend();
    group.charts.push(this);
    if (spec.times) {
      this.times = unpack(spec.times);
      this.time = time;
      time.charts.push(this);
    }
    this.draw();
  }

  makeLegend() {
    for (const line of this.series) {
      line.value = make("span", { class: "value" });
      const swatch = make("svg:svg", { width: 22, height: 8, "aria-hidden": "true" });
      swatch.append(make("svg:line", { x1: 0, x2: 22, y1: 4, y2: 4, ...stroke(line, 2.5) }));
      const button = make("button", { type: "button", "aria-pressed": String(line.shown) });
      button.append(swatch, make("span", {}, line.name), line.value);
      button.addEventListener("click", () => {
        line.shown = !line.shown;
        button.setAttribute("aria-pressed", String(line.shown));
        this.draw();
      });
      this.legend.append(this.series.length > 1 ? button : line.value);
    }
    this.at = make("span", { class: "at" });
    this.reset = make("button", { type: "button", class: "reset", hidden: "" }, "Whole range");
    this.reset.addEventListener("click", () => this.zoom(null, null));
    this.legend.append(this.at, this.reset);
  }

  zoom(range, yRange) {
    this.yRange = yRange;
    this.group.zoom(range);
  }

  draw(width = this.holder.clientWidth, share = HEIGHT.share) {
    if (width === 0) return; // not to be seen now
    const height = this.spec.flat
      ? HEIGHT.flat
      : Math.round(Math.min(HEIGHT.high, Math.max(HEIGHT.low, width * share)));
    const { x: xAxis, y: yAxis } = this.spec;
    const [low, high] = this.group.range ?? this.whole;
    this.x = new Scale(low, high, MARGIN.left, width - MARGIN.right, xAxis.log);
    const [bottom, top] = this.yRange ?? this.heightOf(low, high);
    this.y = new Scale(bottom, top, height - MARGIN.bottom, MARGIN.top, yAxis.log);
    this.reset.hidden = this.group.range === null && this.yRange === null;
    const svg = make("svg:svg", {
      viewBox: `0 0 ${width} ${height}`, width, height, tabindex: "0", role: "img",
      "aria-label": `${this.title}: ${yAxis.label} over ${xAxis.label}. ` +
        "Arrow keys read it, plus and minus zoom, Escape shows the whole range.",
    });
    const clip = `clip${clips++}`;
    const area = { x: MARGIN.left, y: MARGIN.top, width: this.x.to - this.x.from,
      height: this.y.from - this.y.to };
    svg.append(make("svg:clipPath", { id: clip }, make("svg:rect", area)));
    const inside = make("svg:g", { "clip-path": `url(#${clip})` });
    for (const band of this.spec.bands ?? []) inside.append(this.band(band));
    svg.append(inside, ...axes(this.x, this.y, xAxis, yAxis, width, height));
    const lines = make("svg:g", { "clip-path": `url(#${clip})`, fill: "none" });
    for (const level of this.spec.levels ?? []) lines.append(...this.level(level));
    for (const line of this.series.filter((each) => each.shown)) lines.append(...this.line(line));
    this.mark = make("svg:line", { class: "cursor", y1: this.y.to, y2: this.y.from, hidden: "" });
    this.selected = make("svg:rect", { class: "selection", hidden: "" });
    lines.append(this.mark, this.selected);
    svg.append(lines);
    const focused = this.holder.contains(document.activeElement);
    this.holder.replaceChildren(svg);
    listen(this, svg);
    if (focused) svg.focus({ preventScroll: true });
    this.showCursor();
  }

  /** The range of the lines that are shown, between two places; of all, what they say of it. */
  heightOf(low, high) {
    const { y: axis, levels = [] } = this.spec;
    const within = (line) => line.y.filter((_, i) => line.x[i] >= low && line.x[i] <= high);
    const shown = this.series.filter((line) => line.shown);
    const near = shown.map((line) => (this.group.range === null && line.height) || within(line));
    const [bottom, top] = extent([...near, levels.map((level) => level.y)]);
    if (axis.log) return [bottom / 1.6, top * 1.3];
    const room = 0.05 * (top - bottom) || 0.5 * Math.abs(top) || 1;
    return [bottom - room, top + room];
  }

  band({ low, high, kind, name }) {
    const [from, to] = [this.x.pixel(Math.max(low, this.x.low)), this.x.pixel(high)];
    const size = { x: from, width: Math.max(1, to - from), y: MARGIN.top };
    const text = kind === "gap" ? `The gap lies here: ${name}` : "Errors are taken here";
    const height = this.y.from - this.y.to;
    return make("svg:rect", { class: kind, height, ...size }, make("svg:title", {}, text));
  }

  level({ y, name }) {
    const at = this.y.pixel(y);
    const ends = { x1: this.x.from, x2: this.x.to, y1: at, y2: at };
    const label = { class: "level", x: this.x.to - 4, y: at + 15, "text-anchor": "end" };
    return [make("svg:line", { class: "level", ...ends }), make("svg:text", label, name)];
  }

  line(line) {
    const points = line.even ? this.columns(line) : this.all(line);
    const [x, y] = [this.x, this.y];
    const at = points.map(([a, b]) => [x.pixel(a).toFixed(1), y.pixel(b).toFixed(1)]);
    const path = { d: `M${at.map((pair) => pair.join(" ")).join("L")}`, ...stroke(line, 1.4) };
    const drawn = [make("svg:path", path)];
    if (line.dots) {
      const dot = ([cx, cy]) => make("svg:circle", { cx, cy, r: 3, fill: line.colour });
      drawn.push(...at.map(dot));
    }
    return drawn;
  }

  /** Every point, or of a line with times those of the part that is looked at. */
  all({ x, y }) {
    const points = Array.from(x, (value, i) => [value, y[i]]);
    const range = this.time?.range;
    if (!range) return points;
    return points.filter((_, i) => this.times[i] >= range[0] && this.times[i] <= range[1]);
  }

  /** What is in view of an evenly sampled line: the lowest and highest of each pixel's column. */
  columns({ x, y }) {
    const last = Math.min(x.length - 1, nearest(x, this.x.high) + 1);
    const first = Math.max(0, nearest(x, this.x.low) - 1);
    const per = Math.floor((last - first) / (2 * (this.x.to - this.x.from)));
    const points = [];
    for (let i = first; i <= last; i += Math.max(1, per)) {
      let [low, high] = [i, i];
      for (let j = i; j < Math.min(i + per, last + 1); j++) {
        if (y[j] < y[low]) low = j;
        if (y[j] > y[high]) high = j;
      }
      for (const k of low < high ? [low, high] : [high, low]) points.push([x[k], y[k]]);
    }
    return points;
  }

  showCursor() {
    const at = this.group.cursor;
    const seen = at !== null && at >= this.x.low && at <= this.x.high && !this.spec.box;
    this.mark.toggleAttribute("hidden", !seen);
    this.at.textContent = seen ? `${formatted(at)} ${this.spec.x.unit}` : "";
    for (const line of this.series) {
      const value = seen && line.shown ? formatted(line.y[nearest(line.x, at)]) : "";
      line.value.textContent = value && `${value} ${this.spec.y.unit}`;
    }
    if (!seen) return;
    this.mark.setAttribute("x1", this.x.pixel(at));
    this.mark.setAttribute("x2", this.x.pixel(at));
  }
}

function stroke({ colour, dash = "", width }, usual) {
  const style = { stroke: colour, "stroke-width": width ?? usual, "stroke-linejoin": "round" };
  return dash ? { ...style, "stroke-dasharray": dash } : style;
}

/** Lowest and highest of several arrays. */
function extent(arrays) {
  let [low, high] = [Infinity, -Infinity];
  for (const values of arrays) {
    for (const value of values) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return low <= high ? [low, high] : [0, 1];
}

/** Index of the value of a rising array that lies nearest. */
function nearest(values, wanted) {
  let [low, high] = [0, values.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= wanted) low = middle;
    else high = middle;
  }
  return wanted - values[low] <= values[high] - wanted ? low : high;
}
