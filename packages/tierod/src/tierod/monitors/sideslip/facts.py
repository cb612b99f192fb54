"""Decisions of the sideslip monitor, and the finding over a drive."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated

from tierod.core.findings import Estimate, Finding, Status
from tierod.methods.detectors import Detector
from tierod.methods.detectors.control_charts import HeldThreshold
from tierod.methods.detectors.reversing import MIRRORED, TURN_FORWARD
from tierod.methods.detectors.rule_design import RuleDesign, alarms_at
from tierod.methods.detectors.stopping_rules import HoldRule
from tierod.monitors.harness.decision import Decision, Demonstrated, OwnRule
from tierod.monitors.harness.verdict import Obstacle
from tierod.monitors.sideslip.consistency import FILE_WEIGHT as FILE
from tierod.monitors.sideslip.consistency import SIGNALS_WEIGHT as SIGNALS
from tierod.monitors.sideslip.consistency import Tolerances
from tierod.monitors.sideslip.evidence import WALKING, Largest, SideslipDrive
from tierod.monitors.sideslip.sensors import OFFSET_DESIGN, USUAL_OFFSET
from tierod.monitors.sideslip.tuning import CombinedTuning

USUAL_MISFIT = 0.48
"""Standard deviation of the logarithm of the mean NIS [-]; a consistent filter has a NIS of 1, parameters that are
wrong by half give 0.4 to 2.7 (simulated), taken as two standard deviations either way."""

MISFIT_DESIGN = RuleDesign(HoldRule(1, sides="upper"), values=500.0, shift=4.0, spacing=math.inf)
"""One decision at the end of a recording, designed for cars whose parameters are wrong by half."""

MOST_RESTARTS: Annotated[float, "1/min"] = 2.0
"""Restarts of the filter per minute above which its parameters do not fit; one difficult minute may cost one."""

LEAST_COVERAGE = 0.8
"""Share of the time for which the 95 % band must contain a recorded truth [-]; less cannot be chance, and shows a band
that is too narrow."""


OFFSET_DECISION = Decision(
    name="offset of the yaw rate",
    distance="mean yaw rate of the standing car, or its mean difference from steering and lateral acceleration, or "
    "from steering and rear wheel speeds, in standard deviations of a calibrated sensor's offset (0.12 degrees per "
    "second)",
    rule=OFFSET_DESIGN.block(),
    place="drive.sensors.offset_rule",
    mean_time_between_false_alarms=1e6,
    demonstrated=Demonstrated(24.0),
    source="Gaussian offsets; drives of the virtual car, random and mixed",
    unit="recording",
    design=OFFSET_DESIGN,
)

MISFIT_DECISION = Decision(
    name="parameters do not fit",
    distance="log of the mean NIS per reading, in standard deviations over cars whose parameters are wrong by half",
    rule=MISFIT_DESIGN.block(),
    place="misfit_rule",
    mean_time_between_false_alarms=500.0,
    demonstrated=Demonstrated(24.0),
    source="lognormal NIS; drives of the virtual car, random and mixed (0.48 to 0.52)",
    unit="recording",
    design=MISFIT_DESIGN,
)

BAND_DECISION = Decision(
    name="band beside a recorded truth",
    distance="share of the time for which the 95 % band contains the truth",
    rule=OwnRule("less than 80 % of 5 s or more", {"least_coverage": LEAST_COVERAGE}),
    place="",
    mean_time_between_false_alarms=None,
    demonstrated=Demonstrated(24.0),
    source="drives of the virtual car, random and mixed (0.96 to 1)",
    unit="recording",
    levels=(LEAST_COVERAGE,),
    below=True,
)

LIMITS = Tolerances()

SIGNALS_DECISION = Decision(
    name="signals contradict each other or the vehicle file",
    distance="reduction of the squared normalised deviations by one wrong scale or zero",
    rule=OwnRule(
        f"above {LIMITS.decides:g}, and a scale that is wrong by {LIMITS.least:.0%} or more".replace("%", " %"),
        {"tolerances.decides": LIMITS.decides, "tolerances.least": LIMITS.least},
    ),
    place="",
    mean_time_between_false_alarms=None,
    demonstrated=Demonstrated(24.0),
    source="virtual cars with brochure values and real cars with their own files",
    unit="recording",
    levels=(LIMITS.decides,),
)

FILE_DECISION = replace(
    SIGNALS_DECISION,
    name="vehicle file of another car",
    distance="reduction of the squared normalised deviations by another wheelbase, understeer, place of the "
    "accelerometer and track",
    rule=OwnRule(f"above {LIMITS.file_decides:g}", {"tolerances.file_decides": LIMITS.file_decides}),
    levels=(LIMITS.file_decides,),
)

DECISIONS = (OFFSET_DECISION, MISFIT_DECISION, BAND_DECISION, SIGNALS_DECISION, FILE_DECISION)
"""Decisions of every variant."""

COMBINED_DECISIONS = (
    *DECISIONS,
    Decision(
        name="limit of the front axle ahead",
        distance="front slip less the slip at 0.7 of the greatest front force, in standard deviations of the estimate",
        rule=HeldThreshold(CombinedTuning().limit_certainty, 1, "upper"),
        place="_estimator.limit_rule",
        mean_time_between_false_alarms=None,
        demonstrated=Demonstrated(0.91),
        source="tierod study sideslip: an announcement is false with less than 60 % of the grip in use; with more it "
        "is intended, so no run length is designed",
        statistic="limit_distance",
        levels=(CombinedTuning().limit_certainty,),
    ),
    Decision(
        name="filter lost",
        distance="restarts of the filter per minute of estimation; it restarts where the innovations over 1 s are "
        "twice as large as expected",
        rule=OwnRule(
            "more than 2 per minute, and more than one; mean NIS above 4",
            {"most_restarts": MOST_RESTARTS, "_estimator.most_misfit": CombinedTuning().most_misfit},
        ),
        place="",
        mean_time_between_false_alarms=None,
        demonstrated=Demonstrated(24.0),
        source="drives of the virtual car, random and mixed (none at all)",
        unit="recording",
    ),
)
"""Decisions of the combined estimator."""


LEAST_ENABLED = 5.0
"""Least estimated time for a statement [s]; a few time constants of the slowest observer."""

OFFSET = "yaw_rate_offset_rad_per_s"
"""Name of the yaw rate offset in the evidence, present only where there is one."""

LARGE_GEOMETRY: Annotated[float, "rad"] = math.radians(2.0)
"""Sideslip angle of a turn without slip from which the headline says so; tyres alone make 2 degrees in hard bends."""

LEAST_COMPARED = 5.0
"""Least time with a recorded truth for a judgement of the band [s]."""


def obstacle(drive: SideslipDrive, needs_torque: bool, torque_known: bool, mirrored: bool = False) -> Obstacle | None:
    """Why no statement is possible; None where one is."""
    if mirrored:
        return Obstacle(Status.NOT_TESTABLE, MIRRORED, TURN_FORWARD)
    if turned := drive.sensors.turned():
        names = " or ".join(turned)
        cause = f"the sign of {names} contradicts the other signals of a turning car"
        return Obstacle(Status.NOT_TESTABLE, cause, f"correct the sign of {names} in the channel map")
    if wrong := drive.sensors.wrong_unit():
        return Obstacle(Status.NOT_TESTABLE, wrong, "correct the unit in the channel map")
    if not drive.angles:
        cause = "the recording has neither road_wheel_angle nor steering_wheel_angle"
        return Obstacle(Status.NOT_AVAILABLE, cause, "name one of them in the channel map")
    if needs_torque and not (drive.torques and torque_known):
        missing = "motor_torque or motor_current" if torque_known else "gearhead_ratio in the vehicle file"
        cause = f"this variant needs the torque of the steering, but there is no {missing}"
        return Obstacle(
            Status.NOT_AVAILABLE,
            cause,
            "choose a variant that needs no torque (--variant combined), or add what is missing",
        )
    if drive.seconds < LEAST_ENABLED:
        if 0.0 < drive.fastest <= WALKING:
            cause = (
                f"the car drove at walking pace throughout (fastest {drive.fastest:.1f} m/s), where the geometry of "
                "the turn alone makes the sideslip"
            )
            return Obstacle(Status.NOT_ENABLED, cause, f"record a drive above {WALKING:g} m/s")
        cause = (
            f"it could be estimated for {drive.seconds:.1f} s only, {LEAST_ENABLED:g} s are needed; the car stood, "
            f"rolled backwards, or speed or angle were missing (fastest {drive.fastest:.1f} m/s)"
        )
        return Obstacle(Status.NOT_ENABLED, cause, "record a drive, with speed and steering angle throughout")
    return None


def judge(drive: SideslipDrive, name: str, misfit_rule: Detector, nis: float) -> Finding:
    """The finding where the sideslip was estimated."""
    evidence = {**drive.evidence(), **drive.beside_truth(), "nis_mean": nis}
    peak = drive.motions.largest
    estimate = Estimate("largest sideslip angle at the centre of gravity", peak.value, peak.deviation, "rad")
    largest = f"{_signed(math.degrees(peak.value), 2)} ± {math.degrees(peak.deviation):.2f} degrees"
    if alarms_at(misfit_rule, math.log(max(nis, 1e-12)) / USUAL_MISFIT):
        cause = f"the innovations are {math.sqrt(nis):.1f} times as large as the estimator expects"
        headline = f"Sideslip angle up to {largest}, but the parameters do not fit this car: {cause}."
        steering = ", and trail, friction and inertia of the steering" if drive.torques else ""
        action = f"give a vehicle file that fits this car: mass, stiffness and noise of the sensors{steering}"
        found = Finding(name, Status.NOT_IDENTIFIABLE, headline, None, estimate, evidence, cause, action)
    else:
        headline = f"Sideslip angle up to {largest}, estimated for {drive.seconds:.0f} s.{_geometry(peak)}"
        status = Status.CONSISTENT if drive.compared >= LEAST_COMPARED else Status.ESTIMATED
        found = Finding(name, status, headline, None, estimate, evidence, action="none")
        found = _beside_truth(found, drive.compared)
    return _contradicted(_with_offset(found, drive), drive)


def _geometry(peak: Largest) -> str:
    tyres = abs(peak.value - peak.geometry)
    if abs(peak.geometry) < LARGE_GEOMETRY or tyres > 0.5 * abs(peak.geometry):
        return ""
    return f" Most of it is the geometry of a tight turn at {3.6 * peak.speed:.0f} km/h."


def confirmed(finding: Finding, drive: SideslipDrive) -> bool:
    """Whether the band contains a recorded truth for enough of the time."""
    share = finding.evidence.get("truth_within_band_share", 0.0)
    return share >= LEAST_COVERAGE and drive.compared >= LEAST_COMPARED


def _beside_truth(finding: Finding, seconds: float) -> Finding:
    share = finding.evidence.get("truth_within_band_share", 1.0)
    if not (share < LEAST_COVERAGE and seconds >= LEAST_COMPARED):
        return finding
    error = math.degrees(finding.evidence["error_against_truth_rms_rad"])
    cause = f"the 95 % band contains the recorded truth for only {100.0 * share:.0f} % of the time"
    return replace(
        finding,
        status=Status.INCONSISTENT,
        headline=f"{finding.headline} But {cause}; the error is {error:.2f} degrees (root mean square).",
        cause=f"{cause}: parameters of the vehicle file or offsets of sensors are wrong by more than the band covers",
        action="use this error as the uncertainty, or fit stiffness and friction of the vehicle file to the truth and "
        "calibrate the sensors",
        decided_by=(BAND_DECISION.name,),
    )


def _with_offset(finding: Finding, drive: SideslipDrive) -> Finding:
    if (offset := drive.sensors.offset(drive.observables.yaw_rate_offset())) is None:
        return finding
    cause = (
        f"the yaw rate has an offset of {_signed(math.degrees(offset.value), 1)} degrees per second, shown by its "
        f"mean {offset.shown_by}"
    )
    joint = "But" if finding.status.quiet else "Cause:"
    return replace(
        finding,
        status=finding.status.doubted if finding.status.judged else finding.status,
        headline=f"{finding.headline} {joint} {cause}." if finding.status.judged else finding.headline,
        evidence={**finding.evidence, OFFSET: offset.value},
        cause=cause,
        action="calibrate the yaw rate sensor, or subtract its offset in the channel map, and judge again",
        warnings=(*finding.warnings, f"{cause}: it causes an error of the sideslip angle"),
        decided_by=(*finding.decided_by, OFFSET_DECISION.name),
    )


def _contradicted(finding: Finding, drive: SideslipDrive) -> Finding:
    wrong = drive.sensors.wrong_motion()
    if wrong is None:
        return finding
    finding = replace(finding, warnings=(*finding.warnings, wrong.cause))
    if wrong.rests_on == ("longitudinal_acceleration",) or not finding.status.quiet:
        return finding
    return replace(
        finding,
        status=Status.INCONSISTENT,
        headline=f"{finding.headline} But {wrong.cause}.",
        cause=wrong.cause,
        action="correct sign and unit of the signal in the channel map, correct its time stamps, or repair the "
        "sensor, and judge again",
    )


def distances(finding: Finding) -> dict[str, float]:
    """Statistics of the decisions that are taken once per recording, by name of the decision."""
    evidence = finding.evidence
    found = {MISFIT_DECISION.name: math.log(max(evidence["nis_mean"], 1e-12)) / USUAL_MISFIT}
    if OFFSET in evidence:
        found[OFFSET_DECISION.name] = evidence[OFFSET] / USUAL_OFFSET
    if "truth_within_band_share" in evidence:
        found[BAND_DECISION.name] = evidence["truth_within_band_share"]
    found |= {SIGNALS_DECISION.name: evidence[SIGNALS], FILE_DECISION.name: evidence[FILE]}
    return found


def _signed(value: float, decimals: int) -> str:
    return f"{value:+.{decimals}f}".replace("-", "−")
