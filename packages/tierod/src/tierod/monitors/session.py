"""Monitor, variant and session: what a monitor is, and how it runs over a recording of any length."""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import chain
from typing import (
    Annotated,
    Any,
    NamedTuple,
    Protocol,
    TypeAlias,
    get_args,
    get_origin,
    get_type_hints,
    runtime_checkable,
)

import numpy as np

from tierod.core.block import Block, tuning
from tierod.core.errors import ParameterError
from tierod.core.facts import Verdict
from tierod.core.findings import Element, Status
from tierod.core.graph import Memory, Result, Scanner, trace
from tierod.core.graph.trace import Interface
from tierod.core.recording import Aligned, Recording
from tierod.core.statuses import STATUSES
from tierod.monitors.baseline import Baseline
from tierod.monitors.decision import Decision
from tierod.monitors.stuck import Stuck
from tierod.vehicles import Vehicle

STATED = "statement.status"  # Output of a block that holds the status of its estimate

Table: TypeAlias = Mapping[str, float | str | Mapping[str, float]]  # Table of thresholds in a vehicle file


class StatusChange(NamedTuple):
    """Change of a running verdict: its time and the new status."""

    time: Annotated[float, "s"]
    status: Status


@dataclass(frozen=True)
class Conclusion:
    """Conclusion of a session at the end of a recording."""

    verdict: Verdict  # the verdict, with the facts that the session has found
    histograms: Mapping[str, Any] = field(default_factory=dict)  # name -> (edges, counts)
    loops: Mapping[str, Any] = field(default_factory=dict)  # name -> (angle [rad], torque)
    consistency: Mapping[str, float] = field(default_factory=dict)  # statistics of the innovations by name
    # rows (name, value, unit, standard deviation, source) of the monitor's own tuning
    parameters: tuple[tuple[str, float, str, float | None, str], ...] = ()
    # estimates that may be stored as the fault-free baseline of this vehicle; None without any
    baseline: Baseline | None = None
    # the same of a verdict that depends on guesses; stored only where the user knows the vehicle fault-free
    unproven: Baseline | None = None
    # notes on parts of the report: "estimate" or "consistency" -> a sentence or two
    remarks: Mapping[str, str] = field(default_factory=dict)
    withheld: tuple[str, ...] = ()  # names of traces that a report must not show, since their value was withheld
    # changes of the running verdict; empty for a monitor that judges a recording as a whole
    course: tuple[StatusChange, ...] = ()
    # changes of the verdict on single trouble codes by name, of a monitor that isolates several faults
    code_courses: Mapping[str, tuple[StatusChange, ...]] = field(default_factory=dict)
    elements: tuple[Element, ...] = ()  # state of every sensor and actuator, of a monitor that judges several
    # statistic of each decision that tests a recording once, by name of the decision
    distances: Mapping[str, float] = field(default_factory=dict)
    # variance by the vehicle's parameters that the estimate's deviation already has [unit squared]: that at the sample
    # of the estimate; None lets the spread of the parameters add it
    parameter_variance: float | None = None


class Session(Protocol):
    """One monitor over one recording, fed piece by piece."""

    signals: tuple[str, ...]  # Canonical names of its input signals, in the order of the columns it expects

    traces: Mapping[str, str]  # Outputs that a report shows over time beside the input signals: name -> unit

    def refuse(self, aligned: Aligned) -> None:
        """Refuse a recording that the session cannot judge; called with its first piece, before `absorb`.

        Raises:
            InputError: signals come too slowly together, or a signal is missing that this vehicle or variant needs
        """

    def absorb(self, aligned: Aligned) -> Mapping[str, np.ndarray]:
        """Process one more piece and return its traces, (n,) each."""

    def conclude(self) -> Conclusion:
        """Conclusion over all pieces."""


@runtime_checkable
class SubjectsSession(Protocol):
    """Session that judges sensors itself, and learns before its conclusion when their signals were stuck."""

    stuck: tuple[Stuck, ...]  # Spans in which signals were stuck, in the order of time


