"""The finding over a drive: the sensor of a motor's angle, and defects of the recording."""

from __future__ import annotations

import math
from dataclasses import replace

from tierod.core.findings import Episode, Estimate, Finding, Status
from tierod.monitors.motor_angle.alarms import ALARMS, BY_NAME
from tierod.monitors.motor_angle.causes import (
    FIVE_DEGREES,
    LEAST_KNOWN,
    UNDECIDED,
    accused_by,
    cause_of,
    onset_of,
    root_of,
)
from tierod.monitors.motor_angle.drive import COMPARED, Drive, InverterLoss
from tierod.monitors.motor_angle.residual_shape import DRIFT, GAIN, NOISE, RIPPLE, SCATTER, Shape
from tierod.monitors.motor_angle.signals import IN_WORDS
from tierod.vehicles import Vehicle

LEAST_WINDOWS = 30
"""Least number of 10 ms windows for the scale of the angle."""

AGREEMENT = 0.98
"""Correlation of the increments of sensor and observer from which a wrong scale is an error of the recording or file,
not a fault."""

SCALE_MARGIN = 0.1
"""Relative tolerance within which a scale is attributed to a number of pole pairs, which are whole numbers."""

UNTWISTED = (
    "the angles of motor, steering wheel and pinion are not compared: without driver_torque the twist of the torsion "
    "bar between them is unknown"
)

DIFFERENCE = "difference of the motor's angle sensor from the angle that its currents give, electrical"

ENDED = 1.0
"""Time without the alarm at the end of the drive from which it has ended [s]."""

KNEE_APART, KNEE_SIGMAS = 1.4, 4.0
"""Factor and number of standard deviations beyond which the knee differs from that of the vehicle file."""

NOT_THE_SENSOR = ("model", "angle", "speed", "stuck", "backwards", "not_following", "electrical.angle_gradient")
"""Alarms that a wrong recording can raise."""


def judge(drive: Drive, vehicle: Vehicle) -> Finding:
    """The finding over a drive, with remarks on the voltages behind it.

    Args:
        drive: results of the drive
        vehicle: vehicle of the motor
    """
    finding = _judged(drive, vehicle)
    remarks: tuple[str, ...] = (UNTWISTED,) if drive.untwisted else ()
    if drive.noise > drive.noise_limit and not drive.starts:
        noise, limit = math.degrees(drive.noise), math.degrees(drive.noise_limit)
        remarks += (f"the readings of the angle sensor have noise of {noise:.2f}° mechanical, above {limit:.2f}°",)
    return replace(finding, warnings=(*finding.warnings, *remarks, *inverter_remarks(drive.lost, drive.voltages)))


def _wrong_recording(drive: Drive, vehicle: Vehicle) -> tuple[str, str] | None:
    """Cause and action of an error of the recording that prevents a judgement of the sensor; None without one."""
    if wrong := _wrong_scale(drive, vehicle["motor_pole_pairs"]):
        return wrong
    suspect = root_of(drive) in NOT_THE_SENSOR or (not drive.starts and drive.known < LEAST_KNOWN)
    if drive.misread is not None and suspect:
        return drive.misread
    if drive.lost is not None and suspect:
        return knee_beyond(drive.lost)
    return None


