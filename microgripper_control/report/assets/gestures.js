"use strict";
// Pointer and keys on a figure of lines.

/** Move to read, drag to zoom, double click for the whole; the same by keys. */
function listen(chart, svg) {
  let start = null;
  const place = (event) => {
    const frame = svg.getBoundingClientRect();
    const scale = svg.viewBox.baseVal.width / frame.width;
    return [(event.clientX - frame.left) * scale, (event.clientY - frame.top) * scale];
  };
  svg.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    start = place(event);
    svg.setPointerCapture(event.pointerId);
  });
  svg.addEventListener("pointermove", (event) => {
    const here = place(event);
    chart.group.read(clamp(chart.x.value(here[0]), chart.x.low, chart.x.high));
    if (start !== null) select(chart, start, here);
  });
  svg.addEventListener("pointerup", (event) => {
    const [from, to] = [start, place(event)];
    start = null;
    chart.selected.toggleAttribute("hidden", true);
    if (from === null || Math.abs(to[0] - from[0]) < DRAG) return;
    const x = between(chart.x, from[0], to[0]);
    chart.zoom(x, chart.spec.box ? between(chart.y, from[1], to[1]) : null);
  });
  svg.addEventListener("pointercancel", () => {
    start = null;
    chart.selected.toggleAttribute("hidden", true);
  });
  svg.addEventListener("pointerleave", () => chart.group.read(null));
  svg.addEventListener("dblclick", () => chart.zoom(null, null));
  svg.addEventListener("keydown", (event) => press(chart, event));
}

/** The part of a scale between two pixels, within the scale. */
function between(scale, one, other) {
  const ends = [one, other].map((pixel) => clamp(scale.value(pixel), scale.low, scale.high));
  return [Math.min(...ends), Math.max(...ends)];
}

function clamp(value, low, high) {
  return Math.min(high, Math.max(low, value));
}

function select(chart, from, to) {
  const [left, right] = [from[0], to[0]].sort((a, b) => a - b);
  const [up, down] = chart.spec.box
    ? [from[1], to[1]].sort((a, b) => a - b)
    : [chart.y.to, chart.y.from];
  const size = { x: left, y: up, width: right - left, height: down - up };
  for (const [key, value] of Object.entries(size)) chart.selected.setAttribute(key, value);
  chart.selected.toggleAttribute("hidden", right - left < DRAG);
}

function press(chart, event) {
  const { x, group } = chart;
  const middle = group.cursor ?? x.value((x.from + x.to) / 2);
  const at = x.pixel(middle);
  const zoomed = (factor) =>
    [x.from, x.to].map((end) => clamp(x.value(at + (end - at) * factor), ...chart.whole));
  const step = event.shiftKey ? 20 : 2; // pixels
  const moved = (by) => group.read(clamp(x.value(at + by), x.low, x.high));
  const actions = {
    ArrowLeft: () => moved(-step),
    ArrowRight: () => moved(step),
    "+": () => chart.zoom(zoomed(0.5), chart.yRange),
    "-": () => chart.zoom(zoomed(2), chart.yRange),
    Escape: () => chart.zoom(null, null),
  };
  const action = actions[event.key];
  if (action === undefined) return;
  event.preventDefault();
  action();
}
