"""Statuses of a verdict: the one order, word, symbol, colour and exit code of each, for every place that shows one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import StrEnum
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar

# Style in a terminal of each colour; on a page the colour is a CSS class, whose values `tokens.css` holds
COLOURS: Mapping[str, str] = {"good": "bold green", "watch": "bold yellow", "bad": "bold red", "open": "bold cyan"}


class Status(StrEnum):
    """State of a monitored element, or the reason why it could not be judged; its value is the word that is shown.

    The order of definition is that of the codes in blocks, generated C and CAN frames; that of severity is `SEVERITY`.
    """

    HEALTHY = "healthy"
    RISING = "rising"
    SUSPECT = "suspect"
    FAULT = "fault"
    NOT_READY = "not ready"
    NOT_ENABLED = "not enabled"
    NOT_TESTABLE = "not testable"
    NOT_IDENTIFIABLE = "not identifiable"
    NOT_AVAILABLE = "not available"
    ESTIMATED = "estimated"
    CONSISTENT = "consistent"
    INCONSISTENT = "inconsistent"

    @property
    def exit_code(self) -> int:
        """Exit code: 0 where nothing was found, 1 fault (rising, suspect, inconsistent included), 2 no judgement."""
        return _LOOKS[self].exit_code

    @property
    def symbol(self) -> str:
        """Character that is shown before the word, which carries the meaning of the colour without colour."""
        return _LOOKS[self].symbol

    @property
    def capitals(self) -> str:
        """Symbol and word as in a terminal, where the word begins a line in capitals."""
        return f"{self.symbol} {self.value.upper()}"

    @property
    def colour(self) -> str:
        """Colour class: good, watch, bad or open."""
        return _LOOKS[self].colour

    @property
    def style(self) -> str:
        """Style of the word in a terminal."""
        return COLOURS[self.colour]

    @property
    def meaning(self) -> str:
        """Explanation for a reader, in one sentence."""
        return _LOOKS[self].meaning

    @property
    def quiet(self) -> bool:
        """Whether the monitor had its say and found nothing."""
        return self.exit_code == 0

    @property
    def alarm(self) -> bool:
        """Whether the monitor found something: a fault, or a doubt."""
        return self.exit_code == 1

    @property
    def judged(self) -> bool:
        """Whether this is a verdict, not the reason for the lack of one."""
        return self.exit_code != 2

    @property
    def doubted(self) -> Status:
        """Status of the same statement where something contradicts it: that of an estimate is inconsistent."""
        return Status.INCONSISTENT if self.estimate else Status.SUSPECT

    @property
    def estimate(self) -> bool:
        """Whether it is that of a monitor that only estimates, and judges no part of the car."""
        return self in (Status.ESTIMATED, Status.CONSISTENT, Status.INCONSISTENT)

    def document(self) -> dict[str, str]:
        """Word, symbol and colour, for JSON."""
        return {"status": self.value, "symbol": self.symbol, "colour": self.colour}


class _Looks(NamedTuple):
    symbol: str
    colour: str
    exit_code: int
    meaning: str


_LOOKS: Mapping[Status, _Looks] = {
    Status.FAULT: _Looks(
        "✕",
        "bad",
        1,
        "A fault was found: its statistic passed a threshold that fault-free driving hardly ever reaches.",
    ),
    Status.RISING: _Looks(
        "▲", "watch", 1, "The quantity has risen above its baseline, and is not yet beyond the limit of a fault."
    ),
    Status.SUSPECT: _Looks("▲", "watch", 1, "Something differs from what is expected, and its cause is not known."),
    Status.INCONSISTENT: _Looks("▲", "watch", 1, "An estimate that a reference or a redundant signal contradicts."),
    Status.NOT_AVAILABLE: _Looks("?", "open", 2, "No monitor ran: a signal or a parameter is missing."),
    Status.NOT_IDENTIFIABLE: _Looks(
        "?", "open", 2, "The drive did not excite what is to be estimated, so that no value can be given."
    ),
    Status.NOT_TESTABLE: _Looks(
        "?", "open", 2, "The signals that this verdict needs were not good enough in this drive."
    ),
    Status.NOT_ENABLED: _Looks(
        "?", "open", 2, "The conditions under which the monitor can judge never held in this drive."
    ),
    Status.NOT_READY: _Looks(
        "?", "open", 2, "Too little was driven for a verdict; the result is kept, and the next drive continues from it."
    ),
    Status.ESTIMATED: _Looks("≈", "open", 0, "An estimate that nothing in the recording confirms or contradicts."),
    Status.CONSISTENT: _Looks("✓", "good", 0, "An estimate with which a reference or a redundant signal agrees."),
    Status.HEALTHY: _Looks(
        "✓", "good", 0, "Everything that this monitor judges is fault-free, with enough driving for a verdict."
    ),
}

# All statuses, the worst first; what prevents a verdict ranks before an estimate and before healthy
SEVERITY: tuple[Status, ...] = tuple(_LOOKS)


def worst(statuses: Iterable[Status]) -> Status:
    """The worst of some statuses, independent of their order; "not available" where there are none."""
    return min(statuses, key=SEVERITY.index, default=Status.NOT_AVAILABLE)


# All statuses; the code of a status is its index here, the same for all monitors
STATUSES: tuple[Status, ...] = tuple(Status)


def code_of(status: Status) -> float:
    """The code of a status inside a block."""
    return float(STATUSES.index(status))


class Statement(NamedTuple):
    """Statement of a monitor about one sensor, actuator or quantity at one sample."""

    status: Annotated[Scalar, ""]  # code in `STATUSES`
    # time from the start of the run at which the evidence for the status began; negative where it holds throughout or
    # is not known
    since: Annotated[Scalar, "s"]
    # number of the kind of fault in the monitor's catalogue of kinds; 0 where there is none, or it is not identifiable
    kind: Annotated[Scalar, ""]
    # fault magnitude, or the estimate itself where the monitor estimates one quantity, in the unit that the monitor
    # declares for the kind; 0 where there is none, since no block may hold a NaN constant
    magnitude: Annotated[Scalar, ""]
    deviation: Annotated[Scalar, ""]  # standard deviation of the magnitude, in its unit; 0 where there is none
    evidence: Annotated[Scalar, ""]  # decision statistic relative to its threshold: the decision falls at 1