def _judged(drive: Drive, vehicle: Vehicle) -> Finding:
    evidence = _evidence(drive)
    if wrong := _wrong_recording(drive, vehicle):
        cause, action = wrong
        headline = f"The motor's angle cannot be judged: {cause}."
        return Finding(drive.monitor, Status.NOT_TESTABLE, headline, evidence=evidence, cause=cause, action=action)
    if drive.starts:
        return _fault(drive, vehicle, evidence)
    estimate = None
    if drive.counted:
        estimate = Estimate(
            DIFFERENCE,
            drive.offset,
            drive.offset_deviation,
            "rad",
            {"smallest offset worth an alarm": FIVE_DEGREES},
        )
    if drive.known < LEAST_KNOWN:
        cause = f"the motor turned fast enough for {drive.known:.1f} s only, {LEAST_KNOWN:g} s are needed"
        headline = f"The sensor of the motor's angle was not judged: {cause}."
        action = (
            "record faster or longer steering; below about 10 rad/s at the shaft the currents do not determine the "
            "angle"
        )
        return Finding(drive.monitor, Status.NOT_ENABLED, headline, None, estimate, evidence, cause, action)
    headline = (
        f"The sensor of the motor's angle is healthy: over {drive.known:.1f} s of turning it differs by "
        f"{math.degrees(drive.offset):+z.1f} ± {math.degrees(drive.offset_deviation):.1f}° electrical from the angle "
        "that currents and "
        f"{'voltages' if drive.lost is None else 'commanded voltages'} give."
    )
    return Finding(drive.monitor, Status.HEALTHY, headline, None, estimate, evidence, action="none")


def _fault(drive: Drive, vehicle: Vehicle, evidence: dict[str, float]) -> Finding:
    root = root_of(drive)
    assert root is not None
    cause, action = cause_of(root, drive, vehicle)
    accused = accused_by(root, drive)
    # The difference from the observer is the magnitude of the fault only where it decided.
    shape = drive.shape if accused in (*COMPARED, NOISE) else None
    by = "" if shape is None else f" {shape.in_words(drive.settled)}"
    episode, seen = _episode(root, drive)
    headline = f"{cause[0].upper()}{cause[1:]}{by}, {_when(episode, seen)}."
    return Finding(
        drive.monitor,
        Status.SUSPECT if accused == UNDECIDED else Status.FAULT,
        headline,
        episode.start,
        None if shape is None else _magnitude(shape),
        evidence,
        cause,
        action,
        decided_by=(BY_NAME[root].decision,),
        declared=episode.declared,
        end=episode.end,
    )


def _magnitude(shape: Shape) -> Estimate:
    """Magnitude of a sensor's error, with a standard deviation from what its shape leaves."""
    quantity = {
        DRIFT: f"drift of {DIFFERENCE}",
        GAIN: "turn of the motor's angle sensor over that which its currents give",
        RIPPLE: f"amplitude of the ripple of {DIFFERENCE}",
        SCATTER: f"root mean square of {DIFFERENCE}",
        NOISE: "noise of the readings of the motor's angle sensor, mechanical",
    }.get(shape.kind, DIFFERENCE)
    unit = {DRIFT: "rad/s", GAIN: ""}.get(shape.kind, "rad")
    limit = {"smallest offset worth an alarm": FIVE_DEGREES} if unit == "rad" and shape.kind != NOISE else {}
    return Estimate(quantity, shape.size, shape.deviation, unit, limit)


def _episode(root: str, drive: Drive) -> tuple[Episode, bool]:
    """Onset, declaration and end of the error behind the root alarm, and whether it was seen to begin."""
    if accused_by(root, drive) == NOISE:
        lasts = drive.until - drive.end < ENDED
        onset = min(drive.onset, drive.starts[root])
        return Episode("", onset, None if lasts else drive.end, declared=drive.starts[root]), True
    onset, seen = onset_of(root, drive)
    last = drive.end if root in COMPARED else drive.spells[root].last
    # A sensor that stalls the drive, or leaps, is no longer seen by its own test.
    lasts = drive.until - max(each.last for each in drive.spells.values()) < ENDED
    return Episode("", onset, None if lasts else last, declared=drive.starts[root]), seen


def _when(episode: Episode, seen: bool) -> str:
    """Onset, end and declaration in words."""
    begin = f"{episode.start:.2f} s{'' if seen else ' at the latest'}"
    late = "" if episode.belated is None else f", declared at {episode.belated:.2f} s"
    if episode.end is None:
        return f"since {begin}{late}"
    if episode.end - episode.start < 0.01:
        return f"at {begin}"
    return f"from {begin} to {episode.end:.2f} s{late}"


