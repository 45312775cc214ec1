"""What came of one case: the diagnosis as it was given, and what was found out beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from microgripper_control.examination.plan import Planned

SCHEMA = "microgripper-examination-case/1"


@dataclass(frozen=True)
class Beside:
    """What another method says of the same recordings, judged on the same samples."""

    answer: str | None  # an effect, none or parameters; None: it names nothing
    stage: str | None
    rmse: float | None  # m, held out; None if it failed
    seconds: float
    why: str = ""  # it failed


@dataclass(frozen=True)
class Record:
    """One case done; `outcome` is one of those in asking.py.

    `rivals` holds, for effects that the diagnosis named in place of the cause or beside it, what
    their laws leave beyond the cause's own, over the noise: None if that cannot be told.
    """

    planned: Planned
    outcome: str
    why: str = ""
    seconds: Mapping[str, float] = field(default_factory=dict)  # what took how long
    diagnosis: Mapping[str, Any] | None = None
    beside: Mapping[str, Beside] = field(default_factory=dict)
    rivals: Mapping[str, float | None] = field(default_factory=dict)

    def plain(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "schema": SCHEMA,
            "case": self.planned.plain(),
            "outcome": self.outcome,
            "why": self.why,
            "seconds": dict(self.seconds),
            "diagnosis": self.diagnosis,
            "beside": {name: asdict(one) for name, one in self.beside.items()},
            "rivals": dict(self.rivals),
        }

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> Record:
        """The record that `plain` came from."""
        return cls(
            Planned.of(plain["case"]),
            plain["outcome"],
            plain["why"],
            plain["seconds"],
            plain["diagnosis"],
            {name: Beside(**one) for name, one in plain["beside"].items()},
            plain["rivals"],
        )
