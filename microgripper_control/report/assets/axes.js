"use strict";
// What stands round a figure: grid, ticks, and what the axes show.

function axes(x, y, xAxis, yAxis, width, height) {
  const drawn = [];
  for (const value of x.ticks(width < 480 ? 48 : 90)) {
    const at = x.pixel(value);
    drawn.push(
      make("svg:line", { class: "grid", x1: at, x2: at, y1: y.to, y2: y.from }),
      make("svg:text", { class: "tick", x: at, y: y.from + 14, "text-anchor": "middle" },
        formatted(value)),
    );
  }
  for (const value of y.ticks(44)) {
    const at = y.pixel(value);
    drawn.push(
      make("svg:line", { class: "grid", x1: x.from, x2: x.to, y1: at, y2: at }),
      make("svg:text", { class: "tick", x: x.from - 6, y: at + 4, "text-anchor": "end" },
        formatted(value)),
    );
  }
  drawn.push(
    make("svg:line", { class: "frame", x1: x.from, x2: x.to, y1: y.from, y2: y.from }),
    make("svg:text", { class: "axis", x: x.to, y: height - 4, "text-anchor": "end" },
      named(xAxis)),
    make("svg:text", { class: "axis", x: 2, y: 12 }, named(yAxis)),
  );
  return drawn;
}

/** An axis as people write it: what it shows, and the unit. */
function named({ label, unit }) {
  return unit ? `${label} (${unit})` : label;
}