def _wrong_scale(drive: Drive, pole_pairs: float) -> tuple[str, str] | None:
    """Cause and action of a scale that is wrong throughout, so that the error grows with the angle."""
    if drive.windows < LEAST_WINDOWS or drive.agreement < AGREEMENT:
        return None
    slope = drive.slope

    def near(value: float) -> bool:
        return abs(slope / value - 1.0) < SCALE_MARGIN / max(pole_pairs, 2.0)

    if pole_pairs > 1.5 and near(pole_pairs):
        cause = (
            f"the angle changes by {slope:.2f} turns per turn of the shaft: it is electrical, but named as mechanical"
        )
        return cause, "name the channel motor_angle_electrical in the channel map, or divide by the pole pairs"
    for pairs in range(1, 41):
        if abs(pairs - pole_pairs) > 0.5 and near(pole_pairs / pairs):
            cause = (
                f"the error grows with the angle: the sensor turns {slope:.3f} times as far as the observer, as with "
                f"{pairs} pole pairs, but motor_pole_pairs is {pole_pairs:g}"
            )
            return cause, "correct motor_pole_pairs in the vehicle file"
    return None


def _evidence(drive: Drive) -> dict[str, float]:
    found = {
        "turning_s": drive.known,
        "turning_share": drive.known / max(drive.seconds, 1e-9),
        "angle_residual_rms_electrical_rad": drive.rms if drive.counted else math.nan,
        "nis_mean": drive.nis,
        "sensor_turns_per_observed_turn": drive.slope,
        "sensor_noise_mechanical_rad": drive.noise,
        "smallest_named_sensor_noise_mechanical_rad": drive.noise_limit,
        "resistance_over_nominal": drive.resistance,
        "flux_over_nominal": drive.flux,
    }
    if drive.lost is not None:
        found["inverter_voltage_loss_v"] = drive.lost.voltage_loss
        found["inverter_knee_current_a"] = drive.lost.knee_current
        found["inverter_knee_over_nominal"] = math.exp(drive.lost.apart)
    found = {name: value for name, value in found.items() if math.isfinite(value)}
    for name in (each.name for each in ALARMS if each.name in drive.starts):
        found[f"{name.removeprefix('electrical.')}_alarm_from_s"] = drive.starts[name]
    return found


def inverter_remarks(lost: InverterLoss | None, voltages: str) -> tuple[str, ...]:
    """Remarks on the voltages behind a finding, and on an inverter that differs from the vehicle file.

    Args:
        lost: estimated voltage loss of the inverter; None where the voltages were measured
        voltages: source of the observer's voltages
    """
    if lost is None:
        return ()
    rests_on = (
        f"the voltages are {IN_WORDS[voltages]}: {lost.voltage_loss:.2f} V per phase, with a knee at "
        f"{lost.knee_current:.2g} A; measured voltages give the angle more accurately"
    )
    if abs(lost.apart) < max(math.log(KNEE_APART), KNEE_SIGMAS * lost.knee_deviation):
        return (rests_on,)
    wrong = (
        f"the inverter's knee is at {lost.knee_current:.2g} A, not at {lost.nominal_knee:.2g} A as in the vehicle "
        "file: correct inverter_knee_current; until the knee is learnt, the angle is less accurate"
    )
    return (rests_on, wrong)


def knee_beyond(lost: InverterLoss) -> tuple[str, str] | None:
    """Cause and action where the knee may lie outside the range that is learnt; None where it does not."""
    if not lost.beyond:
        return None
    return (
        f"the inverter's knee lies outside the range that can be learnt: {lost.knee_current:.2g} A, vehicle file "
        f"{lost.nominal_knee:.2g} A",
        "find inverter_knee_current with 'tierod identify inverter', or record the voltages",
    )