class BlockSession(ABC):
    """Session whose monitor is a block: the block runs over each piece and keeps its state for the next.

    Args:
        block: block whose sample is a flat NamedTuple of canonical signals
        traces: outputs to be shown over time: output -> (name in the report, unit)
        running: output with the code of the running verdict, and the status of each code; None takes that of the
            block's statement, where it has one
    """

    own: tuple[str, ...] = ()  # Traces that it needs itself

    def __init__(
        self,
        block: Block,
        traces: Mapping[str, tuple[str, str]],
        running: tuple[str, Sequence[Status]] | None = None,
    ):
        self.block = block
        self.course: list[StatusChange] = []
        graph = trace(block)
        self.signals = graph.sample
        self.traces: Mapping[str, str] = dict(traces.values())
        self._outputs = {name: output for output, (name, _) in traces.items()}
        self._running = running or ((STATED, STATUSES) if STATED in graph.output else None)
        self.fitted: object = None
        """Data of the recording that the block was fitted to; None if the block follows from the vehicle alone."""
        self.pictured = True
        """Whether the conclusion includes what only a report shows: histograms, loops, statistics of innovations."""
        self.moved = False
        """Whether it runs for perturbed parameters; defective signals are then named by the session of the vehicle."""
        self.memory: Memory | None = None
        """State of the block after the last piece, for the next piece; None before the first."""
        self._scanner: Scanner[Any, Any, Any] | None = None

    @property
    def stepped(self) -> Interface | None:
        """Graph of the block if `absorb` only steps it; None for an own `absorb`, and before the first piece."""
        ordinary = type(self).absorb is BlockSession.absorb
        return self._scanner.graph if ordinary and self._scanner is not None else None

    def beside(self, names: Collection[str]) -> None:
        """Run for perturbed parameters, beside the session of the vehicle, and return the named traces alone."""
        self.moved, self.pictured = True, False
        if type(self).absorb is BlockSession.absorb:
            kept = {*names, *self.own}
            self._outputs = {name: each for name, each in self._outputs.items() if name in kept}

    def refit(self, fitted: Any) -> None:  # noqa: B027  # the blocks of most follow from the vehicle alone
        """Fit the block to the data that an earlier session stored in `fitted`."""

    def refuse(self, aligned: Aligned) -> None:  # noqa: B027  # most blocks judge whatever has their signals
        """Refuse a recording that the session cannot judge, from its first piece."""

    def absorb(self, aligned: Aligned) -> Mapping[str, np.ndarray]:
        ready = self.prepared(aligned)
        if self._scanner is None or self._scanner.block is not self.block:
            self._scanner = Scanner(self.block)
        return self.taken(ready, self._scanner.scan(ready, self.memory))

    def prepared(self, aligned: Aligned) -> Aligned:
        """Next piece in the form that the block needs; a block that is fitted to a recording is fitted here, once."""
        return aligned

    def taken(self, aligned: Aligned, result: Result) -> Mapping[str, np.ndarray]:
        """Store the result of the block over a piece and return its traces, (n,) each."""
        self.memory = result.state
        if self._running is not None and not self.moved:
            self._follow(aligned.time, result[self._running[0]], self._running[1])
        self.collect(aligned.time, aligned.columns, result)
        return {name: result[output] for name, output in self._outputs.items()}

    def _follow(self, time: np.ndarray, code: np.ndarray, statuses: Sequence[Status]) -> None:
        # NaN marks the first sample as a change, since it may continue or end the status of the previous piece.
        changed = np.flatnonzero(np.diff(code, prepend=np.nan) != 0.0)
        for at in changed.tolist():
            status = statuses[round(code[at])]
            if not self.course or self.course[-1].status is not status:
                self.course.append(StatusChange(float(time[at]), status))

    def observe(self, traces: Mapping[str, np.ndarray]) -> None:  # noqa: B027  # most need no more than their own band
        """Receive the traces of the last piece as shown, with bands that include the spread of the parameters."""

    @abstractmethod
    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Store what the conclusion needs of one piece: time [s], signals by name and outputs, (n,) each."""

    @abstractmethod
    def conclude(self) -> Conclusion:
        """Conclusion over all pieces."""


def tuning_rows(block: Block) -> list[tuple[str, float, str, float | None, str]]:
    """Floats of a monitor's own tuning, without the parameters of the vehicle.

    Returns:
        rows (name, value, unit, standard deviation, source)
    """
    rows: list[tuple[str, float, str, float | None, str]] = []
    for path, value in tuning(block):
        if ".parameters." not in f".{path}" and not path.startswith("verdict.limits.") and math.isfinite(value):
            rows.append((path, value, _unit_of(block, path), None, f"tuning of {type(block).__name__}"))
    return rows


def _unit_of(block: Any, path: str) -> str:
    """Unit of a float field, from the annotation of its dataclass or NamedTuple."""
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
    """Units of the annotated fields of a class; cached, since reading annotations is slower than judging a minute."""
    hints = get_type_hints(kind, include_extras=True).items()
    return {name: str(get_args(hint)[1]) for name, hint in hints if get_origin(hint) is Annotated}


@dataclass(frozen=True)
class Variant:
    """One method by which a monitor can work."""

    name: str  # name as given on the command line
    summary: str  # summary in one sentence
    source: str  # paper and equations
    # function that opens the session for a vehicle, a rate [Hz], and a baseline from earlier recordings
    open: Callable[[Vehicle, float, Baseline | None], Session]
    # all decision rules of its sessions, with the numbers in effect at the monitor's own rate
    decisions: tuple[Decision, ...] = ()
    # canonical signals without which it cannot run; None takes those of the monitor
    required: tuple[str, ...] | None = None
    # calibration from fault-free drives: (vehicle, drives to fit, drives for limits, source) -> tables of thresholds
    # for the vehicle file by name; empty where a signal is missing. None without one
    calibrate: Callable[[Vehicle, Sequence[Recording], Sequence[Recording], str], Mapping[str, Table]] | None = None


@dataclass(frozen=True)
class Monitor:
    """Monitor of one element or property of the vehicle."""

    name: str  # name as given on the command line
    title: str  # title in reports
    summary: str  # summary in one sentence
    source: str  # paper
    required: tuple[str, ...]  # canonical signals without which it cannot run
    optional: tuple[str, ...]  # signals that improve its result
    rate: float  # rate of the grid it runs on [Hz]
    minimum_rate: float  # lowest sampling rate of a required channel that it accepts [Hz]
    maximum_age: float  # age from which a sample counts as missing [s]
    variants: Mapping[str, Variant]  # variants by name
    # name of the variant that runs if none is given; None if the user must choose, since a wrong guess would give a
    # wrong verdict
    default: str | None
    # requirement on the recording that no channel shows, as a half-sentence after "if"; "" without one
    condition: str = ""
    drive: str = ""  # manoeuvres and driving time that a verdict needs, as sentences
    # rates for recordings whose required channels come slower than `rate` [Hz], the fastest first; empty if held values
    # do no harm
    slower: tuple[float, ...] = ()
    learns: bool = False  # whether it learns a baseline of the vehicle, with which later recordings are compared
    estimates: bool = False  # whether it only estimates, so that what contradicts it makes it inconsistent, not suspect
    # optional signals that its result rests on if they are present; a defect of one makes it suspect
    rests_on: tuple[str, ...] = ()
    # signals whose faults it judges itself, so that stuck values must not be removed from them
    subjects: tuple[str, ...] = ()
    # time that it needs to find a fault [s]; if required signals are lost for longer at the end of a recording, the
    # verdict is not healthy
    reaction: Annotated[float, "s"] = 10.0
    # rate at which this monitor for other parameters is compared with it [Hz]; None takes the last of `slower`, or
    # `rate`
    lane_rate: Annotated[float, "Hz"] | None = None
    subject: str = ""  # what it judges in a word or two, as the beginning of a headline; "" takes the title

    def needing(self, variant: Variant) -> Monitor:
        """Monitor with the required signals of one of its variants."""
        return self if variant.required is None else replace(self, required=variant.required)

    def variant_for(self, recording: Recording) -> Variant | None:
        """First variant whose required signals the recording has, loading no other where the default fits; else None.

        Args:
            recording: whole recording, or its first piece, with all derived signals

        Returns:
            the variant; None also for a monitor without a default
        """
        if self.default is None:
            return None
        all_ = (self.variants[each] for each in chain((self.default,), self.variants))
        return next((each for each in all_ if all(name in recording for name in self.needing(each).required)), None)

    def suited_to(self, recording: Recording) -> Monitor:
        """Monitor at the highest rate that the slowest required channel of a recording reaches, within 5 %."""
        channels = [recording[name].time for name in self.required if name in recording]
        rates = [(len(time) - 1) / (time[-1] - time[0]) for time in channels if len(time) > 1 and time[-1] > time[0]]
        slowest = min(rates, default=self.rate)
        fitting = [rate for rate in (self.rate, *self.slower) if rate <= 1.05 * slowest]
        return replace(self, rate=fitting[0] if fitting else (self.rate, *self.slower)[-1])


def opened(monitor: Monitor, variant: Variant, vehicle: Vehicle, baseline: Baseline | None = None) -> Session:
    """Open the session of a variant for a vehicle.

    Args:
        baseline: baseline from earlier recordings; None without one

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
