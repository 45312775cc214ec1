"use strict";
// Axes: from values to pixels and back, ticks, numbers.

const MINUS = "\u2212";

/** A scale from [low, high] to [from, to] pixels. */
class Scale {
  constructor(low, high, from, to, log) {
    Object.assign(this, { low, high, from, to, log });
    this.a = log ? Math.log10(low) : low;
    this.b = log ? Math.log10(high) : high;
  }

  pixel(value) {
    const v = this.log ? Math.log10(value) : value;
    return this.from + ((v - this.a) / (this.b - this.a)) * (this.to - this.from);
  }

  value(pixel) {
    const v = this.a + ((pixel - this.from) / (this.to - this.from)) * (this.b - this.a);
    return this.log ? 10 ** v : v;
  }

  /** Round values, about `distance` pixels apart. */
  ticks(distance) {
    const room = Math.max(2, Math.abs(this.to - this.from) / distance);
    return this.log && this.b - this.a > 0.8 ? this.decades(room) : this.steps(room);
  }

  steps(room) {
    const rough = (this.high - this.low) / room;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
    const found = [];
    for (let k = Math.ceil(this.low / step); k * step <= this.high * (1 + 1e-9); k++) {
      found.push(Number((k * step).toPrecision(12)));
    }
    return found;
  }

  decades(room) {
    const decades = this.b - this.a;
    const every = Math.max(1, Math.ceil(decades / room));
    const factors = decades * 3 <= room ? [1, 2, 5] : [1];
    const found = [];
    for (let power = Math.ceil(this.a / every) * every - every; power <= this.b; power += every) {
      for (const factor of factors) {
        const value = Number((factor * 10 ** power).toPrecision(12));
        if (value >= this.low && value <= this.high) found.push(value);
      }
    }
    return found;
  }
}

/** A number as people write it: so many significant digits, no trailing zeros, a true minus. */
function formatted(value, digits = 4) {
  if (!Number.isFinite(value)) return "\u2013";
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e5 || size < 1e-3)) {
    const [mantissa, power] = value.toExponential(digits - 1).split("e");
    const short = Number(mantissa);
    const exponent = [...String(Number(power))].map((c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻").join("");
    return `${short === 1 ? "" : `${short}·`}10${exponent}`.replace("-", MINUS);
  }
  return String(Number(value.toPrecision(digits))).replace("-", MINUS);
}
