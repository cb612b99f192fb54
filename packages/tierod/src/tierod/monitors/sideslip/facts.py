"""Decisions of the sideslip monitor, and the finding over a drive."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated

from tierod.core.facts import Fact, Verdict, defect
from tierod.core.findings import Estimate, Status
from tierod.methods.detectors import Detector
from tierod.methods.detectors.control_charts import HeldThreshold
from tierod.methods.detectors.reversing import MIRRORED, TURN_FORWARD
from tierod.methods.detectors.rule_design import RuleDesign, alarms_at
from tierod.methods.detectors.stopping_rules import HoldRule
from tierod.monitors.decision import Decision, Demonstrated, OwnRule
from tierod.monitors.sideslip.consistency import FILE_WEIGHT as FILE
from tierod.monitors.sideslip.consistency import SIGNALS_WEIGHT as SIGNALS
from tierod.monitors.sideslip.consistency import Tolerances
from tierod.monitors.sideslip.evidence import WALKING, Largest, SideslipDrive
from tierod.monitors.sideslip.sensors import OFFSET_DESIGN, USUAL_OFFSET
from tierod.monitors.sideslip.tuning import CombinedTuning

# Standard deviation of the logarithm of the mean NIS [-]; a consistent filter has a NIS of 1, parameters that are wrong
# by half give 0.4 to 2.7 (simulated), taken as two standard deviations either way.
USUAL_MISFIT = 0.48
# One decision at the end of a recording, designed for cars whose parameters are wrong by half.
MISFIT_DESIGN = RuleDesign(HoldRule(1, sides="upper"), values=500.0, shift=4.0, spacing=math.inf)
# Restarts of the filter per minute above which its parameters do not fit; one difficult minute may cost one.
MOST_RESTARTS: Annotated[float, "1/min"] = 2.0
# Share of the time for which the 95 % band must contain a recorded truth [-]; less cannot be chance, and shows a band
# that is too narrow.
LEAST_COVERAGE = 0.8


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

# Decisions of every variant.
DECISIONS = (OFFSET_DECISION, MISFIT_DECISION, BAND_DECISION, SIGNALS_DECISION, FILE_DECISION)

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


LEAST_ENABLED = 5.0  # least estimated time for a statement [s]; a few time constants of the slowest observer
OFFSET = "yaw_rate_offset_rad_per_s"  # name of the yaw rate offset in the evidence, present only where there is one
# Sideslip angle of a turn without slip from which a detail says so; tyres alone make 2 degrees in hard bends.
LARGE_GEOMETRY: Annotated[float, "rad"] = math.radians(2.0)
LEAST_COMPARED = 5.0  # least time with a recorded truth for a judgement of the band [s]

CASES = {
    each.name: each
    for each in (
        Fact("mirrored", MIRRORED, "reversed throughout, or yaw_rate is mirrored", TURN_FORWARD),
        Fact(
            "sign",
            "the sign of {names} contradicts the other signals of a turning car",
            "the sign of {names} is wrong",
            "correct the sign of {names} in the channel map",
        ),
        Fact("unit", "{cause}", "{signal} has a wrong unit", "correct the unit in the channel map"),
        Fact(
            "no angle",
            "the recording has neither road_wheel_angle nor steering_wheel_angle",
            "no steering angle",
            "name one of them in the channel map",
        ),
        Fact(
            "no torque",
            "this variant needs the torque of the steering, but there is no {missing}",
            "no steering torque",
            "choose a variant that needs no torque (--variant combined), or add what is missing",
        ),
        Fact(
            "walking pace",
            "the car drove at walking pace throughout (fastest {fastest:.1f} m/s), where the geometry of the turn "
            "alone makes the sideslip",
            "the car drove at walking pace throughout",
            f"record a drive above {WALKING:g} m/s",
        ),
        Fact(
            "too short",
            f"it could be estimated for {{seconds:.1f}} s only, {LEAST_ENABLED:g} s are needed; the car stood, rolled "
            "backwards, or speed or angle were missing (fastest {fastest:.1f} m/s)",
            f"{{seconds:.1f}} of {LEAST_ENABLED:g} s needed",
            "record a drive, with speed and steering angle throughout",
        ),
        Fact(
            "misfit",
            "the parameters do not fit this car: the innovations are {ratio:.1f} times as large as the estimator "
            "expects",
            "the parameters do not fit this car",
            "give a vehicle file that fits this car: mass, stiffness and noise of the sensors{steering}",
        ),
        Fact(
            "band",
            "the 95 % band contains the recorded truth for only {share:.0f} % of the time: parameters of the vehicle "
            "file or offsets of sensors are wrong by more than the band covers",
            "the band misses the recorded truth",
            "use the error as the uncertainty, or fit stiffness and friction of the vehicle file to the truth and "
            "calibrate the sensors",
        ),
        Fact(
            "lost",
            "the filter diverged and restarted {restarts} times: signals or parameters do not fit this car",
            "the filter diverged {restarts} times",
            "check scale, unit and time stamps of yaw rate, lateral acceleration and speed in the channel map; if "
            "they are right, give a vehicle file that fits this car: mass, stiffness, friction and noise of the "
            "sensors",
        ),
        replace(
            defect(
                ("yaw_rate",),
                "the yaw rate has an offset of {offset} degrees per second, shown by its mean {shown_by}",
                "yaw_rate has an offset",
            ),
            name="offset",
            action="calibrate the yaw rate sensor, or subtract its offset in the channel map, and judge again",
        ),
    )
}
"""Sentences of the findings, by case."""


def obstacle(
    drive: SideslipDrive, needs_torque: bool, torque_known: bool, mirrored: bool = False
) -> tuple[Status, Fact] | None:
    """Why no statement is possible; None where one is.

    Args:
        needs_torque: whether the estimator cannot run without the torque of the steering
        torque_known: whether the vehicle file converts the motor's torque into it
    """
    if mirrored:
        return Status.NOT_TESTABLE, CASES["mirrored"]
    if turned := drive.sensors.turned():
        return Status.NOT_TESTABLE, CASES["sign"].filled(names=" or ".join(turned))
    if wrong := drive.sensors.wrong_unit():
        signal = "yaw_rate" if "yaw rate is" in wrong else "lateral_acceleration, yaw_rate or speed"
        return Status.NOT_TESTABLE, CASES["unit"].filled(cause=wrong, signal=signal)
    if not drive.angles:
        return Status.NOT_AVAILABLE, CASES["no angle"]
    if needs_torque and not (drive.torques and torque_known):
        missing = "motor_torque or motor_current" if torque_known else "gearhead_ratio in the vehicle file"
        return Status.NOT_AVAILABLE, CASES["no torque"].filled(missing=missing)
    if drive.seconds < LEAST_ENABLED:
        name = "walking pace" if 0.0 < drive.fastest <= WALKING else "too short"
        return Status.NOT_ENABLED, CASES[name].filled(fastest=drive.fastest, seconds=drive.seconds)
    return None


def judge(drive: SideslipDrive, name: str, misfit_rule: Detector, nis: float, restarted: int = 0) -> Verdict:
    """The verdict where the sideslip was estimated.

    Args:
        nis: mean NIS per reading
        restarted: number of restarts of the filter, where they are too many
    """
    evidence = {**drive.evidence(), **drive.beside_truth(), "nis_mean": nis}
    peak = drive.motions.largest
    estimate = Estimate("largest sideslip angle at the centre of gravity", peak.value, peak.deviation, "rad")
    details = [f"estimated for {drive.seconds:.0f} s", *_geometry(peak)]
    because, decided_by = [Fact("estimated", "", action="none")], []
    status = Status.CONSISTENT if drive.compared >= LEAST_COMPARED else Status.ESTIMATED
    misfits = alarms_at(misfit_rule, math.log(max(nis, 1e-12)) / USUAL_MISFIT)
    if status is Status.CONSISTENT and evidence["truth_within_band_share"] < LEAST_COVERAGE and not misfits:
        status = Status.INCONSISTENT
        because = [CASES["band"].filled(share=100.0 * evidence["truth_within_band_share"])]
        error = math.degrees(evidence["error_against_truth_rms_rad"])
        details.append(f"the error is {error:.2f} degrees (root mean square)")
        decided_by = [BAND_DECISION.name]
    if restarted and not misfits:
        status, because = Status.NOT_IDENTIFIABLE, [CASES["lost"].filled(restarts=restarted), *because]
    if misfits:
        steering = ", and trail, friction and inertia of the steering" if drive.torques else ""
        status, because = Status.NOT_IDENTIFIABLE, [CASES["misfit"].filled(ratio=math.sqrt(nis), steering=steering)]
    facts = [each for each in (drive.sensors.wrong_motion(),) if each is not None]
    if offset := drive.sensors.offset(drive.observables.yaw_rate_offset()):
        degrees = f"{math.degrees(offset.value):+.1f}".replace("-", "−")
        facts.insert(0, CASES["offset"].filled(offset=degrees, shown_by=offset.shown_by))
        evidence[OFFSET] = offset.value
        decided_by.append(OFFSET_DECISION.name)
    return Verdict(
        name, status, tuple(because), estimate, evidence=evidence, details=tuple(details), decided_by=tuple(decided_by),
        facts=tuple(facts),
    )  # fmt: skip


def _geometry(peak: Largest) -> list[str]:
    """Detail on an angle that is mostly the geometry of a tight turn; none for one that the tyres make."""
    tyres = abs(peak.value - peak.geometry)
    if abs(peak.geometry) < LARGE_GEOMETRY or tyres > 0.5 * abs(peak.geometry):
        return []
    return [f"most of it is the geometry of a tight turn at {3.6 * peak.speed:.0f} km/h"]


def confirmed(verdict: Verdict, drive: SideslipDrive) -> bool:
    """Whether the band contains a recorded truth for enough of the time."""
    share = verdict.evidence.get("truth_within_band_share", 0.0)
    return share >= LEAST_COVERAGE and drive.compared >= LEAST_COMPARED


def distances(verdict: Verdict) -> dict[str, float]:
    """Statistics of the decisions that are taken once per recording, by name of the decision."""
    evidence = verdict.evidence
    found = {MISFIT_DECISION.name: math.log(max(evidence["nis_mean"], 1e-12)) / USUAL_MISFIT}
    if OFFSET in evidence:
        found[OFFSET_DECISION.name] = evidence[OFFSET] / USUAL_OFFSET
    if "truth_within_band_share" in evidence:
        found[BAND_DECISION.name] = evidence["truth_within_band_share"]
    return found | {SIGNALS_DECISION.name: evidence[SIGNALS], FILE_DECISION.name: evidence[FILE]}
