"""Session of a monitor, which runs over recordings of any length."""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Annotated, Any, NamedTuple, Protocol, get_args, get_origin, get_type_hints

import numpy as np

from tierod.core.block import Block, tuning
from tierod.core.errors import ParameterError
from tierod.core.findings import Defect, Element, Finding, Status
from tierod.core.graph import Memory, Result, Scanner, trace
from tierod.core.graph.trace import Interface
from tierod.core.recording import Aligned, Recording
from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.decision import Decision
from tierod.vehicles import Vehicle


class StatusChange(NamedTuple):
    """Change of a running verdict: its time and the new status."""

    time: Annotated[float, "s"]
    status: Status


@dataclass(frozen=True)
class Conclusion:
    """Conclusion of a session at the end of a recording.

    Args:
        finding: the verdict
        histograms: name -> (edges, counts)
        loops: name -> (angle [rad], torque)
        consistency: figures of the innovations by name
        parameters: rows (name, value, unit, standard deviation, source) of the monitor's own tuning
        baseline: learnt parameters of this vehicle that may be kept as its fault-free state; None where there are none
        remarks: hints for parts of the report: "estimate" or "consistency" -> a sentence or two
        withheld: traces that a report must not show, since their value was withheld
        course: the running verdict from change to change; empty for a monitor that judges a recording as a whole
        code_courses: the same for single trouble codes by name, of a monitor that distinguishes several faults
        elements: state of every sensor and actuator, of a monitor that judges several
        defects: of its input signals, over the whole drive
        distances: by the name of a decision that looks once at a recording, its statistic
    """

    finding: Finding
    histograms: Mapping[str, Any] = field(default_factory=dict)
    loops: Mapping[str, Any] = field(default_factory=dict)
    consistency: Mapping[str, float] = field(default_factory=dict)
    parameters: tuple[tuple[str, float, str, float | None, str], ...] = ()
    baseline: Baseline | None = None
    remarks: Mapping[str, str] = field(default_factory=dict)
    withheld: tuple[str, ...] = ()
    course: tuple[StatusChange, ...] = ()
    code_courses: Mapping[str, tuple[StatusChange, ...]] = field(default_factory=dict)
    elements: tuple[Element, ...] = ()
    defects: tuple[Defect, ...] = ()
    distances: Mapping[str, float] = field(default_factory=dict)


class Session(Protocol):
    """One monitor over one recording, fed piece by piece."""

    signals: tuple[str, ...]
    """Canonical signals, in the order in which it wants them."""

    traces: Mapping[str, str]
    """What a report shows over time beside the signals: name -> unit."""

    def refuse(self, aligned: Aligned) -> None:
        """Refuse a recording that it cannot judge, from its first piece; called before the first `absorb`.

        Raises:
            InputError: signals come too slowly together, or one that only this vehicle or variant needs is missing
        """

    def absorb(self, aligned: Aligned) -> Mapping[str, np.ndarray]:
        """Take in one more piece and give the traces over it, (n,) each."""

    def conclude(self) -> Conclusion:
        """The verdict over all pieces."""


