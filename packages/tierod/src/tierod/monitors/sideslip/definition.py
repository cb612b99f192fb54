"""The sideslip monitor: its block, its session over one recording, and its variants."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Annotated, NamedTuple, Self

import numpy as np

from tierod.core.block import Block, Scalar, Tree, named_tuple
from tierod.core.errors import ParameterError
from tierod.core.facts import Fact, Verdict, defect, weigh
from tierod.core.findings import Status
from tierod.core.graph import Result
from tierod.core.graph.maths import present, where
from tierod.core.recording import Aligned
from tierod.core.signals import SIGNALS
from tierod.core.statuses import Statement, code_of
from tierod.methods.analysis.consistency import ConsistencyAccumulator, nis_figures
from tierod.methods.detectors.reversing import Reversing
from tierod.models.single_track import SingleTrack
from tierod.models.steering_column import Actuator
from tierod.monitors.baseline import Baseline
from tierod.monitors.registry import variants_with_plugins
from tierod.monitors.session import BlockSession, Conclusion, Monitor, Session, Variant
from tierod.monitors.sideslip.consistency import Consistency, Tolerances, Wrong, consistency_of
from tierod.monitors.sideslip.estimator import WORDS, CombinedSideslip, identifiability
from tierod.monitors.sideslip.evidence import TRUTHS, WALKING, Samples, SideslipDrive, truth_in
from tierod.monitors.sideslip.facts import (
    COMBINED_DECISIONS,
    LEAST_COVERAGE,
    LEAST_ENABLED,
    MISFIT_DESIGN,
    MOST_RESTARTS,
    OFFSET,
    confirmed,
    distances,
    judge,
    obstacle,
)
from tierod.monitors.sideslip.observables import WHEELS
from tierod.monitors.sideslip.tuning import BY_WIRE
from tierod.vehicles import Vehicle

MADE = {
    "road_wheel_angle": ("road_wheel_angle", "steering_wheel_angle"),
    "road_wheel_torque": ("motor_torque", "motor_current"),
}
"""Input of an estimator -> signals of the car that it is computed from."""


class SideslipEstimate(NamedTuple):
    """Output of every sideslip block after a sample."""

    # sideslip_angle, sideslip_angle_deviation: sideslip at the centre of gravity, and its standard deviation
    sideslip_angle: Annotated[float, "rad"]
    sideslip_angle_deviation: Annotated[float, "rad"]
    # self_aligning_torque, self_aligning_torque_deviation: torque of the front tyres, opposing positive steer
    self_aligning_torque: Annotated[float, "N*m"]
    self_aligning_torque_deviation: Annotated[float, "N*m"]
    nis: Annotated[float, ""]  # nis, readings: normalised innovation squared of the sample, and its number of readings
    readings: Annotated[float, ""]
    held: Annotated[float, ""]  # 1 where nothing could be estimated and the last estimate is held


@dataclass(frozen=True)
class SideslipMonitor:
    """A sideslip estimator with the signals of a car as input, and the statement on its estimate.

    The angle of the road wheels is the measured one, or else the steering wheel's times the ratio; their torque comes
    from the motor's torque, or else from its current. A missing signal is NaN; inputs computed from it are missing too.
    """

    estimator: Block  # the estimator, see the module
    steering_ratio: Annotated[float, ""]  # angle of the road wheels over that of the steering wheel
    actuator: Actuator | None  # actuator of a car steered by wire; None where the torque at the road wheels is unknown

    @classmethod
    def of_vehicle(cls, estimator: Block, vehicle: Vehicle) -> Self:
        """The estimator with ratio and actuator of a vehicle file."""
        actuator = vehicle.parameters_for(Actuator) if BY_WIRE in vehicle else None
        return cls(estimator, vehicle["steering_ratio"], actuator)

    class Output(NamedTuple):
        """Sideslip angle at the centre of gravity [rad] as a statement, and the output of the estimator.

        It is estimated where the sideslip was estimated, not enabled where the last estimate is held; its kind
        is 1 where the front axle nears its limit, its evidence the distance from that limit.
        """

        statement: Statement
        estimate: Tree

    @property
    def Sample(self) -> type:
        """NamedTuple class of the car's signals that the estimator needs."""
        return _sample_class(self.estimator.Sample._fields)

    def init(self) -> Tree:
        return self.estimator.init()

    def step(self, state: Tree, sample: Tree) -> tuple[Tree, Output]:
        kind: Tree = self.estimator.Sample
        after, estimate = self.estimator.step(state, kind(*(self._read(name, sample) for name in kind._fields)))
        statement = Statement(
            status=where(estimate.held > 0.5, code_of(Status.NOT_ENABLED), code_of(Status.ESTIMATED)),
            since=-1.0,
            kind=getattr(estimate, "limit_ahead", 0.0),
            magnitude=estimate.sideslip_angle,
            deviation=estimate.sideslip_angle_deviation,
            evidence=getattr(estimate, "limit_distance", 0.0),
        )
        return after, self.Output(statement, estimate)

    def _read(self, name: str, sample: Tree) -> Scalar:
        if name == "road_wheel_angle":
            of_wheel = self.steering_ratio * sample.steering_wheel_angle
            angle: Scalar = where(present(sample.road_wheel_angle), sample.road_wheel_angle, of_wheel)
            return angle
        if name == "road_wheel_torque":
            if self.actuator is None:
                return math.inf
            of_current = self.actuator.motor_torque(sample.motor_current)
            of_motor = where(present(sample.motor_torque), sample.motor_torque, of_current)
            torque: Scalar = self.actuator.road_wheel_torque(of_motor)
            return torque
        value: Scalar = getattr(sample, name)
        return value


