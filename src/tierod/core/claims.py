"""Claims: a published or own statement, the measured figure, the goal, and whether it holds."""

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
    """The values that a measured figure should have, ends included.

    Args:
        low, high: ends, in the unit of the figure; infinite where open
    """

    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        if not self.low <= self.high or self.low == -self.high == -math.inf:
            raise ParameterError(
                f"a goal from {self.low} to {self.high} is none; give a lower end, a higher one, or both"
            )

    def holds(self, value: float) -> bool:
        """Whether a finite value lies within."""
        return self.low <= value <= self.high

    def __str__(self) -> str:
        if self.low == self.high:
            return f"= {self.low:g}"
        if self.low == -math.inf:
            return f"<= {self.high:g}"
        return f">= {self.low:g}" if self.high == math.inf else f"{self.low:g} to {self.high:g}"

    @classmethod
    def read(cls, text: str) -> Goal:
        """The goal that a text of this class writes: "<= 0.3", ">= 0.999", "= 0" or "1.5 to 2.2".

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
        raise ParameterError(f"'{text}' is no goal; write '<= 0.3', '>= 0.999', '= 0' or '1.5 to 2.2'")


def at_most(value: float) -> Goal:
    """This or less."""
    return Goal(high=value)


def at_least(value: float) -> Goal:
    """This or more."""
    return Goal(low=value)


def between(low: float, high: float) -> Goal:
    """Goal between two values."""
    return Goal(low, high)


def exactly(value: float) -> Goal:
    """This and nothing else: for counted figures."""
    return Goal(value, value)


class Outcome(StrEnum):
    """What became of a claim."""

    HOLDS = "holds"
    FAILS = "does not hold"
    IRREPRODUCIBLE = "does not come out"
    UNMEASURED = "not measured"


@dataclass(frozen=True)
class Claim:
    """One claim beside its measurement; whether it is met follows from figure and goal and is stored nowhere.

    Args:
        id: words joined by hyphens, after the name of a group and a point: "paper.separation"
        claim: one sentence
        source: who claims it, and where
        printed: the figure there, a number in the unit or words where it is a range; None where none is given
        measured: our figure in the unit; None where it cannot be measured here, NaN where that was tried in vain
        goal: range of the figure that meets the claim; None for a descriptive figure
        unit: of all three, in the notation of pint
        note: remark for reading the figure
        derived: figure by the equations of the source, which prints none, in the unit; None where
            nothing was derived
        cause: what keeps the figure from its goal, and what would mend that; it counts where the claim does not hold
        irreproducible: whether that cause lies in the source: its figure contradicts its own equations, or rests on
            numbers or data that it does not print; the cause is then the evidence
    """

    id: str
    claim: str
    source: str
    printed: float | str | None
    measured: float | None
    goal: Goal | None
    unit: str = ""
    note: str = ""
    derived: float | None = None
    cause: str = ""
    irreproducible: bool = False

    def __post_init__(self) -> None:
        if self.irreproducible and not self.cause:
            raise ParameterError(f"'{self.id}' is called irreproducible without a cause; say what shows it")
        if not re.fullmatch(r"[a-z0-9-]+\.[a-z0-9.-]+", self.id):
            raise ParameterError(f"'{self.id}' is no name of a claim; write group.words-joined-by-hyphens")

    @property
    def group(self) -> str:
        """First part of the name."""
        return self.id.partition(".")[0]

    @property
    def describes(self) -> bool:
        """Whether it only describes: nothing is claimed, so that nothing can fail."""
        return self.goal is None

    @property
    def figure(self) -> float | None:
        """Measured figure; None where it is not finite."""
        return None if self.measured is None or not math.isfinite(self.measured) else float(self.measured)

    @property
    def met(self) -> bool | None:
        """Whether the figure is as the goal wants it; None without goal or measurement, False where that failed."""
        if self.goal is None or self.measured is None:
            return None
        return self.figure is not None and self.goal.holds(self.figure)

    @property
    def outcome(self) -> Outcome | None:
        """What became of the claim; None of a figure of description."""
        if self.describes:
            return None
        if self.met is None:
            return Outcome.UNMEASURED
        if self.met:
            return Outcome.HOLDS
        return Outcome.IRREPRODUCIBLE if self.irreproducible else Outcome.FAILS

    def row(self) -> dict[str, Any]:
        """The claim as it stands in claims.json."""
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
    """How many claims there are, and what became of them, in a line; figures of description are counted last."""
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
    """The text of claims.json.

    Raises:
        ParameterError: two claims of one name
    """
    names = [claim.id for claim in claims]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ParameterError(f"two claims are named '{twice[0]}'; every claim needs a name of its own")
    return json.dumps([claim.row() for claim in claims], ensure_ascii=False, indent=1, allow_nan=False) + "\n"
