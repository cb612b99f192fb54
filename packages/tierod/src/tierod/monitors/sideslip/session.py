"""Session of a sideslip estimator over one recording: collection piece by piece, and the conclusion at the end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tierod.core.block import Block
from tierod.core.findings import Defect, Finding, Status
from tierod.core.graph import Result
from tierod.core.recording import Aligned
from tierod.core.statement import code_of
from tierod.methods.analysis.consistency import ConsistencyAccumulator
from tierod.methods.detectors.reversing import Reversing
from tierod.models.single_track import SingleTrack
from tierod.monitors.harness.session import BlockSession, Conclusion
from tierod.monitors.harness.verdict import nis_figures, withheld
from tierod.monitors.sideslip.combined import CombinedSideslip
from tierod.monitors.sideslip.combined_identifiability import WORDS, identifiability
from tierod.monitors.sideslip.consistency import Consistency, Wrong, consistency_of
from tierod.monitors.sideslip.decisions import LEAST_COVERAGE, MISFIT_DESIGN, MOST_RESTARTS
from tierod.monitors.sideslip.drive import TRUTHS, WALKING, SideslipDrive, truth_in
from tierod.monitors.sideslip.expected import Tolerances
from tierod.monitors.sideslip.finding import OFFSET, confirmed, distances, judge, obstacle
from tierod.monitors.sideslip.monitor import SideslipMonitor
from tierod.monitors.sideslip.motions import Samples
from tierod.monitors.sideslip.observables import WHEELS
from tierod.vehicles import Vehicle

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


class SideslipSession(BlockSession):
    """Run a sideslip estimator over a recording, and test whether signals and parameters fit.

    Args:
        estimator: a block, see `tierod.monitors.sideslip.monitor`
        vehicle: vehicle with the estimator's parameters
        rate: sampling rate [Hz]
        name: name of monitor and variant
        more: further outputs shown over time: output -> (name in the report, unit)
        needs_torque: whether the estimator cannot run without the torque of the steering
    """

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
        self.drive = SideslipDrive(vehicle.parameters_for(SingleTrack.Parameters), block.ratio.steering_ratio, rate)
        self._consistency, self._vehicle = ConsistencyAccumulator(), vehicle
        self._rear_distance, self._ratio = vehicle["rear_distance"], block.ratio.steering_ratio
        self._reversing = Reversing(rate, self._ratio, vehicle["front_distance"] + self._rear_distance)
        self._reverses = np.zeros(0, bool)
        self._piece: tuple[np.ndarray, Mapping[str, np.ndarray], np.ndarray] | None = None
        self.misfit_rule, self.least_coverage, self.tolerances = MISFIT_DESIGN.block(), LEAST_COVERAGE, Tolerances()

    def prepared(self, aligned: Aligned) -> Aligned:
        """Next piece, with a negative speed where the car is known to reverse, by the sign of its speeds or without."""
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
        """Collect the estimator's outputs of a piece, and return the traces over it, (n,) each."""
        shown = dict(super().taken(aligned, result))
        shown["true_sideslip_angle"] = truth_in(aligned.columns)
        self._piece = aligned.time, aligned.columns, shown["sideslip_angle_standard_deviation"]
        held = shown["held"] > 0.5
        spreads = [name for name in shown if name.endswith("_standard_deviation")]
        return shown | {name: np.where(held, np.nan, shown[name]) for name in spreads}

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Collect estimates, innovations and signals of one piece."""
        running = result["statement.status"] == code_of(Status.ESTIMATED)
        self._consistency.add(result["estimate.nis"][running], result["estimate.readings"][running])
        self.drive.add(running, self._reverses, signals, result, contradictions=not self.moved)

    def conclude(self) -> Conclusion:
        """The finding, with the consistency of the innovations."""
        reversed_ = (self._reversing.words,) if self._reversing.words else ()
        if reason := obstacle(self.drive, self._needs_torque, self._torque_known, self._reversing.mirrored):
            finding = withheld(self.name, "Sideslip angle", [reason], self.drive.evidence(), reversed_)
            return Conclusion(finding, withheld=tuple(self.traces))
        found = self._consistency.result()
        finding = judge(self.drive, self.name, self.misfit_rule, found.nis)
        finding = replace(finding, warnings=(*reversed_, *finding.warnings))
        if self.moved:
            return Conclusion(finding)
        peak = self.drive.motions.largest
        offset = finding.evidence.get(OFFSET, 0.0)
        consistency = consistency_of(self.drive.observables, self._vehicle, self.tolerances, offset)
        finding = replace(finding, evidence={**finding.evidence, **consistency.evidence(), **self._share()})
        defects, hidden = self._contradicting(consistency, finding)
        return Conclusion(
            finding,
            consistency=nis_figures(found),
            withheld=(*TRUTHS[1:], *hidden),
            distances=distances(finding),
            defects=defects,
            parameter_variance=max(peak.deviation**2 - peak.own**2, 0.0),
        )

    def _contradicting(self, consistency: Consistency, finding: Finding) -> tuple[tuple[Defect, ...], tuple[str, ...]]:
        """The contradiction, and the traces withheld because of it; a recorded truth within the band lifts that."""
        wrong, motion = consistency.wrong(), self.drive.own_motion.wrong()
        if motion is not None and wrong is None:
            wrong = Wrong((), motion)
        if wrong is None:
            return (), ()
        # A cause that is known says more than that several signals contradict each other.
        vague = wrong.several and not finding.status.quiet
        withholds = wrong.decisive and not vague and not confirmed(finding, self.drive)
        return (Defect(wrong.names, wrong.sentence, withholds),), tuple(self.traces) if withholds else ()

    def _share(self) -> dict[str, float]:
        found = self.drive.own_motion.share()
        if found is None:
            return {}
        return {"estimated_motion_share": found.value, "estimated_motion_share_deviation": found.deviation}

    def observe(self, traces: Mapping[str, np.ndarray]) -> None:
        """Collect what the headline shows of the last piece, with bands that include the spread of the parameters."""
        value, deviation = traces["sideslip_angle"], traces["sideslip_angle_standard_deviation"]
        self.drive.own_motion.deviations(deviation)
        assert self._piece is not None
        (time, signals, own), self._piece = self._piece, None
        speed, yaw_rate = signals["vehicle_speed"], signals["yaw_rate"]
        none = np.zeros(len(time))
        with np.errstate(divide="ignore", invalid="ignore"):
            geometry = np.arctan(self._rear_distance * yaw_rate / speed)
        self.drive.motions.add(
            Samples(
                time,
                speed,
                self._reverses,
                (traces["held"] < 0.5) & (speed > WALKING) & np.isfinite(yaw_rate),
                value,
                deviation,
                own,
                geometry,
                self._ahead(traces),
                traces.get("front_friction_used", none),
            )
        )

    def _ahead(self, traces: Mapping[str, np.ndarray]) -> np.ndarray:
        """Whether the limit of grip is announced in each sample of a piece, (n,); never by the paper's observers."""
        return np.zeros(len(traces["held"]), bool)