@lru_cache(maxsize=64)
def _sample_class(fields: tuple[str, ...]) -> type:
    names = dict.fromkeys(signal for name in fields for signal in MADE.get(name, (name,)))
    if strange := [name for name in names if name not in SIGNALS]:
        raise ParameterError(f"a sideslip estimator reads '{strange[0]}', which is no canonical signal")
    return named_tuple("CarSample", [(name, Annotated[float, SIGNALS[name].unit]) for name in names])


REQUIRED = ("vehicle_speed", "yaw_rate")
# Signals that the estimate needs, and those that it rests on where they are present.
RESTS_ON = ("road_wheel_angle", "steering_wheel_angle", "lateral_acceleration")

JUDGED = (
    "road_wheel_angle",
    "steering_wheel_angle",
    "lateral_acceleration",
    "longitudinal_acceleration",
    "motor_torque",
    "motor_current",
    *WHEELS,
)
"""Signals that the session evaluates beside the estimator."""

TRACES = {
    "sideslip_angle": ("sideslip_angle", "rad"),
    "sideslip_angle_deviation": ("sideslip_angle_standard_deviation", "rad"),
    "self_aligning_torque": ("self_aligning_torque", "N*m"),
    "self_aligning_torque_deviation": ("self_aligning_torque_standard_deviation", "N*m"),
    "nis": ("nis", ""),
    "held": ("held", ""),
}
"""Outputs of every sideslip block over time: output -> (name in the report, unit)."""


COMBINED_TRACES = {
    "front_stiffness": ("front_stiffness_ratio", ""),
    "front_stiffness_deviation": ("front_stiffness_ratio_standard_deviation", ""),
    "rear_stiffness": ("rear_stiffness_ratio", ""),
    "rear_stiffness_deviation": ("rear_stiffness_ratio_standard_deviation", ""),
    "front_friction_used": ("front_friction_used", ""),
    "front_friction_used_deviation": ("front_friction_used_standard_deviation", ""),
    "bank_angle": ("estimated_bank_angle", "rad"),
    "bank_angle_deviation": ("estimated_bank_angle_standard_deviation", "rad"),
    "limit_ahead": ("limit_ahead", ""),
    "limit_distance": ("limit_distance", ""),
}
"""Outputs of the combined estimator shown beside the sideslip: stiffness over that of the file, grip used, bank."""


