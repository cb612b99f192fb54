"""Claims: a published statement or one of tierod, the measured figure, the goal, and whether the claim holds."""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from tierod.core.errors import ParameterError

_BOUND = re.compile(r"(<=|>=|=)\s*(\S+)")
_RANGE = re.compile(r"(\S+) to (\S+)")


@dataclass(frozen=True)
class Goal:
    """Range in which a measured figure should lie, ends included."""

    # ends, in the unit of the figure; infinite where open
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        if not self.low <= self.high or self.low == -self.high == -math.inf:
            raise ParameterError(
                f"a goal from {self.low} to {self.high} is not a range; give a lower end, a higher one, or both"
            )

    def holds(self, value: float) -> bool:
        """Whether a finite value lies in the range."""
        return self.low <= value <= self.high

    def __str__(self) -> str:
        if self.low == self.high:
            return f"= {self.low:g}"
        if self.low == -math.inf:
            return f"<= {self.high:g}"
        return f">= {self.low:g}" if self.high == math.inf else f"{self.low:g} to {self.high:g}"

    @classmethod
    def read(cls, text: str) -> Goal:
        """The goal that a text describes: "<= 0.3", ">= 0.999", "= 0" or "1.5 to 2.2".

        Raises:
            ParameterError: the text is no goal
        """
        try:
            if found := _BOUND.fullmatch(text):
                sign, value = found[1], float(found[2])
                return {"<=": at_most, ">=": at_least, "=": exactly}[sign](value)
            if found := _RANGE.fullmatch(text):
                return between(float(found[1]), float(found[2]))
        except ValueError:
            pass
        raise ParameterError(f"'{text}' is not a goal; write '<= 0.3', '>= 0.999', '= 0' or '1.5 to 2.2'")


def at_most(value: float) -> Goal:
    return Goal(high=value)


def at_least(value: float) -> Goal:
    return Goal(low=value)


def between(low: float, high: float) -> Goal:
    return Goal(low, high)


def exactly(value: float) -> Goal:
    return Goal(value, value)


class Outcome(StrEnum):
    """Outcome of a claim after the comparison with its measurement."""

    HOLDS = "holds"
    FAILS = "does not hold"
    IRREPRODUCIBLE = "does not come out"
    UNMEASURED = "not measured"


@dataclass(frozen=True)
class Claim:
    """One claim with its measurement; whether it is met is derived from figure and goal and not stored."""

    id: str  # name of a group, a point, and words joined by hyphens: "paper.separation"
    claim: str
    source: str
    # published figure, a number in the unit or words for a range; None where the source gives none
    printed: float | str | None
    # own figure in the unit; None where it cannot be measured here, NaN where the measurement failed
    measured: float | None
    goal: Goal | None  # range of the figure that meets the claim; None for a descriptive figure
    unit: str = ""  # unit of all figures, in the notation of pint
    note: str = ""
    # figure that follows from the equations of the source where it prints none, in the unit; None where nothing was
    # derived
    derived: float | None = None
    # reason why the figure misses its goal, with the remedy; it is used only where the claim does not hold
    cause: str = ""
    # whether that cause lies in the source: its figure contradicts its own equations, or rests on numbers or data
    # that it does not print; the cause is then the evidence
    irreproducible: bool = False

    def __post_init__(self) -> None:
        if self.irreproducible and not self.cause:
            raise ParameterError(f"'{self.id}' is called irreproducible without a cause; give the cause")
        if not re.fullmatch(r"[a-z0-9-]+\.[a-z0-9.-]+", self.id):
            raise ParameterError(f"'{self.id}' is not the name of a claim; write group.words-joined-by-hyphens")

    @property
    def group(self) -> str:
        """Name of the group, the part of `id` before the point."""
        return self.id.partition(".")[0]

    @property
    def describes(self) -> bool:
        """Whether the figure is only descriptive: without a goal nothing can fail."""
        return self.goal is None

    @property
    def figure(self) -> float | None:
        """Measured figure; None where it is not finite."""
        return None if self.measured is None or not math.isfinite(self.measured) else float(self.measured)

    @property
    def met(self) -> bool | None:
        """Whether the figure meets its goal; None without goal or measurement, False where the measurement failed."""
        if self.goal is None or self.measured is None:
            return None
        return self.figure is not None and self.goal.holds(self.figure)

    @property
    def outcome(self) -> Outcome | None:
        """Outcome of the claim; None for a descriptive figure."""
        if self.describes:
            return None
        if self.met is None:
            return Outcome.UNMEASURED
        if self.met:
            return Outcome.HOLDS
        return Outcome.IRREPRODUCIBLE if self.irreproducible else Outcome.FAILS

    def row(self) -> dict[str, Any]:
        """Entry of the claim in claims.json."""
        return {
            "id": self.id,
            "claim": self.claim,
            "source": self.source,
            "printed": self.printed,
            "derived": self.derived,
            "measured": self.figure,
            "goal": None if self.goal is None else str(self.goal),
            "unit": self.unit,
            "met": self.met,
            "outcome": self.outcome,
            "note": self.note,
            "cause": self.cause if self.met is False else "",
        }


def counted(claims: Sequence[Claim]) -> str:
    """One line with the number of claims and of each outcome; descriptive figures are counted last."""
    numbers = Counter(claim.outcome for claim in claims)
    described = numbers.pop(None, 0)
    failed, odd = numbers[Outcome.FAILS], numbers[Outcome.IRREPRODUCIBLE]
    parts = [f"{numbers[Outcome.HOLDS]} hold", f"{failed} do not"]
    if odd:
        parts.append(f"{odd} of the source do not come out")
    parts.append(f"{numbers[Outcome.UNMEASURED]} not measured")
    line = f"{numbers.total()} claims: {', '.join(parts)}"
    return f"{line}; {described} figures of description" if described else line


def claims_document(claims: Sequence[Claim]) -> str:
    names = [claim.id for claim in claims]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ParameterError(f"two claims are named '{twice[0]}'; every claim needs a name of its own")
    return json.dumps([claim.row() for claim in claims], ensure_ascii=False, indent=1, allow_nan=False) + "\n"
