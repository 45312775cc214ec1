"""Hostile CSV: a recording or one line that names the file."""

from __future__ import annotations

from pathlib import Path

import pytest
from bags_to_break import recording_or_complaint
from fuzzing import MUTATIONS, NASTY_TEXTS, fuzzed, mutated
from hypothesis import given
from hypothesis import strategies as st

pytestmark = pytest.mark.fuzz

WHOLE = "time_s,voltage_V,displacement_m,setpoint_m\n" + "".join(
    f"{1e-3 * k!r},{k},{1e-9 * k!r},{1e-9 * k!r}\n" for k in range(20)
)
CELLS = (
    st.floats().map(repr)
    | st.integers().map(str)
    | st.sampled_from(["", '"', '""', "'1'", "1,5", "0x1p3", "1_0", "\ufeff", "1e-400"])
    | NASTY_TEXTS
    | st.text(max_size=6)
)  # fmt: skip
NAMES = st.lists(
    st.sampled_from(["time_s", "voltage_V", "displacement_m", "setpoint_m"]) | CELLS, max_size=6
)


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("csv") / "run.csv"


@fuzzed
@given(mutations=MUTATIONS)
def test_a_csv_with_other_bytes(path: Path, mutations: list[tuple[str, int, bytes]]) -> None:
    path.write_bytes(mutated(WHOLE.encode(), mutations))
    recording_or_complaint(path)


@fuzzed
@given(
    names=NAMES,
    rows=st.lists(st.lists(CELLS, max_size=6), max_size=14),
    mark=st.sampled_from([",", ";", "\t", " "]),
    end=st.sampled_from(["\n", "\r\n", "\r"]),
)
def test_a_table_of_anything(
    path: Path, names: list[str], rows: list[list[str]], mark: str, end: str
) -> None:
    text = end.join(mark.join(cells) for cells in [names, *rows])
    path.write_text(text, encoding="utf-8", errors="surrogatepass", newline="")
    recording_or_complaint(path)


@fuzzed
@given(
    columns=st.lists(
        st.tuples(st.floats(), st.floats(), st.floats()), min_size=10, max_size=40
    ),
)  # fmt: skip
def test_a_table_of_numbers(path: Path, columns: list[tuple[float, float, float]]) -> None:
    rows = "".join(",".join(map(repr, row)) + "\n" for row in columns)
    path.write_text("time_s,voltage_V,displacement_m\n" + rows)
    recording_or_complaint(path)
