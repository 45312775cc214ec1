"""White noise beside something smooth, told by differences."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.recordings.white_noise import BLOCK, noise_by_differences


@pytest.mark.parametrize("order", [3, 5])
@pytest.mark.parametrize("count", [1, BLOCK + 7])
def test_the_noise_of_each_window_is_found_beside_a_smooth_course(order: int, count: int) -> None:
    smooth = 1e3 * np.sin(np.linspace(0.0, 1.0, 400))
    size = np.linspace(0.5, 2.0, count)
    noise = np.random.default_rng(1).standard_normal((count, 400))
    found = noise_by_differences(smooth + size[:, None] * noise, order)
    assert found == pytest.approx(size, rel=0.4)
    assert np.mean(found / size) == pytest.approx(1.0, abs=0.1)
