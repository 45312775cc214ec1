"""Numbers as people read them: few significant digits, in the unit that suits their size."""

from __future__ import annotations

import math

PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
PREFIXED = ("m", "s", "Hz", "V", "N", "N/m", "V/s")  # units that take a prefix
NOT_ABOVE_ONE = ("s", "V", "V/s")  # nobody says kiloseconds,
NOT_BELOW_ONE = ("Hz", "V/s")  # or millihertz
SAME = 6  # digits in which the ends of a range differ, or it has none


def number(value: float, digits: int = 2) -> str:
    """A number rounded to so many significant digits, without an exponent."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    exponent = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    places = digits - 1 - exponent
    return f"{round(value, places):.{max(0, places)}f}"


def power_of(unit: str, size: float) -> int:
    """The power of ten, a key of PREFIXES, in which a size in a prefixed unit reads best."""
    power = 3 * math.floor(math.log10(abs(size) * (1.0 + 1e-7)) / 3.0)
    lowest = 0 if unit in NOT_BELOW_ONE else min(PREFIXES)
    highest = 0 if unit in NOT_ABOVE_ONE else max(PREFIXES)
    return min(max(power, lowest), highest)


def quantity(value: float, unit: str, digits: int = 2) -> str:
    """A value with its unit, in the prefix in which it reads best: 8.5e-08 m is `85 nm`."""
    factor, name = _prefixed(unit, float(f"{value:.{digits - 1}e}"))
    return f"{number(value / factor, digits)} {name}".rstrip()


def span(low: float, high: float, unit: str, digits: int = 2) -> str:
    """A range, its ends in one unit, with as many digits as tell them apart: `12 to 19 µm`."""
    if math.isinf(high):
        return f"above {quantity(low, unit, digits)}"
    if math.isinf(low):
        return f"below {quantity(high, unit, digits)}"
    if number(low, SAME) == number(high, SAME):
        return f"about {quantity(low, unit, digits)}"
    factor, name = _prefixed(unit, max(abs(low), abs(high)))
    while number(low, digits) == number(high, digits):
        digits += 1
    return f"{number(low / factor, digits)} to {number(high / factor, digits)} {name}".rstrip()


def _prefixed(unit: str, size: float) -> tuple[float, str]:
    """The unit in which a size reads best: what one of it is in the unit given, and its name."""
    if unit == "1":  # of what has no dimension: it would read as a number
        return 1.0, ""
    if unit not in PREFIXED or size == 0.0 or not math.isfinite(size):
        return 1.0, unit
    power = power_of(unit, size)
    return 10.0**power, f"{PREFIXES[power]}{unit}"


def percent(share: float, digits: int = 2) -> str:
    """A share of one as a percentage."""
    return f"{number(100.0 * share, digits)} %"
