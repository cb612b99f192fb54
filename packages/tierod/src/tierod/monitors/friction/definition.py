"""The friction monitor: its block, its session over a recording, and its variants.

1. `signals`: conditioning of the signals, and the gate that selects samples with information.
2. `estimator`: the regression that gives friction; the filters of the paper are variants in tierod-lab.
3. `verdict`: what that means, sample by sample, by the limits in `thresholds`.
4. `evidence`: what is collected over a drive for the report, and gains of the torques.
5. `facts`: the last statement of the block as a verdict; `sentences` has the words.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from tierod.core.block import Tree
from tierod.core.errors import InputError
from tierod.core.facts import Fact, Verdict, assemble
from tierod.core.findings import Finding, Status
from tierod.core.graph import Result
from tierod.core.statuses import STATUSES, code_of
from tierod.methods.analysis.consistency import ConsistencyAccumulator, nis_figures
from tierod.methods.identification.hysteresis_presence import HysteresisPresence
from tierod.models.steering_column import FrictionParameters
from tierod.monitors.baseline import Baseline
from tierod.monitors.friction.estimator import PreslidingFrictionFilter
from tierod.monitors.friction.evidence import EstimateOverDrive, GainsOverDrive, HysteresisOverDrive, SignalsOverDrive
from tierod.monitors.friction.facts import FrictionRun, verdict_of_run
from tierod.monitors.friction.signals import SAMPLE_TIME
from tierod.monitors.friction.thresholds import STATISTICS, TUNING
from tierod.monitors.friction.verdict import DECISIONS, FrictionVerdict, JudgedFriction, VerdictSample
from tierod.monitors.registry import variants_with_plugins
from tierod.monitors.session import BlockSession, Conclusion, Monitor, Session, Variant, tuning_rows
from tierod.vehicles import Vehicle

NAME = "friction, pre-sliding"  # Name of the default monitor in findings and in stored baselines

VALUES = ("friction_torque", "friction_torque_standard_deviation", "ratio_to_baseline", *STATISTICS)
"""Traces that depend on the value of friction and are hidden where it is withheld."""

WITHHELD = (
    "The value of friction is withheld, so its course, its spread, its hysteresis and its ratio to the baseline are "
    "not shown: the estimate is not valid here. The verdict gives the reason."
)

Acting = Callable[[Mapping[str, np.ndarray], Result], np.ndarray]
"""Function from signals by name and outputs to the acting friction torque at each sample."""


class FrictionEstimator(Protocol):
    """Interface of a block that estimates friction and supplies the input of the verdict."""

    learnt: ClassVar[Mapping[str, str]]  # Evidence of the estimator: name with unit -> field of its output

    @property
    def Sample(self) -> type: ...

    @property
    def vehicle_parameters(self) -> FrictionParameters:
        """Parameters of the vehicle file, as the estimator assumes them."""

    def init(self) -> Tree: ...

    def step(self, state: Tree, sample: Any) -> tuple[Tree, Any]: ...

    def seen(self, sample: Any, estimate: Any) -> VerdictSample:
        """Input of the verdict from a sample and its estimate."""


@dataclass(frozen=True)
class FrictionMonitor:
    """Friction estimator and verdict as one block; every estimator is judged alike."""

    filter: FrictionEstimator
    verdict: FrictionVerdict
    name: str = NAME

    class State(NamedTuple):
        filter: Tree
        verdict: FrictionVerdict.State

    class Output(NamedTuple):
        estimate: Tree
        verdict: JudgedFriction

    @property
    def Sample(self) -> type:
        return self.filter.Sample

    @classmethod
    def of_vehicle(
        cls,
        vehicle: Vehicle,
        sample_time: float = SAMPLE_TIME,
        learnt_level: float | None = None,
        learnt_deviation: float = 0.0,
    ) -> FrictionMonitor:
        """The default monitor for a vehicle, with its level from earlier drives and its standard deviation [N*m]."""
        verdict = FrictionVerdict.of_vehicle(vehicle, sample_time, learnt_level, learnt_deviation)
        return cls(PreslidingFrictionFilter.of_vehicle(vehicle, sample_time), verdict)

    def init(self) -> State:
        return self.State(self.filter.init(), self.verdict.init())

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        filter_state, estimate = self.filter.step(state.filter, sample)
        verdict_state, verdict = self.verdict.step(state.verdict, self.filter.seen(sample, estimate))
        return self.State(filter_state, verdict_state), self.Output(estimate, verdict)

    def finding(self, result: Result, start_time: float = 0.0) -> Finding:
        """The finding of a run, without the facts about its signals; see `stated`."""
        return assemble("Friction", self.stated(result, start_time))

    def stated(self, result: Result, start_time: float = 0.0) -> Verdict:
        """The verdict of a run over a recording whose first sample was at `start_time` [s]."""
        if not len(result):
            raise InputError("the friction monitor saw no samples; check that the signals overlap in time")
        last = result.at(-1)
        evidence = {name: getattr(last.estimate, field) for name, field in self.filter.learnt.items()}
        parameters = self.filter.vehicle_parameters
        return verdict_of_run(FrictionRun(self.name, self.verdict, last.verdict, start_time, evidence, parameters))


class FrictionSession(BlockSession):
    """Run the monitor over a recording and collect the contents of a report.

    Args:
        acting: function that computes the acting friction torque, for the hysteresis view
        consistency_remark: remark on the innovations of an estimator whose variance is deliberately set wide, to which
            the band of a consistent filter does not apply
    """

    def __init__(
        self,
        block: FrictionMonitor,
        vehicle: Vehicle,
        rate: float,
        acting: Acting,
        consistency_remark: str = "",
    ):
        unit = vehicle.torque_unit
        traces = {
            "estimate.friction_torque": (VALUES[0], unit),
            "verdict.statement.deviation": (VALUES[1], unit),
            "estimate.enabled": ("enabled", ""),
            "estimate.nis": ("nis", ""),
            "verdict.ratio": (VALUES[2], ""),
            "verdict.statement.evidence": (STATISTICS[0], ""),
            "verdict.fault_sum": (STATISTICS[1], ""),
        }
        super().__init__(block, traces, ("verdict.running", STATUSES))
        self._monitor, self.vehicle, self._acting = block, vehicle, acting
        self._consistency_remark = consistency_remark
        self._estimates, self._hysteresis = EstimateOverDrive(rate), HysteresisOverDrive(rate)
        self._signals, self._gains = SignalsOverDrive(), GainsOverDrive(vehicle, rate)
        self._consistency = ConsistencyAccumulator()
        self._start: float | None = None
        self._last: Result | None = None

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        self._start = float(time[0]) if self._start is None else self._start
        self._last = result.end()
        if not self.moved:
            self._signals.add(time, signals)
            self._gains.add(signals)
        if not self.pictured:
            return
        enabled = result["estimate.enabled"] > 0.5
        judged = result["verdict.running"] <= code_of(Status.FAULT)
        self._estimates.add(time, result["estimate.friction_torque"], judged)
        self._hysteresis.add(time, signals["steering_wheel_angle"], self._acting(signals, result), enabled)
        present = result["estimate.present"] if "estimate.present" in result.names else np.ones(len(result))
        self._consistency.add(result["estimate.nis"][enabled], present[enabled])

    def conclude(self) -> Conclusion:
        if self._last is None or self._start is None:
            raise RuntimeError("a session concludes after at least one piece")
        verdict = self._monitor.stated(self._last, self._start)
        known = verdict.estimate is not None
        if not known and not self.moved:
            verdict = _with_presence(verdict, self._signals.presence())
        facts = (*self._gains.defects(), *verdict.facts, *self._gains.notes())
        verdict = dataclasses.replace(verdict, facts=facts)
        remarks = {"consistency": self._consistency_remark, "estimate": "" if known else WITHHELD}
        return Conclusion(
            verdict,
            self._estimates.histograms(verdict.since) if known else {},
            self._hysteresis.views(verdict.since) if known else {},
            nis_figures(self._consistency.result(), wide=bool(self._consistency_remark)),
            tuple(tuning_rows(self.block)),
            self._level() if verdict.status is Status.HEALTHY else None,
            self._level() if verdict.estimate is not None and verdict.estimate.limits else None,
            {part: remark for part, remark in remarks.items() if remark},
            () if known else VALUES,
            tuple(self.course),
        )

    def _level(self) -> Baseline | None:
        """Level of this car that the recording gives; None if it was not learnt."""
        assert self._last is not None
        judged = self._last.at(-1).verdict
        if judged.known_level <= 0.0:
            return None
        own, unit = judged.baseline, self.vehicle.torque_unit
        return Baseline(self.vehicle.name, self._monitor.name, own.level, own.deviation, unit, own.seconds)


def _with_presence(verdict: Verdict, found: HysteresisPresence | None) -> Verdict:
    """Verdict with the result of the hysteresis test, for a friction whose magnitude is withheld."""
    if found is None:
        return verdict
    what = "is present, but its size cannot be estimated" if found.present else "does not stand out from chance"
    sentence = (
        f"hysteresis of dry friction {what}: the torques explain {found.share:.0%} of the part of its build-up that "
        f"angle, rate and lateral acceleration do not explain, and up to {found.chance:.0%} of it for copies shifted "
        "in time"
    )
    figures = {"hysteresis_share": found.share, "hysteresis_by_chance_share": found.chance}
    because = (*verdict.because, Fact("hysteresis", sentence))
    return dataclasses.replace(verdict, because=because, evidence={**verdict.evidence, **figures})


def acting_by_build_up(signals: Mapping[str, np.ndarray], result: Result) -> np.ndarray:
    """Acting friction: the friction modelled by the pre-sliding estimator plus the residual of the balance."""
    modelled = result["estimate.friction_torque"] * result["estimate.build_up"]
    acting: np.ndarray = modelled + result["estimate.innovation"]
    return acting


PAPER = "Mohtat et al., Steering friction monitoring by joint state-parameter estimation"

Opener = Callable[[Vehicle, float, Baseline | None], Session]

_WIDE = (
    "This estimator allows for errors of its torque balance that last half a second, and so expects a large variance: "
    "a mean NIS far below 1 is normal. A NIS near or above 1 means that the balance does not fit the car."
)


def _presliding(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
    block = FrictionMonitor.of_vehicle(vehicle, 1.0 / rate, *learnt(baseline))
    return FrictionSession(block, vehicle, rate, acting_by_build_up, _WIDE)


def learnt(baseline: Baseline | None) -> tuple[float | None, float]:
    """Level and standard deviation of the baseline from earlier recordings [N*m]."""
    return (baseline.value, baseline.deviation) if baseline else (None, 0.0)


PRE_SLIDING = Variant(
    "pre-sliding",
    "Regression that also learns the angle over which friction builds up, so that pre-sliding causes no bias.",
    f"beyond {PAPER}; docs/explanation/friction.md",
    _presliding,
    DECISIONS,
)

FRICTION = Monitor(
    name="friction",
    title="Friction of the steering",
    subject="Friction",
    summary="Detects and quantifies rising dry friction of column, gear and rack in natural driving.",
    source=PAPER,
    drive=f"Bends to both sides, steered by hand on city or country roads: {TUNING.ready_time:g} s in which driver and "
    "motor turn the wheel together, some three minutes of mixed driving; a baseline needs some six minutes.",
    required=(
        "steering_wheel_angle",
        "steering_wheel_rate",
        "driver_torque",
        "motor_torque",
        "yaw_rate",
        "lateral_acceleration",
        "vehicle_speed",
    ),
    optional=(),
    rate=100.0,
    minimum_rate=20.0,
    lane_rate=25.0,
    maximum_age=0.1,
    variants=variants_with_plugins("friction", {"pre-sliding": "tierod.monitors.friction.definition:PRE_SLIDING"}),
    default="pre-sliding",
    learns=True,
    # After a step of friction the torque balance does not fit for up to 57 s (verdict_tuning).
    reaction=60.0,
)
