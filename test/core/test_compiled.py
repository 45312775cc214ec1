"""Machine code that is called by its address."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from microgripper_control.core.compiled import address_of, cache_folder, call_at, compiled
from microgripper_control.core.signals import Array


def scaled_sum(a: Array, b: Array, factor: float) -> float:
    b[1] = a[0] + b[0]
    return float(factor * b[1])


def difference(a: Array, b: Array, factor: float) -> float:
    return float(factor * (a[0] - b[0]))


@compiled
def call_each(addresses: Array, a: Array, b: Array, results: Array) -> None:
    for i in range(len(addresses)):
        arguments = (a.ctypes.data, b.ctypes.data + 8, 3.0)
        results[i] = call_at(int(addresses[i]), arguments)


def test_one_kernel_calls_whatever_it_is_given() -> None:
    addresses = np.array([address_of(f, arrays=2, numbers=1) for f in (scaled_sum, difference)])
    a, b, results = np.array([5.0]), np.array([0.0, 7.0, 0.0]), np.zeros(2)
    call_each(addresses, a, b, results)
    np.testing.assert_array_equal(results, [36.0, -6.0])
    assert b[2] == 12.0


def test_a_number_holds_an_address() -> None:
    address = address_of(scaled_sum, arrays=2, numbers=1)
    assert float(int(address)) == address
    assert address == address_of(scaled_sum, arrays=2, numbers=1)


def test_division_by_zero_follows_ieee_and_raises_nothing() -> None:
    addresses = np.array([address_of(reciprocal, arrays=2, numbers=1)])
    results = np.zeros(1)
    call_each(addresses, np.zeros(1), np.zeros(3), results)
    assert results[0] == np.inf


def reciprocal(a: Array, b: Array, factor: float) -> float:
    return float(factor / a[0])


def test_the_next_process_finds_the_compiled_code() -> None:
    load = (
        "from microgripper_control.plant.model import nominal_model\n"
        "from microgripper_control.plant.simulate import Plant\n"
        "plant = Plant(nominal_model().with_link('contact'), 1e-3)\n"
        "plant.write(100.0)\n"
        "from microgripper_control.effects.force_balance import kernel\n"
        "print(sum(kernel.stats.cache_misses.values()), sum(kernel.stats.cache_hits.values()))\n"
    )
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", load], capture_output=True, text=True)
    assert done.stdout.split() == ["0", "1"], done.stderr
    assert cache_folder().is_dir()


def test_without_a_home_that_can_be_written_compiled_code_has_a_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken = tmp_path / "a file"
    taken.write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(taken))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert cache_folder().parent.parent == tmp_path
