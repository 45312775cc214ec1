"""Where an examination keeps things: cases and answers apart from the truth.

    DIR/cases/case_017/      what the diagnosing process is given
    DIR/answers/case_017/    what it wrote
    DIR/sealed/              the plan, which code it is of, and the truth of each case
    DIR/results/             what came of each case, one file each

A case with a result is done: an examination that was stopped goes on with the others.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import make_folder, written_whole
from microgripper_control.examination.plan import Planned
from microgripper_control.examination.sources import sources

PLAN_SCHEMA = "microgripper-examination/1"


@dataclass(frozen=True)
class Folder:
    """The folder of one examination."""

    root: Path

    def case(self, planned: Planned) -> Path:
        """The folder that the diagnosing process is given."""
        return self.root / "cases" / planned.name

    def answer(self, planned: Planned) -> Path:
        """The folder it writes."""
        return self.root / "answers" / planned.name

    def seal(self, planned: Planned) -> Path:
        """The file with the truth."""
        return self.root / "sealed" / f"{planned.name}.json"

    def result(self, planned: Planned) -> Path:
        """The file with what came of it; once it is there, the case is done."""
        return self.root / "results" / f"{planned.name}.json"

    def truth(self, planned: Planned) -> dict[str, Any]:
        """Open the seal."""
        return read_json(self.seal(planned))

    @property
    def _plan(self) -> Path:
        return self.root / "sealed" / "plan.json"

    @property
    def code(self) -> str:
        """The hash of the sources that the examination is of."""
        return str(read_json(self._plan).get("code", "unknown"))

    def refuse_other_code(self) -> None:
        """Raise MicrogripperError if the sources are no longer those that the examination is of."""
        if self.code != sources():
            raise MicrogripperError(
                f"--out {self.root}: was begun by other code (sources {self.code}, these are "
                f"{sources()}), whose results must not be mixed; give another folder or go on with "
                "the old version"
            )

    def begin(self, planned: Sequence[Planned]) -> None:
        """Keep the plan and which code it is of, or find that they are those that are kept here.

        MicrogripperError if the folder holds another examination, or one of other code.
        """
        cases = [one.plain() for one in planned]
        if not self._plan.exists():
            make_folder(self._plan.parent)
            write_json(self._plan, {"schema": PLAN_SCHEMA, "code": sources(), "cases": cases})
            return
        if read_json(self._plan).get("cases") != cases:
            raise MicrogripperError(
                f"--out {self.root}: holds another examination (another --seed or --quick); "
                "give another folder or remove this one"
            )
        self.refuse_other_code()


def read_json(path: Path) -> dict[str, Any]:
    """The object in a file; MicrogripperError names a file that holds none."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise MicrogripperError(f"{path}: cannot be read: {error}; remove it") from None
    if not isinstance(content, dict):
        raise MicrogripperError(f"{path}: holds no JSON object; remove it")
    return content


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write an object; the file appears whole or not at all."""
    with written_whole(path) as file:
        json.dump(content, file, indent=1, allow_nan=False)
        file.write("\n")
