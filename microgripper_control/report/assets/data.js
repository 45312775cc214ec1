"use strict";
// The page's data, and what went wrong on it: the list is empty on a page that works.

window.reportErrors = [];
window.addEventListener("error", (event) => window.reportErrors.push(String(event.message)));

/** Values of `packed` (decimation.py): 16 bits each, perhaps of their logarithm. */
function unpack(packed) {
  const text = atob(packed.base64);
  const values = new Float64Array(text.length / 2);
  for (let i = 0; i < values.length; i++) {
    const level = text.charCodeAt(2 * i) + 256 * text.charCodeAt(2 * i + 1);
    const value = packed.low + level * packed.step;
    values[i] = packed.log ? 10 ** value : value;
  }
  return values;
}

/** An axis of values: packed, or evenly spaced. */
function unpackAxis(axis) {
  if (axis.base64 !== undefined) return unpack(axis);
  return Float64Array.from({ length: axis.count }, (_, i) => axis.start + i * axis.step);
}

/** An element, HTML or with `svg:` before its name SVG; text only ever goes in as text. */
function make(name, attributes = {}, ...children) {
  const svg = name.startsWith("svg:");
  const made = svg
    ? document.createElementNS("http://www.w3.org/2000/svg", name.slice(4))
    : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}
