"""A sideslip estimator over one recording: what it collects on the way, and its finding at the end.

What a sideslip block must bring to be a variant of the monitor:

- `Sample`: a flat NamedTuple of canonical signals. `road_wheel_angle` is made from the steering wheel's where it is not
  measured, `road_wheel_torque` from the motor's torque or current (`FromCarSignals`); all others are taken as they are,
  NaN where the car lacks them.
- an output with the fields of `SideslipEstimate`; it may have more, which `SideslipSession` can be told to show.

One line then makes it a variant: `SideslipSession(block, vehicle, rate, "sideslip, name", more_traces)`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.findings import Estimate, Finding, Status
from tierod.core.graph import Result
from tierod.core.recording import Aligned
from tierod.methods.analysis.consistency import ConsistencyAccumulator
from tierod.methods.detectors.rule_design import alarms_at
from tierod.models.single_track import SingleTrack
from tierod.monitors.harness.session import BlockSession, Conclusion
from tierod.monitors.sideslip.car_signals import FromCarSignals
from tierod.monitors.sideslip.decisions import (
    BAND_DECISION,
    LEAST_COVERAGE,
    MISFIT_DECISION,
    OFFSET_DECISION,
    USUAL_MISFIT,
    USUAL_OFFSET,
    misfit_rule,
)
from tierod.monitors.sideslip.motion_over_drive import MotionOverDrive
from tierod.monitors.sideslip.over_drive import TRUTHS, OverDrive, truth_in
from tierod.monitors.sideslip.sensors_over_drive import SensorsOverDrive
from tierod.monitors.sideslip.signs import TOGETHER, SignsOverDrive
from tierod.vehicles import Vehicle

JUDGED = (
    "road_wheel_angle",
    "steering_wheel_angle",
    "lateral_acceleration",
    "longitudinal_acceleration",
    "motor_torque",
    "motor_current",
)
"""Signals that the session looks at beside the estimator."""

LEAST_ENABLED = 5.0
"""Seconds of estimating below which nothing is said: a few time constants of the slowest observer."""

OFFSET = "yaw_rate_offset_rad_per_s"
"""Figure of the evidence that is there where the yaw rate has an offset."""

LEAST_COMPARED = 5.0
"""Seconds beside a truth from which on that share is judged."""

TRACES = {
    "sideslip_angle": ("sideslip_angle", "rad"),
    "sideslip_angle_deviation": ("sideslip_angle_standard_deviation", "rad"),
    "self_aligning_torque": ("self_aligning_torque", "N*m"),
    "self_aligning_torque_deviation": ("self_aligning_torque_standard_deviation", "N*m"),
    "nis": ("nis", ""),
    "held": ("held", ""),
}
"""Outputs of every sideslip block over time: output -> (name in the report, unit)."""


class SideslipEstimate(NamedTuple):
    """What every sideslip block gives out after a sample.

    Args:
        sideslip_angle, sideslip_angle_deviation: at the centre of gravity, and one standard deviation of it
        self_aligning_torque, self_aligning_torque_deviation: of the front tyres, opposing positive steer
        nis, readings: normalised innovation squared of the sample, and over how many readings
        held: 1 where nothing could be estimated and the last estimate stands
    """

    sideslip_angle: Annotated[float, "rad"]
    sideslip_angle_deviation: Annotated[float, "rad"]
    self_aligning_torque: Annotated[float, "N*m"]
    self_aligning_torque_deviation: Annotated[float, "N*m"]
    nis: Annotated[float, ""]
    readings: Annotated[float, ""]
    held: Annotated[float, ""]


class SideslipSession(BlockSession):
    """Runs a sideslip block and tells how far the car slipped, how well that is known, and why nothing can be told.

    Args:
        estimator: a sideslip block, see above
        vehicle: whose parameters it has
        rate: of the samples [Hz]
        name: of monitor and variant
        more: further outputs shown over time: output -> (name in the report, unit)
        needs_torque: whether it cannot run without the torque of the steering
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
        block = FromCarSignals.of_vehicle(estimator, vehicle)
        super().__init__(block, TRACES | dict(more or {}))
        self.traces = {**self.traces, "true_sideslip_angle": "rad"}
        self.signals = tuple(dict.fromkeys((*self.signals, *JUDGED, *TRUTHS)))
        self.name, self.rate, self._ratio = name, rate, block.ratio.steering_ratio
        self._needs_torque, self._torque_known = needs_torque, block.actuator is not None
        self._signs, self._consistency = SignsOverDrive(), ConsistencyAccumulator()
        self._over = OverDrive()
        self.misfit_rule, self.least_coverage = misfit_rule(), LEAST_COVERAGE
        parameters = vehicle.parameters_for(SingleTrack.Parameters)
        self._sensors, self._motion = SensorsOverDrive(parameters, rate), MotionOverDrive(parameters, rate)

    def absorb(self, aligned: Aligned) -> Mapping[str, np.ndarray]:
        """Take in one more piece and give the traces over it, (n,) each."""
        shown = dict(super().absorb(aligned))
        shown["true_sideslip_angle"] = truth_in(dict(zip(aligned.names, aligned.values.T, strict=True)))
        held = shown["held"] > 0.5
        spreads = [name for name in shown if name.endswith("_standard_deviation")]
        return shown | {name: np.where(held, np.nan, shown[name]) for name in spreads}

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Estimates, innovations and signs of one piece."""
        running = result["held"] < 0.5
        measured, wheel = signals["road_wheel_angle"], self._ratio * signals["steering_wheel_angle"]
        angle = np.where(np.isfinite(measured), measured, wheel)
        torque = np.where(np.isfinite(signals["motor_torque"]), signals["motor_torque"], signals["motor_current"])
        self._consistency.add(result["nis"][running], result["readings"][running])
        self._over.add(running, result, truth_in(signals), signals["vehicle_speed"], angle, torque)
        together = (angle, signals["yaw_rate"], signals["lateral_acceleration"], torque)
        self._sensors.add(signals["vehicle_speed"], signals["yaw_rate"], signals["lateral_acceleration"], angle)
        self._motion.add(
            signals["vehicle_speed"],
            signals["yaw_rate"],
            signals["lateral_acceleration"],
            signals["longitudinal_acceleration"],
            angle,
        )
        self._signs.add(signals["vehicle_speed"], dict(zip(TOGETHER, together, strict=True)))

    def conclude(self) -> Conclusion:
        """The finding, and how consistent the estimate was."""
        found = self._consistency.result()
        over, seconds = self._over, self._over.samples / self.rate
        evidence = {"enabled_s": seconds, "enabled_share": over.samples / max(over.seen, 1)}
        if self._signs.turned():
            agreements = self._signs.agreements().items()
            evidence |= {f"agreement of {one} and {other}": value for (one, other), value in agreements}
        if reason := self._obstacle(seconds):
            return Conclusion(self._withheld(*reason, evidence), withheld=tuple(self.traces))
        if over.compared:
            evidence["error_against_truth_rms_rad"] = math.sqrt(over.squared_error / over.compared)
            evidence["error_against_truth_mean_absolute_rad"] = over.absolute_error / over.compared
            evidence["truth_within_band_share"] = over.covered / over.compared
        evidence |= {"mean_deviation_rad": over.deviation / over.samples, "nis_mean": found.nis}
        figures = {
            "enabled_samples": float(found.samples),
            "nis_mean": found.nis,
            "nis_band_low": found.nis_band[0],
            "nis_band_high": found.nis_band[1],
            "nis_outside_95_share": found.outside,
        }
        finding = self._contradicted(self._with_offset(self._told(evidence, found.nis)))
        return Conclusion(finding, consistency=figures, withheld=TRUTHS[1:], distances=self._distances(finding))

    def _distances(self, finding: Finding) -> dict[str, float]:
        """What the decisions saw that look once at the recording."""
        evidence = finding.evidence
        found = {MISFIT_DECISION.name: math.log(max(evidence["nis_mean"], 1e-12)) / USUAL_MISFIT}
        if OFFSET in evidence:
            found[OFFSET_DECISION.name] = evidence[OFFSET] / USUAL_OFFSET
        if "truth_within_band_share" in evidence:
            found[BAND_DECISION.name] = evidence["truth_within_band_share"]
        return found

    def _obstacle(self, seconds: float) -> tuple[Status, str, str] | None:
        """Why nothing can be told: status, cause, what to do; None where something can."""
        over = self._over
        if turned := self._signs.turned():
            names = " or ".join(turned)
            cause = f"the sign of {names} contradicts the other signals of a turning car"
            return Status.NOT_TESTABLE, cause, f"correct the sign of {names} in the channel map"
        if wrong := self._sensors.wrong_unit():
            return Status.NOT_TESTABLE, wrong, "correct the unit in the channel map"
        if not over.angles:
            cause = "the recording has neither road_wheel_angle nor steering_wheel_angle"
            return Status.NOT_AVAILABLE, cause, "name one of them in the channel map"
        if self._needs_torque and not (over.torques and self._torque_known):
            missing = "motor_torque or motor_current" if self._torque_known else "gearhead_ratio in the vehicle file"
            cause = f"this variant needs the torque of the steering, and there is no {missing}"
            return Status.NOT_AVAILABLE, cause, "take a variant that needs no torque (--variant combined), or add it"
        if seconds < LEAST_ENABLED:
            cause = (
                f"it could be estimated for {seconds:.1f} s, {LEAST_ENABLED:g} s are needed; the car stood, rolled "
                f"backwards, or speed or angle were missing (fastest {over.fastest:.1f} m/s)"
            )
            return Status.NOT_ENABLED, cause, "record a drive, with speed and steering angle throughout"
        return None

    def _withheld(self, status: Status, cause: str, action: str, evidence: dict[str, float]) -> Finding:
        headline = f"Sideslip angle: {status.value}; {cause}."
        return Finding(self.name, status, headline, evidence=evidence, cause=cause, action=action)

    def _told(self, evidence: dict[str, float], nis: float) -> Finding:
        over = self._over
        estimate = Estimate("largest sideslip angle at the centre of gravity", over.peak, over.peak_deviation, "rad")
        told = f"{_signed(math.degrees(over.peak), 2)} ± {math.degrees(over.peak_deviation):.2f} degrees"
        if alarms_at(self.misfit_rule, math.log(max(nis, 1e-12)) / USUAL_MISFIT):
            cause = f"the innovations are {math.sqrt(nis):.1f} times as large as the estimator expects"
            return Finding(
                self.name,
                Status.NOT_IDENTIFIABLE,
                f"Sideslip angle up to {told}, but the parameters do not fit this car: {cause}.",
                estimate=estimate,
                evidence=evidence,
                cause=cause,
                action="give a vehicle file that fits: stiffness, trail, friction and inertia of the steering",
            )
        headline = f"Sideslip angle up to {told}, estimated for {evidence['enabled_s']:.0f} s."
        share = evidence.get("truth_within_band_share", 1.0)
        if share < self.least_coverage and over.compared >= LEAST_COMPARED * self.rate:
            error = math.degrees(evidence["error_against_truth_rms_rad"])
            cause = f"the 95 % band holds the recorded truth for {100.0 * share:.0f} % of the time only"
            return Finding(
                self.name,
                Status.SUSPECT,
                f"{headline} But {cause}; the error is {error:.2f} degrees (root mean square).",
                estimate=estimate,
                evidence=evidence,
                cause=f"{cause}: parameters of the vehicle file or offsets of sensors are wrong by more than it says",
                action="take that error as the uncertainty, or fit stiffness and friction of the vehicle file to the "
                "truth and calibrate the sensors",
                decided_by=(BAND_DECISION.name,),
            )
        return Finding(self.name, Status.HEALTHY, headline, estimate=estimate, evidence=evidence, action="none")

    def _with_offset(self, finding: Finding) -> Finding:
        """The finding, not healthy and with the cause named where the yaw rate has an offset."""
        if (offset := self._sensors.offset(self._motion.yaw_rate_offset())) is None:
            return finding
        told = (
            f"the yaw rate has an offset of {_signed(math.degrees(offset.value), 1)} degrees per second, told by its "
            f"mean {offset.told_by}"
        )
        healthy, suspect = finding.status is Status.HEALTHY, finding.status is Status.SUSPECT
        joint = "But" if healthy else "For"
        return replace(
            finding,
            status=Status.SUSPECT if healthy else finding.status,
            headline=f"{finding.headline} {joint} {told}." if healthy or suspect else finding.headline,
            evidence={**finding.evidence, OFFSET: offset.value},
            cause=told,
            action="calibrate the yaw rate, or take its offset away in the channel map, and judge anew",
            warnings=(*finding.warnings, f"{told}: the sideslip angle is wrong by it"),
            decided_by=(*finding.decided_by, OFFSET_DECISION.name),
        )

    def _contradicted(self, finding: Finding) -> Finding:
        """The finding with the signals that contradict the motion; suspect where the estimate rests on one of them."""
        wrong = self._motion.wrong()
        finding = replace(finding, warnings=(*finding.warnings, *(each.sentence for each in wrong)))
        decisive = [each.sentence for each in wrong if each.names != ("longitudinal_acceleration",)]
        if not decisive or finding.status is not Status.HEALTHY:
            return finding
        return replace(
            finding,
            status=Status.SUSPECT,
            headline=f"{finding.headline} But {decisive[0]}.",
            cause=decisive[0],
            action="correct sign, unit and time of the signal in the channel map, or repair the sensor, and judge anew",
        )


def _signed(value: float, decimals: int) -> str:
    """With its sign, and the minus that reports write."""
    return f"{value:+.{decimals}f}".replace("-", "−")
