"""Findings: the verdict of a monitor with its reason, never a bare flag."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from tierod.core.shown import Screen, in_words
from tierod.core.statuses import Status as Status
from tierod.core.statuses import worst

# Least time from the onset of a change to its declaration that a text names [s]; most faults take some 0.1 s
LEAST_DELAY = 0.5


def belated(onset: float | None, declared: float | None) -> float | None:
    """Time of a declaration that came noticeably later than the onset; None where it did not [s].

    Args:
        onset: time of the onset [s]; None where there was none
        declared: time of the declaration [s]; None where it is not known
    """
    if onset is None or declared is None or declared - onset < LEAST_DELAY:
        return None
    return declared


@dataclass(frozen=True)
class Estimate:
    """An estimated number with its uncertainty."""

    quantity: str  # its name in words, with the place ("friction torque at the steering wheel axis")
    value: float  # estimated value in the unit
    standard_deviation: float  # one sigma in the unit
    unit: str  # in the notation of pint; "count" where the recording was not calibrated
    # values that it is compared with, by name: nominal, learnt level, threshold
    reference: dict[str, float] = field(default_factory=dict)
    # names of vehicle parameters that are the limits of the alarm; their deviation is in none of the others
    limits: tuple[str, ...] = ()
    # standard deviations [unit] that are assumptions on the sensors, by the name of the parameter that replaces
    # each assumption; they are part of `standard_deviation`
    assumed: dict[str, float] = field(default_factory=dict)
    given: dict[str, float] = field(default_factory=dict)  # the same of sensors whose parameter the vehicle file states
    # standard deviations [unit] by parameters of the vehicle, whose spread the monitor itself includes in
    # `standard_deviation`
    held: dict[str, float] = field(default_factory=dict)
    # value from which it is a fault [unit], where the reference of that name lies above it by the margin of the
    # alarm; None where it is that reference
    fault_from: float | None = None

    @property
    def by_sensors(self) -> dict[str, float]:
        """Standard deviations by the sensors [unit], assumed or given; all drives of a car share these errors."""
        return self.assumed | self.given


@dataclass(frozen=True)
class Finding:
    """The verdict of one monitor over one recording."""

    monitor: str  # name of the monitor and its variant
    # what was found, or why no judgement was possible. A monitor that only estimates is never healthy or suspect:
    # consistent where a reference or redundant signals could have contradicted it, inconsistent where they do, else
    # estimated
    status: Status
    headline: str  # subject, status and reason in at most 12 words, for the first line of a report
    # time [s] in the recording at which the change to this status began; None where it holds throughout
    since: float | None = None
    estimate: Estimate | None = None  # the estimated quantity; None where nothing could be estimated
    # named figures (enabled seconds, enabled share, excitation, NIS, ...), with unit in the name
    evidence: dict[str, float] = field(default_factory=dict)
    cause: str = ""  # reason for the status
    action: str = ""  # the remedy
    # notices for a reader of the verdict (wrong sign suspected, torque in raw counts, ...)
    warnings: tuple[str, ...] = ()
    decided_by: tuple[str, ...] = ()  # names of the decision rules that raised the alarm; empty without an alarm
    # time [s] at which the change was declared; None where there was none, or its time is not known
    declared: float | None = None
    # time [s] at which all faults of the finding had ended; None where one lasts to the end of the recording, or
    # the time is not known
    end: float | None = None
    # further sentences: limits that the estimate was compared with, or the verdict without what doubts it
    details: tuple[str, ...] = ()

    @property
    def belated(self) -> float | None:
        """Time of the declaration where it differs noticeably from the onset; None where it does not [s]."""
        return belated(self.since, self.declared)

    def screen(self) -> Screen:
        """Display of the finding in a terminal or a notebook."""
        estimate = self.estimate
        lines = (
            self.headline,
            *self.details,
            "" if self.since is None else f"since {self.since:.6g} s",
            "" if self.end is None else f"ended at {self.end:.6g} s",
            "" if self.belated is None else f"declared at {self.belated:.6g} s",
            ""
            if estimate is None
            else f"{estimate.quantity}: {in_words(estimate.value, estimate.unit, 4)} "
            f"(± {in_words(estimate.standard_deviation, estimate.unit, 2)})",
            f"cause: {self.cause}" if self.cause else "",
            f"what to do: {self.action}" if self.action else "",
            *(f"warning: {warning}" for warning in self.warnings[:3]),
        )
        return Screen(f"Finding of {self.monitor}: {self.status}", lines)

    def __repr__(self) -> str:
        return self.screen().text()

    def _repr_html_(self) -> str:
        return self.screen().html()


@dataclass(frozen=True)
class Episode:
    """Time interval in which a sensor or an actuator was faulty."""

    kind: str  # type of the fault in words ("total loss", "positive offset"); empty where it is not identifiable
    start: float  # likeliest onset of the fault in the recording [s]
    end: float | None = None  # likeliest end of the fault [s]; None where it lasts to the end of the recording
    magnitude: Estimate | None = None  # fault magnitude; None where the fault has none, or it is not identifiable
    # other elements whose fault explains the readings as well; empty where there are none
    candidates: tuple[str, ...] = ()
    # time of the declaration [s], when the evidence was sure; a slow or hidden fault begins long before, and may
    # have ended by then
    declared: float | None = None

    @property
    def declared_at(self) -> float:
        """Time of the declaration, or the onset where it is not known [s]."""
        return self.start if self.declared is None else self.declared

    @property
    def belated(self) -> float | None:
        """Time of the declaration where it differs noticeably from the onset; None where it does not [s]."""
        return belated(self.start, self.declared)


@dataclass(frozen=True)
class Element:
    """The state of one sensor or actuator over a recording."""

    name: str  # name of the signal or actuator
    role: str  # "sensor" or "actuator"
    status: Status  # fault or suspect where it has an episode, else healthy, or why it could not be judged
    cause: str = ""  # why it could not be judged, or was judged for a part of the time only
    episodes: tuple[Episode, ...] = ()  # intervals in which it was faulty, in chronological order
    # its replacement while it is faulty, with the measured error of that; empty where there is none
    substitute: str = ""
    trouble_code: str = ""  # diagnostic trouble code; empty where there is none
    # smallest lasting offset of a fault-free sensor, or lost share of an actuator's torque, that would have been
    # seen [unit]; None where none is stated
    smallest: float | None = None
    unit: str = ""  # unit of `smallest`


@dataclass(frozen=True)
class Trace:
    """A decimated time series for the report: minimum, maximum and mean of every bin, so that no peak is lost."""

    # name and unit of a signal of the catalogue, or of an output of the monitor
    name: str
    unit: str
    time: Any  # left edge of each bin [s], shape (n,)
    # shape (n,) each; NaN where no sample fell into the bin
    lower: Any
    upper: Any
    mean: Any


@dataclass(frozen=True)
class ChannelQuality:
    """Data quality of one channel; rate from the median sampling interval [Hz], longest gap [s], extremes [unit]."""

    name: str
    unit: str
    source: str
    samples: int
    rate: float
    missing_share: float
    longest_gap: float
    minimum: float
    maximum: float
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Curve:
    """Trade-off in the design of a stopping rule, for a chart."""

    # values on the horizontal and on the vertical axis, (n,) each
    along: tuple[float, ...]
    up: tuple[float, ...]
    # titles of the axes, with unit
    along_title: str
    up_title: str
    chosen: tuple[float, float] | None = None  # the point of the design in use; None where it is off the curve
    # whether `up` is a probability from 0 to 1 over a magnitude; else both are times, on logarithmic axes
    chance: bool = False


@dataclass(frozen=True)
class Decided:
    """One decision rule of a monitor, as a report shows it."""

    # in words
    name: str
    distance: str
    rule: str
    false_alarms: str
    source: str
    statistic: str = ""  # name of the trace that is compared with the thresholds; "" where there is none
    levels: tuple[float, ...] = ()  # thresholds, in the unit of that trace or of the value of a single test
    curve: Curve | None = None  # trade-off of its design; None without one
    below: bool = False  # whether the rule acts below its thresholds; else above positive and below negative ones
    # furthest value over the recording, or the value of a single test; None where neither is known
    reached: float | None = None
    # time [s] of the first crossing of a threshold; None where none was crossed, or for a single test
    passed: float | None = None


@dataclass(frozen=True)
class ParameterEffect:
    """Effect of an uncertain vehicle parameter on a result."""

    name: str  # name of the parameter
    # as used for the result
    value: float
    standard_deviation: float
    unit: str
    effect: float  # change of the result for one standard deviation of the parameter, with sign
    effect_unit: str  # in the notation of pint; "" for a distance from a threshold, relative to the threshold
    share: float  # share of the variance that all parameters add to the result [0 to 1]


@dataclass(frozen=True)
class Diagnosis:
    """Complete result of one run of monitors over one recording; report and JSON are made from it alone."""

    findings: tuple[Finding, ...]  # one per monitor
    elements: tuple[Element, ...] = ()  # states of sensors and actuators, from monitors that judge several
    traces: dict[str, Trace] = field(default_factory=dict)  # time series by name
    histograms: dict[str, Any] = field(default_factory=dict)  # by name, (edges, counts) pairs per stretch of the drive
    # hysteresis views: name -> (angle [rad], torque) pairs, decimated
    loops: dict[str, Any] = field(default_factory=dict)
    consistency: dict[str, float] = field(default_factory=dict)  # NIS and NEES figures by name
    # hints for parts of the report, by name ("consistency"); outcome for the files of "baseline" and "fault
    # memory", where they were named
    remarks: dict[str, str] = field(default_factory=dict)
    quality: tuple[ChannelQuality, ...] = ()  # one per channel used
    # rows (name, value, unit, standard deviation, source)
    parameters: tuple[tuple[str, float, str, float | None, str], ...] = ()
    decisions: tuple[Decided, ...] = ()  # the rules by which the monitors decided
    # effects of the uncertain parameters that change the result, the largest first
    parameter_effects: tuple[ParameterEffect, ...] = ()
    # provenance
    recording: dict[str, Any] = field(default_factory=dict)
    vehicle: dict[str, Any] = field(default_factory=dict)
    version: str = ""
    command: str = ""
    created: str = ""

    @property
    def status(self) -> Status:
        """Worst status of all findings; "not available" where no monitor ran."""
        return worst(each.status for each in self.findings)

    @property
    def decisive(self) -> Finding | None:
        """First finding with the worst status; None where no monitor ran."""
        return next((each for each in self.findings if each.status is self.status), None)

    def screen(self) -> Screen:
        """Display of the diagnosis in a terminal or a notebook."""
        about = f" of {self.recording['path']}" if self.recording.get("path") else ""
        lines = [line for each in self.findings for line in (each.screen().title, *each.screen().lines)]
        rows = [(each.name, each.role, str(each.status), each.cause) for each in self.elements]
        vehicle = f" as {self.vehicle['name']}" if self.vehicle.get("name") else ""
        return Screen(
            f"Diagnosis{about}{vehicle}", tuple(lines), ("sensor or actuator", "role", "status", "cause"), rows
        )

    def __repr__(self) -> str:
        return self.screen().text()

    def _repr_html_(self) -> str:
        return self.screen().html()

    def remarked(self, name: str, remark: str) -> Diagnosis:
        return replace(self, remarks={**self.remarks, name: remark})