class BlockSession(ABC):
    """A session whose monitor is a block: the block runs over each piece and is carried on to the next.

    Args:
        block: its sample is a flat NamedTuple of canonical signals
        traces: outputs shown over time: output -> (name in the report, unit)
        running: output that holds the code of the running verdict, and the status of each code; None without one
    """

    def __init__(
        self,
        block: Block,
        traces: Mapping[str, tuple[str, str]],
        running: tuple[str, Sequence[Status]] | None = None,
    ):
        self.block = block
        self.course: list[StatusChange] = []
        self.signals = trace(block).sample
        self.traces: Mapping[str, str] = dict(traces.values())
        self._outputs = {name: output for output, (name, _) in traces.items()}
        self._running = running
        self.fitted: object = None
        """To what of a recording its block was fitted; None where it follows from the vehicle alone."""
        self.pictured = True
        """Whether the conclusion holds what only a report shows: histograms, loops and figures of the innovations."""
        self.moved = False
        """Whether it runs for a vehicle within the spread of another one, whose own session names defective signals."""
        self.memory: Memory | None = None
        """The state of the block after the last piece, to be stored or to go on from; None before the first."""
        self._scanner: Scanner[Any, Any, Any] | None = None

    @property
    def running(self) -> tuple[str, Sequence[Status]] | None:
        """Output that holds the code of the running verdict, and the status of each code; None without one."""
        return self._running

    @property
    def shown_outputs(self) -> Mapping[str, str]:
        """Output of the block by the name under which a report shows it."""
        return self._outputs

    @property
    def stepped(self) -> Interface | None:
        """Graph of its block where all that it does with a piece is to step that; None before the first piece."""
        ordinary = type(self).absorb is BlockSession.absorb
        return self._scanner.graph if ordinary and self._scanner is not None else None

    def refit(self, fitted: Any) -> None:  # noqa: B027  # the blocks of most follow from the vehicle alone
        """Fit the block as an earlier session did, of which `fitted` is kept."""

    def refuse(self, aligned: Aligned) -> None:  # noqa: B027  # most blocks judge whatever has their signals
        """Refuse a recording that it cannot judge, from its first piece."""

    def absorb(self, aligned: Aligned) -> Mapping[str, np.ndarray]:
        """Take in one more piece and give the traces over it, (n,) each."""
        ready = self.prepared(aligned)
        if self._scanner is None or self._scanner.block is not self.block:
            self._scanner = Scanner(self.block)
        return self.taken(ready, self._scanner.scan(ready, self.memory))

    def prepared(self, aligned: Aligned) -> Aligned:
        """The next piece as the block takes it in; a block that is fitted to a recording is fitted to the first one."""
        return aligned

    def taken(self, aligned: Aligned, result: Result) -> Mapping[str, np.ndarray]:
        """Keep what the block gave over a piece, and give the traces over it, (n,) each."""
        self.memory = result.state
        if self._running is not None:
            self._follow(aligned.time, result[self._running[0]], self._running[1])
        self.collect(aligned.time, aligned.columns, result)
        return {name: result[output] for name, output in self._outputs.items()}

    def _follow(self, time: np.ndarray, code: np.ndarray, statuses: Sequence[Status]) -> None:
        changed = np.flatnonzero(np.diff(code, prepend=np.nan) != 0.0)
        for at in changed.tolist():
            status = statuses[round(code[at])]
            if not self.course or self.course[-1].status is not status:
                self.course.append(StatusChange(float(time[at]), status))

    def observe(self, traces: Mapping[str, np.ndarray]) -> None:  # noqa: B027  # most need no more than their own band
        """The traces of the last piece as they are shown: their bands hold the spread of the parameters."""

    @abstractmethod
    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Keep the part of one piece that the conclusion needs: time [s], signals by name, outputs, (n,) each."""

    @abstractmethod
    def conclude(self) -> Conclusion:
        """The verdict over all pieces."""


def tuning_rows(block: Block) -> list[tuple[str, float, str, float | None, str]]:
    """Every float of a monitor's own tuning: rows (name, value, unit, deviation, source); not those of its vehicle.

    Args:
        block: of a monitor
    """
    rows: list[tuple[str, float, str, float | None, str]] = []
    for path, value in tuning(block):
        if ".parameters." not in f".{path}" and not path.startswith("verdict.limits.") and math.isfinite(value):
            rows.append((path, value, _unit_of(block, path), None, f"tuning of {type(block).__name__}"))
    return rows


def _unit_of(block: Any, path: str) -> str:
    """The unit of a float field, from the annotation of its dataclass or NamedTuple."""
    *way, name = path.split(".")
    holder = block
    for step in way:
        holder = holder[int(step)] if step.isdigit() else getattr(holder, step)
    if not (dataclasses.is_dataclass(holder) or hasattr(holder, "_fields")):
        return ""
    kind: Any = type(holder)
    return _units(kind).get(name, "")


@cache
def _units(kind: Any) -> Mapping[str, str]:
    """The units of the annotated fields of a class; to read annotations takes longer than to judge a minute."""
    hints = get_type_hints(kind, include_extras=True).items()
    return {name: str(get_args(hint)[1]) for name, hint in hints if get_origin(hint) is Annotated}


@dataclass(frozen=True)
class Variant:
    """One way of doing a monitor's job.

    Args:
        name: as given on the command line
        summary: one sentence
        source: paper and equations
        open: builds the session for a vehicle, a rate [Hz], and the vehicle's baseline from earlier recordings
        decisions: every way in which its sessions turn a number into a statement; at the monitor's own rate their rules
            are those in effect
        required: canonical signals without which it cannot run; those of the monitor where None
    """

    name: str
    summary: str
    source: str
    open: Callable[[Vehicle, float, Baseline | None], Session]
    decisions: tuple[Decision, ...] = ()
    required: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Monitor:
    """One thing that tierod watches.

    Args:
        name: as given on the command line
        title: for people
        summary: one sentence
        source: paper
        required: canonical signals without which it cannot run
        optional: signals that make it better
        rests_on: those of them on which the result rests where they are there: a defect of one makes it suspect
        rate: of the grid it runs on [Hz]
        minimum_rate: slowest channel that it accepts [Hz]
        maximum_age: a sample older than this is missing [s]
        variants: by name
        default: the variant taken where none is given; None where a wrong guess would give a wrong verdict, so that the
            user must choose
        slower: rates for recordings whose required channels come slower than `rate` [Hz], the fastest first; empty
            where held values do no harm
        subjects: signals whose faults it judges itself, so that it must see them stuck as well
        reaction: time that it needs to find a fault [s]; where required signals are lost for longer at the end of a
            recording, that is not healthy
        condition: requirement that no channel shows, as a half-sentence after "if"; "" where any will do
        learns: whether it learns a baseline of the vehicle, which later recordings are judged against
    """

    name: str
    title: str
    summary: str
    source: str
    required: tuple[str, ...]
    optional: tuple[str, ...]
    rate: float
    minimum_rate: float
    maximum_age: float
    variants: Mapping[str, Variant]
    default: str | None
    condition: str = ""
    slower: tuple[float, ...] = ()
    learns: bool = False
    rests_on: tuple[str, ...] = ()
    subjects: tuple[str, ...] = ()
    reaction: Annotated[float, "s"] = 10.0

    def needing(self, variant: Variant) -> Monitor:
        """The monitor with the needs of one of its variants."""
        return self if variant.required is None else replace(self, required=variant.required)

    def variant_for(self, recording: Recording) -> Variant | None:
        """The default where the recording fits it, else the first variant that it fits, or None.

        Args:
            recording: the whole, or the first piece of it, with its derived signals
        """
        if self.default is None:
            return None
        ordered = (self.variants[self.default], *self.variants.values())
        return next((each for each in ordered if all(name in recording for name in self.needing(each).required)), None)

    def suited_to(self, recording: Recording) -> Monitor:
        """The monitor on the grid that suits a recording: as fast as its slowest required channel, within 5 %.

        Args:
            recording: the whole, or the first piece of it
        """
        channels = [recording[name].time for name in self.required if name in recording]
        rates = [(len(time) - 1) / (time[-1] - time[0]) for time in channels if len(time) > 1 and time[-1] > time[0]]
        slowest = min(rates, default=self.rate)
        fitting = [rate for rate in (self.rate, *self.slower) if rate <= 1.05 * slowest]
        return replace(self, rate=fitting[0] if fitting else (self.rate, *self.slower)[-1])


def opened(monitor: Monitor, variant: Variant, vehicle: Vehicle, baseline: Baseline | None = None) -> Session:
    """The session of a variant for a vehicle.

    Args:
        monitor: on the grid of the recording
        variant: of the monitor
        vehicle: that is judged
        baseline: baseline of earlier drives; None where there is none

    Raises:
        ParameterError: the variant cannot run with this vehicle
    """
    try:
        session = variant.open(vehicle, monitor.rate, baseline)
    except ParameterError as error:
        raise ParameterError(f"the monitor '{monitor.name}' cannot run as '{variant.name}': {error}") from None
    if lacking := [
        name for name in ("signals", "traces", "refuse", "absorb", "conclude") if not hasattr(session, name)
    ]:
        raise ParameterError(
            f"the session of the monitor '{monitor.name}', variant '{variant.name}', lacks {', '.join(lacking)}; "
            "derive it from tierod.BlockSession"
        )
    return session
