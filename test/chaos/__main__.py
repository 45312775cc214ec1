"""`python test/chaos [--small] [--seed N] [--keep FILE.md]`: prints the table; 1 if one failed."""

from __future__ import annotations

import argparse
import os
import platform
import signal
import sys
import tempfile
import time
from pathlib import Path

from run import FULL, SMALL, run
from table import Row, markdown

BEGIN, END = "<!-- chaos: begin -->", "<!-- chaos: end -->"


def main() -> int:
    """Run everything."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--small", action="store_true", help="in half a minute")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="document whose table is replaced")
    given = parser.parse_args()
    keep = given.keep.resolve() if given.keep else None
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # ends the children, too
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        rows = run(Path(folder), SMALL if given.small else FULL, given.seed, print)
    text = _report(rows, given.seed, time.monotonic() - begin)
    print(text)
    if keep is not None:
        _keep(keep, text)
    return int(not all(row.passed for row in rows))


def _report(rows: list[Row], seed: int, took: float) -> str:
    faults = sum(row.injected for row in rows)
    lines = [
        f"{faults} faults, {sum(row.survived for row in rows)} survived, in {took:.0f} s; "
        f"seed {seed}, Python {platform.python_version()}, {os.cpu_count()} cores.",
        "",
        markdown(rows),
        "",
        *(f"- {row.fault}: {'; '.join(row.remarks)}" for row in rows if row.remarks),
        *(f"- NOT SURVIVED, {row.fault}: {note}" for row in rows for note in row.notes),
    ]
    return "\n".join(lines)


def _keep(document: Path, text: str) -> None:
    before = document.read_text(encoding="utf-8")
    head, _, rest = before.partition(BEGIN)
    _, _, tail = rest.partition(END)
    document.write_text(f"{head}{BEGIN}\n{text}\n{END}{tail}", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