class CombinedSession(SideslipSession):
    """A `SideslipSession` that also collects stiffness, bank, wind and the limit of grip over the drive.

    Args:
        estimator: the combined estimator
        vehicle: vehicle with the estimator's parameters
        rate: sampling rate [Hz]
        name: name of monitor and variant
        more: further outputs shown over time: output -> (name in the report, unit)
    """

    def __init__(
        self,
        estimator: CombinedSideslip,
        vehicle: Vehicle,
        rate: float,
        name: str,
        more: Mapping[str, tuple[str, str]] | None = None,
    ):
        super().__init__(estimator, vehicle, rate, name, more)
        self._estimator, self.most_restarts = estimator, MOST_RESTARTS
        self._restarts = 0

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Collect also restarts of the filter."""
        super().collect(time, signals, result)
        self._restarts += int(np.sum(result["estimate.restarted"] > 0.5))

    def _ahead(self, traces: Mapping[str, np.ndarray]) -> np.ndarray:
        """Whether the limit of grip is announced, by bands with the parameters' spread, in each sample, (n,)."""
        forced = self._estimator.limit.forced(
            traces["front_friction_used"], traces["front_friction_used_standard_deviation"]
        )
        return np.asarray((traces["limit_ahead"] > 0.5) & forced)

    def conclude(self) -> Conclusion:
        """The finding, with shares of identified unknowns, the limit of grip, and restarts."""
        conclusion = super().conclude()
        finding = conclusion.finding
        if not (finding.status.judged or finding.status is Status.NOT_IDENTIFIABLE) or self.memory is None:
            return conclusion
        shown = identifiability(self._estimator, self.memory)
        evidence = dict(finding.evidence) | {
            f"{WORDS[name]}, identified share": share for name, share in shown.shares.items()
        }
        announced = self.drive.motions.announced
        evidence |= {
            "largest_front_friction_used": announced.used,
            "limit_announced_s": announced.samples / self.drive.rate,
            "restarts": float(self._restarts),
        }
        limit = ""
        if announced.samples:
            evidence["limit_first_announced_at_s"] = announced.first
            limit = f"The front axle came close to its largest force, announced from {announced.first:.1f} s on."
        finding = self._judged(replace(finding, evidence=evidence))
        return replace(conclusion, finding=finding, remarks={"estimate": str(shown)}, further=limit)

    def _judged(self, finding: Finding) -> Finding:
        """The finding; not identifiable where the filter restarted too often."""
        minutes = finding.evidence["enabled_s"] / 60.0
        if finding.status is not Status.NOT_IDENTIFIABLE and self._restarts > max(self.most_restarts * minutes, 1.0):
            cause = f"the filter diverged and restarted {self._restarts} times"
            if OFFSET in finding.evidence:
                return replace(
                    finding, status=Status.NOT_IDENTIFIABLE, headline=f"{finding.headline} With this offset, {cause}."
                )
            return replace(
                finding,
                status=Status.NOT_IDENTIFIABLE,
                headline=f"{finding.headline} But signals or parameters do not fit this car: {cause}.",
                cause=f"{finding.cause}; {cause}" if finding.cause else cause,
                action="check scale and unit of yaw rate, lateral acceleration and speed in the channel map, and "
                "their time stamps; if they are right, give a vehicle file that fits this car: mass, stiffness, "
                "friction and noise of the sensors",
            )
        return finding
