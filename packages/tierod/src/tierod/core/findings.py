"""Findings: the verdict of a monitor with its reason, never a bare flag."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from tierod.core.screen import Screen
from tierod.core.shown import in_words
from tierod.core.statuses import Status as Status
from tierod.core.statuses import worst

LEAST_DELAY = 0.5
"""Least time from the onset of a change to its declaration that a text names [s]; most faults take some 0.1 s."""


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
    """An estimated number with its uncertainty.

    Args:
        quantity: its name in words, with the place ("friction torque at the steering wheel axis")
        value: estimated value in the unit
        standard_deviation: one sigma in the unit
        unit: in the notation of pint; "count" where the recording was not calibrated
        reference: values that it is compared with, by name: nominal, learnt level, threshold
        limits: names of vehicle parameters that are the limits of the alarm; their deviation is in none of the others
        assumed: standard deviations [unit] that are assumptions on the sensors, by the name of the parameter that
            replaces each assumption; they are part of `standard_deviation`
        given: the same of sensors whose parameter the vehicle file states
        held: standard deviations [unit] by parameters of the vehicle, whose spread the monitor itself includes in
            `standard_deviation`
        fault_from: value from which it is a fault [unit], where the reference of that name lies above it by the margin
            of the alarm; None where it is that reference
    """

    quantity: str
    value: float
    standard_deviation: float
    unit: str
    reference: dict[str, float] = field(default_factory=dict)
    limits: tuple[str, ...] = ()
    assumed: dict[str, float] = field(default_factory=dict)
    given: dict[str, float] = field(default_factory=dict)
    held: dict[str, float] = field(default_factory=dict)
    fault_from: float | None = None

    @property
    def by_sensors(self) -> dict[str, float]:
        """Standard deviations by the sensors [unit], assumed or given; all drives of a car share these errors."""
        return self.assumed | self.given


@dataclass(frozen=True)
class Finding:
    """The verdict of one monitor over one recording.

    Args:
        monitor: name of the monitor and its variant
        status: what was found, or why no judgement was possible. A monitor that only estimates is never healthy or
            suspect: consistent where a reference or redundant signals could have contradicted it, inconsistent where
            they do, else estimated
        headline: subject, status and reason in at most 12 words, for the first line of a report
        since: time [s] in the recording at which the change to this status began; None where it holds throughout
        declared: time [s] at which the change was declared; None where there was none, or its time is not known
        end: time [s] at which all faults of the finding had ended; None where one lasts to the end of the recording,
            or the time is not known
        estimate: the estimated quantity; None where nothing could be estimated
        evidence: named figures (enabled seconds, enabled share, excitation, NIS, ...), with unit in the name
        cause: reason for the status
        action: the remedy
        warnings: notices for a reader of the verdict (wrong sign suspected, torque in raw counts, ...)
        decided_by: names of the decision rules that raised the alarm; empty without an alarm
        details: further sentences: limits that the estimate was compared with, or the verdict without what doubts it
    """

    monitor: str
    status: Status
    headline: str
    since: float | None = None
    estimate: Estimate | None = None
    evidence: dict[str, float] = field(default_factory=dict)
    cause: str = ""
    action: str = ""
    warnings: tuple[str, ...] = ()
    decided_by: tuple[str, ...] = ()
    declared: float | None = None
    end: float | None = None
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
    """Time interval in which a sensor or an actuator was faulty.

    Args:
        candidates: other elements whose fault explains the readings as well; empty where there are none
        declared: time of the declaration [s], when the evidence was sure; a slow or hidden fault begins long before,
            and may have ended by then
    """

    kind: str  # type of the fault in words ("total loss", "positive offset"); empty where it is not identifiable
    start: float  # likeliest onset of the fault in the recording [s]
    end: float | None = None  # likeliest end of the fault [s]; None where it lasts to the end of the recording
    magnitude: Estimate | None = None  # fault magnitude; None where the fault has none, or it is not identifiable
    candidates: tuple[str, ...] = ()
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
    """The state of one sensor or actuator over a recording.

    Args:
        substitute: its replacement while it is faulty, with the measured error of that; empty where there is none
        smallest: smallest lasting offset of a fault-free sensor, or lost share of an actuator's torque, that would have
            been seen [unit]; None where none is stated
    """

    name: str  # name of the signal or actuator
    role: str  # "sensor" or "actuator"
    status: Status  # fault or suspect where it has an episode, else healthy, or why it could not be judged
    cause: str = ""  # why it could not be judged, or was judged for a part of the time only
    episodes: tuple[Episode, ...] = ()  # intervals in which it was faulty, in chronological order
    substitute: str = ""
    trouble_code: str = ""  # diagnostic trouble code; empty where there is none
    smallest: float | None = None
    unit: str = ""  # unit of `smallest`


@dataclass(frozen=True)
class Trace:
    """A decimated time series for the report: minimum, maximum and mean of every bin, so that no peak is lost.

    Args:
        name, unit: name and unit of a signal of the catalogue, or of an output of the monitor
        lower, upper, mean: shape (n,) each; NaN where no sample fell into the bin
    """

    name: str
    unit: str
    time: Any  # left edge of each bin [s], shape (n,)
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
    """Trade-off in the design of a stopping rule, for a chart.

    Args:
        along, up: values on the horizontal and on the vertical axis, (n,) each
        along_title, up_title: titles of the axes, with unit
        chance: whether `up` is a probability from 0 to 1 over a magnitude; else both are times, on logarithmic axes
    """

    along: tuple[float, ...]
    up: tuple[float, ...]
    along_title: str
    up_title: str
    chosen: tuple[float, float] | None = None  # the point of the design in use; None where it is off the curve
    chance: bool = False


@dataclass(frozen=True)
class Decided:
    """One decision rule of a monitor, as a report shows it.

    Args:
        name, distance, rule, false_alarms, source: in words
        reached: furthest value over the recording, or the value of a single test; None where neither is known
        passed: time [s] of the first crossing of a threshold; None where none was crossed, or for a single test
    """

    name: str
    distance: str
    rule: str
    false_alarms: str
    source: str
    statistic: str = ""  # name of the trace that is compared with the thresholds; "" where there is none
    levels: tuple[float, ...] = ()  # thresholds, in the unit of that trace or of the value of a single test
    curve: Curve | None = None  # trade-off of its design; None without one
    below: bool = False  # whether the rule acts below its thresholds; else above positive and below negative ones
    reached: float | None = None
    passed: float | None = None


@dataclass(frozen=True)
class ParameterEffect:
    """Effect of an uncertain vehicle parameter on a result.

    Args:
        value, standard_deviation, unit: as used for the result
    """

    name: str  # name of the parameter
    value: float
    standard_deviation: float
    unit: str
    effect: float  # change of the result for one standard deviation of the parameter, with sign
    effect_unit: str  # in the notation of pint; "" for a distance from a threshold, relative to the threshold
    share: float  # share of the variance that all parameters add to the result [0 to 1]


@dataclass(frozen=True)
class Diagnosis:
    """Complete result of one run of monitors over one recording; report and JSON are made from it alone.

    Args:
        findings: one per monitor
        elements: states of sensors and actuators, from monitors that judge several
        traces: time series by name
        histograms: by name, (edges, counts) pairs per stretch of the drive
        loops: hysteresis views: name -> (angle [rad], torque) pairs, decimated
        consistency: NIS and NEES figures by name
        remarks: hints for parts of the report, by name ("consistency"); outcome for the files of "baseline"
            and "fault memory", where they were named
        quality: one per channel used
        parameters: rows (name, value, unit, standard deviation, source)
        decisions: the rules by which the monitors decided
        parameter_effects: effects of the uncertain parameters that change the result, the largest first
        recording, vehicle, version, command, created: provenance
    """

    findings: tuple[Finding, ...]
    elements: tuple[Element, ...] = ()
    traces: dict[str, Trace] = field(default_factory=dict)
    histograms: dict[str, Any] = field(default_factory=dict)
    loops: dict[str, Any] = field(default_factory=dict)
    consistency: dict[str, float] = field(default_factory=dict)
    remarks: dict[str, str] = field(default_factory=dict)
    quality: tuple[ChannelQuality, ...] = ()
    parameters: tuple[tuple[str, float, str, float | None, str], ...] = ()
    decisions: tuple[Decided, ...] = ()
    parameter_effects: tuple[ParameterEffect, ...] = ()
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
        """The diagnosis with a remark added.

        Args:
            name: its subject ("baseline")
            remark: a sentence
        """
        return replace(self, remarks={**self.remarks, name: remark})
