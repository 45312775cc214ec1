"""A line that gives back what went in a while ago, to fractions of a step."""

from __future__ import annotations

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array


@compiled
def march_delay(line: Array, place: Array, delays: Array, signal: Array) -> None:
    """Replace the signal by itself `delays[j]` steps ago, in place.

    `line` is a ring of the last values, longer than any delay; `place[0]` where the next one goes.
    """
    size = len(line)
    write = int(place[0])
    for j in range(len(signal)):
        line[write] = signal[j]
        whole = int(delays[j])
        part = delays[j] - whole
        late = line[(write - whole) % size]
        signal[j] = late + part * (line[(write - whole - 1) % size] - late)
        write = (write + 1) % size
    place[0] = write