class SideslipSession(BlockSession):
    """Run a sideslip estimator over a recording, and test whether signals and parameters fit."""

    own = ("sideslip_angle_standard_deviation", "held")

    def __init__(
        self,
        estimator: Block,
        vehicle: Vehicle,
        rate: float,
        name: str,
        more: Mapping[str, tuple[str, str]] | None = None,
        needs_torque: bool = False,
    ):
        block = SideslipMonitor.of_vehicle(estimator, vehicle)
        super().__init__(block, {f"estimate.{output}": shown for output, shown in (TRACES | dict(more or {})).items()})
        self.traces = {**self.traces, "true_sideslip_angle": "rad"}
        self.signals = tuple(dict.fromkeys((*self.signals, *JUDGED, *TRUTHS)))
        self.name, self._needs_torque, self._torque_known = name, needs_torque, block.actuator is not None
        self.drive = SideslipDrive(vehicle.parameters_for(SingleTrack.Parameters), block.steering_ratio, rate)
        self._consistency, self._vehicle = ConsistencyAccumulator(), vehicle
        self._rear_distance, self._ratio = vehicle["rear_distance"], block.steering_ratio
        self._reversing = Reversing(rate, self._ratio, vehicle["front_distance"] + self._rear_distance)
        self._reverses = np.zeros(0, bool)
        self._piece: tuple[np.ndarray, Mapping[str, np.ndarray], np.ndarray] | None = None
        self.misfit_rule, self.least_coverage, self.tolerances = MISFIT_DESIGN.block(), LEAST_COVERAGE, Tolerances()

    def prepared(self, aligned: Aligned) -> Aligned:
        seen = aligned.columns
        wheel = seen["road_wheel_angle"] / self._ratio
        angle = np.where(np.isfinite(wheel), wheel, seen["steering_wheel_angle"])
        left, right = (seen[f"wheel_speed_rear_{side}"] for side in ("left", "right"))
        reverses = self._reversing.add(aligned.time, seen["yaw_rate"], angle, seen["vehicle_speed"], right - left)
        self._reverses = reverses
        if not reverses.any():
            return aligned
        values = aligned.values.copy()
        place = aligned.names.index("vehicle_speed")
        values[reverses, place] = -np.abs(values[reverses, place])
        return Aligned(aligned.time, values, aligned.names)

    def taken(self, aligned: Aligned, result: Result) -> Mapping[str, np.ndarray]:
        shown = dict(super().taken(aligned, result))
        shown["true_sideslip_angle"] = truth_in(aligned.columns)
        self._piece = aligned.time, aligned.columns, shown["sideslip_angle_standard_deviation"]
        held = shown["held"] > 0.5
        spreads = [name for name in shown if name.endswith("_standard_deviation")]
        return shown | {name: np.where(held, np.nan, shown[name]) for name in spreads}

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        running = result["statement.status"] == code_of(Status.ESTIMATED)
        self._consistency.add(result["estimate.nis"][running], result["estimate.readings"][running])
        self.drive.add(running, self._reverses, signals, result, contradictions=not self.moved)

    def conclude(self) -> Conclusion:
        notes = (Fact("reversed", self._reversing.words),) if self._reversing.words else ()
        if found := obstacle(self.drive, self._needs_torque, self._torque_known, self._reversing.mirrored):
            verdict = Verdict(self.name, found[0], found[1:], evidence=self.drive.evidence(), facts=notes)
            return Conclusion(verdict, withheld=tuple(self.traces))
        nis = self._consistency.result()
        verdict = judge(self.drive, self.name, self.misfit_rule, nis.nis, self._restarted())
        verdict = replace(verdict, facts=(*notes, *verdict.facts))
        if self.moved:
            return Conclusion(verdict)
        peak = self.drive.motions.largest
        offset = verdict.evidence.get(OFFSET, 0.0)
        consistency = consistency_of(self.drive.observables, self._vehicle, self.tolerances, offset)
        verdict = replace(
            verdict, evidence=verdict.evidence | consistency.evidence() | self.drive.own_motion.evidence()
        )
        defects, hidden = self._contradicting(consistency, verdict)
        return Conclusion(
            replace(verdict, facts=tuple(sorted((*defects, *verdict.facts), key=lambda each: each.name != "offset"))),
            consistency=nis_figures(nis),
            withheld=(*TRUTHS[1:], *hidden),
            distances=distances(verdict),
            parameter_variance=max(peak.deviation**2 - peak.own**2, 0.0),
        )

    def _contradicting(self, consistency: Consistency, verdict: Verdict) -> tuple[tuple[Fact, ...], tuple[str, ...]]:
        """The contradiction, and the traces withheld because of it; a recorded truth within the band lifts that."""
        wrong, motion = consistency.wrong(), self.drive.own_motion.wrong()
        if motion is not None and wrong is None:
            wrong = Wrong((), motion, "the estimate contradicts the motion")
        if wrong is None:
            return (), ()
        # A cause that is known says more than that several signals contradict each other.
        vague = wrong.several and not weigh(verdict, needed=(*REQUIRED, *RESTS_ON)).status.quiet
        withholds = wrong.decisive and not vague and not confirmed(verdict, self.drive)
        return (defect(wrong.names, wrong.sentence, wrong.reason, withholds),), tuple(self.traces) if withholds else ()

    def _restarted(self) -> int:
        """Number of restarts of the filter, where they are too many."""
        return 0

    def observe(self, traces: Mapping[str, np.ndarray]) -> None:
        value, deviation = traces["sideslip_angle"], traces["sideslip_angle_standard_deviation"]
        self.drive.own_motion.deviations(deviation)
        assert self._piece is not None
        (time, signals, own), self._piece = self._piece, None
        speed, yaw_rate = signals["vehicle_speed"], signals["yaw_rate"]
        with np.errstate(divide="ignore", invalid="ignore"):
            geometry = np.arctan(self._rear_distance * yaw_rate / speed)
        judged = (traces["held"] < 0.5) & (speed > WALKING) & np.isfinite(yaw_rate)
        used = traces.get("front_friction_used", np.zeros(len(time)))
        ahead = self._ahead(traces)
        self.drive.motions.add(
            Samples(time, speed, self._reverses, judged, value, deviation, own, geometry, ahead, used)
        )

    def _ahead(self, traces: Mapping[str, np.ndarray]) -> np.ndarray:
        return np.zeros(len(traces["held"]), bool)


