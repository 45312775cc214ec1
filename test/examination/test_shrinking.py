"""Where there is a gap to speak of."""

from __future__ import annotations

import math

import pytest
from hand_made import NOISE, diagnosis, marked

from microgripper_control.examination.equals import AGREE
from microgripper_control.examination.shrinking import closable, errors_of


@pytest.mark.parametrize(("removable", "counts"), [(0.9, False), (1.1, True)])
def test_a_gap_within_the_noise_is_not_to_be_closed(removable: float, counts: bool) -> None:
    refit = math.hypot(NOISE, removable * AGREE * NOISE)  # the oracle leaves the noise
    case = marked(("creep",), diagnosis(("creep",), refit=refit, augmented=NOISE))
    assert bool(errors_of(case).closed) is counts
    assert len(closable([case])) == counts
