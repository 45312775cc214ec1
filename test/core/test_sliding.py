from __future__ import annotations

import numpy as np

from microgripper_control.core.sliding import Sliding


def test_the_newest_rows_in_order() -> None:
    rows = Sliding(7, 2)
    for count in range(1, 40):
        assert rows.is_full == (count > 7)
        rows.append((count, -count))
        newest = np.arange(max(1, count - 6), count + 1)
        np.testing.assert_array_equal(rows.columns, [newest, -newest])
        assert len(rows) == len(newest)
    rows.clear()
    assert rows.columns.shape == (2, 0)


def test_what_was_handed_out_stays_as_it_is() -> None:
    rows = Sliding(3, 1)
    for value in range(3):
        rows.append((value,))
    (before,) = rows.columns
    for value in range(3, 9):
        rows.append((value,))
    np.testing.assert_array_equal(before, [0.0, 1.0, 2.0])