class CombinedSession(SideslipSession):
    """A `SideslipSession` that also collects stiffness, bank, wind and the limit of grip over the drive."""

    def __init__(self, estimator: CombinedSideslip, vehicle: Vehicle, rate: float, name: str):
        super().__init__(estimator, vehicle, rate, name, COMBINED_TRACES)
        self._estimator, self.most_restarts, self._restarts = estimator, MOST_RESTARTS, 0

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        super().collect(time, signals, result)
        self._restarts += int(np.sum(result["estimate.restarted"] > 0.5))

    def _ahead(self, traces: Mapping[str, np.ndarray]) -> np.ndarray:
        forced = self._estimator.limit.forced(
            traces["front_friction_used"], traces["front_friction_used_standard_deviation"]
        )
        return np.asarray((traces["limit_ahead"] > 0.5) & forced)

    def conclude(self) -> Conclusion:
        conclusion = super().conclude()
        verdict = conclusion.verdict
        if not (verdict.status.judged or verdict.status is Status.NOT_IDENTIFIABLE) or self.memory is None:
            return conclusion
        shown = identifiability(self._estimator, self.memory)
        evidence = dict(verdict.evidence) | {
            f"{WORDS[name]}, identified share": share for name, share in shown.shares.items()
        }
        announced = self.drive.motions.announced
        evidence |= {
            "largest_front_friction_used": announced.used,
            "limit_announced_s": announced.samples / self.drive.rate,
            "restarts": float(self._restarts),
        }
        details = verdict.details
        if announced.samples:
            evidence["limit_first_announced_at_s"] = announced.first
            limit = f"the front axle came close to its largest force, announced from {announced.first:.1f} s on"
            details = (*details, limit) if verdict.status.quiet else details
        verdict = replace(verdict, evidence=evidence, details=details)
        return replace(conclusion, verdict=verdict, remarks={"estimate": str(shown)})

    def _restarted(self) -> int:
        minutes = self.drive.seconds / 60.0
        return self._restarts if self._restarts > max(self.most_restarts * minutes, 1.0) else 0


PAPER = "Yih, Ryu, Gerdes, Vehicle state estimation using steering torque (2004)"

Opener = Callable[[Vehicle, float, Baseline | None], Session]


# Lowest rate of the combined estimator where the torque of the steering is known [Hz]; with longer samples it
# attributes steering friction to other causes and diverges. Without the torque it is as good at 20 Hz as at 100.
SLOWEST_BY_WIRE = 33.0


def refuse_slow(rate: float, slowest: float) -> None:
    """Refuse a recording that comes too slowly for a variant, both in Hz."""
    if rate < slowest:
        raise ParameterError(
            f"it needs vehicle_speed and yaw_rate at {slowest:g} Hz or more, but has {rate:g} Hz; record them faster"
        )


def _combined(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
    refuse_slow(rate, SLOWEST_BY_WIRE if BY_WIRE in vehicle else 0.0)
    block = CombinedSideslip.of_vehicle(vehicle, 1.0 / rate)
    return CombinedSession(block, vehicle, rate, "sideslip, combined")


COMBINED = Variant(
    "combined",
    "One filter for all measured signals; it also estimates stiffness, friction and bank. Needs no steering "
    "torque. From 33 Hz on in a car steered by wire.",
    f"beyond {PAPER}; docs/explanation/sideslip.md",
    _combined,
    COMBINED_DECISIONS,
)

SIDESLIP = Monitor(
    name="sideslip",
    title="Sideslip of the vehicle",
    subject="Sideslip",
    summary="Estimates the sideslip angle and the aligning torque of the front tyres, with their uncertainty.",
    source=PAPER,
    drive=f"Forward driving with a steering angle for at least {LEAST_ENABLED:g} s; some minutes with bends to both "
    "sides let it learn stiffnesses and offsets, and test the vehicle file.",
    required=REQUIRED,
    optional=(*JUDGED, *TRUTHS),
    rests_on=RESTS_ON,
    rate=100.0,
    minimum_rate=20.0,
    maximum_age=0.1,
    slower=(50.0, 40.0, 33.3, 25.0, 20.0),
    variants=variants_with_plugins("sideslip", {"combined": "tierod.monitors.sideslip.definition:COMBINED"}),
    default="combined",
    estimates=True,
)
