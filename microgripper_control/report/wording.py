"""How the diagnosis speaks: names, quantities with their units, ranges."""

from __future__ import annotations

import math
import re

from microgripper_control.core.quantities import PREFIXED, PREFIXES, power_of
from microgripper_control.diagnosis.findings import EFFECTS, NONE, PARAMETERS, UNKNOWN

MINUS, TIMES, ABSENT = "\u2212", "\u00d7", "\u2013"
RAISED = str.maketrans("-0123456789n", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹ⁿ")
EXPONENT = re.compile(r"\^\(?([-\dn]+)\)?")
TOGETHER = re.compile(r"(?<=\d) (?=(?:%|[pnµmk]?(?:m|s|V|Hz)\b))|(?<=\d,) (?=[\d.]+\])")

VERDICTS = {
    NONE: "no gap",
    PARAMETERS: "parameters",
    EFFECTS: "unmodelled effects",
    UNKNOWN: "unknown cause",
}

ANSWERS = {
    NONE: "none: the model is right as given",
    PARAMETERS: "parameters: only mistuned",
    UNKNOWN: "unknown: something not in the library",
}


def plain(name: str) -> str:
    """An effect's or parameter's canonical name as words."""
    return name.replace("_", " ")


def listed(names: tuple[str, ...], last: str = "and") -> str:
    """Several names in a sentence: a, b and c."""
    words = [plain(name) for name in names]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} {last} {words[-1]}"


def number(value: float, digits: int = 3) -> str:
    """A number with so many significant digits, and a true minus sign."""
    if not math.isfinite(value):
        return f"{MINUS if value < 0.0 else ''}∞" if math.isinf(value) else ABSENT
    if value == 0.0:
        return "0"
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    exponent = int(power)
    if not -4 <= exponent < 6:
        return f"{mantissa} {TIMES} 10{str(exponent).translate(RAISED)}".replace("-", MINUS)
    rounded = float(f"{mantissa}e{power}")
    text = f"{rounded:,.{max(0, digits - 1 - exponent)}f}"
    separator = "\u202f" if abs(rounded) >= 1e4 else ""
    return text.replace(",", separator).replace("-", MINUS)


def scaled(unit: str, size: float) -> tuple[float, str]:
    """The factor to, and the name of, the unit in which a number of this size reads best."""
    if unit == "1":
        return 1.0, ""
    if unit not in PREFIXED or size == 0.0 or not math.isfinite(size):
        return 1.0, written(unit)
    power = power_of(unit, size)
    return 10.0**-power, PREFIXES[power] + unit


def written(unit: str) -> str:
    """A unit as people write it: N/m^2 as N/m²."""
    return EXPONENT.sub(lambda found: found[1].translate(RAISED), unit.replace("*", "·"))


def unbroken(text: str) -> str:
    """The text with numbers kept on one line with their units, and intervals in one piece."""
    return TOGETHER.sub("\u00a0", text)


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """A value with its unit, in the prefix in which it reads best."""
    factor, name = scaled(unit, value)
    return f"{number(factor * value, digits)}\u00a0{name}".rstrip()


def span(low: float, high: float, unit: str, digits: int = 3) -> str:
    """A range, both ends in one unit, as many digits as tell them apart; open ends say so."""
    ends = [end for end in (low, high) if math.isfinite(end)]
    factor, name = scaled(unit, max(map(abs, ends), default=0.0))
    if math.isinf(low) and math.isinf(high):
        return "not determined"
    if math.isinf(high):
        return f"more than {number(factor * low, digits)}\u00a0{name}".rstrip()
    if math.isinf(low):
        return f"less than {number(factor * high, digits)}\u00a0{name}".rstrip()
    if low == high:
        return f"about {number(factor * low, digits)}\u00a0{name}".rstrip()
    while low < high and number(factor * low, digits) == number(factor * high, digits):
        digits += 1
    both = f"{number(factor * low, digits)} to {number(factor * high, digits)}"
    return f"{both}\u00a0{name}".rstrip()


def nanometres(value: float | None) -> str:
    """An error, nm, as the tables show it."""
    if value is None or not math.isfinite(value):
        return ABSENT
    nm = 1e9 * value
    return f"{nm:.1f}" if nm < 99.95 else number(nm, max(3, 1 + math.floor(math.log10(nm))))


def percent(share: float, digits: int = 0) -> str:
    """A share of one as a percentage; what is not quite nothing or all says so."""
    value = 100.0 * share
    if not math.isfinite(value):
        return ABSENT
    if 0.0 < value < 0.5 and digits == 0:
        return "< 1\u00a0%"
    if 99.5 <= value < 100.0 and digits == 0:
        return "> 99\u00a0%"
    shown = round(value, digits) + 0.0  # no minus before nothing
    return f"{shown:.{digits}f}\u00a0%".replace("-", MINUS)
