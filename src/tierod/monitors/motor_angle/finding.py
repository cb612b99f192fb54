"""The finding over a drive: the sensor of a motor's angle, and defects of the recording."""

from __future__ import annotations

import math
from dataclasses import replace

from tierod.core.findings import Estimate, Finding, Status
from tierod.monitors.motor_angle.alarms import ALARMS, BY_NAME
from tierod.monitors.motor_angle.drive import Drive, InverterLoss
from tierod.monitors.motor_angle.signals import IN_WORDS, MEASURED
from tierod.monitors.motor_angle.voltage_balance import FITS
from tierod.monitors.motor_angle.which_angle import MOTOR, NOT_MOTOR, PINION, WHEEL
from tierod.vehicles import Vehicle

LEAST_KNOWN = 1.0
"""Least time with a turning motor for a healthy sensor [s]."""

LEAST_WINDOWS = 30
"""Least number of 10 ms windows for the scale of the angle."""

AGREEMENT = 0.98
"""Correlation of the increments of sensor and observer from which a wrong scale is an error of the recording or file,
not a fault."""

SCALE_MARGIN = 0.1
"""Relative tolerance within which a scale is attributed to a number of pole pairs, which are whole numbers."""

FIVE_DEGREES = math.radians(5.0)

TOGETHER = 1.0
"""Time within which alarms have one root cause [s]."""

DISTURBING = ("stuck", "backwards", "electrical.resolver_mismatch", "electrical.angle_gradient", "not_following")
"""Sensor faults that disturb the observer: the drive stalls, as with swapped currents, or the angle leaps while the
motor is slow and its increments count."""

PASSING = 0.05
"""Share of surprising innovations since `model` alarmed, below which the motor's model was valid again at once."""

ONCE = (
    "currents, voltages and the changes of the angle contradicted each other for a moment, and agree again",
    "check whether the zero of the angle sensor jumped while the motor was slow; then the motor's flux and resistance",
)
"""Cause and action of `model` where the contradiction has passed."""

SENSOR_ALONE = (
    "the motor's angle contradicts currents and voltages, which fit each other",
    "check the sensor and its line: sign, noise, and the unit of motor_angle_mechanical in the channel map",
)
"""Cause and action of `model` where the induced voltage rotates as its magnitude requires."""

UNSETTLED = (
    "the angle sensor differs from the angle that currents and voltages give, and these contradict each other too: "
    "either may be wrong",
    "check sign, gain and phases of currents and voltages, and the sensor's magnet and its zero",
)
"""Cause and action of `angle` and `speed` where the induced voltage rotates otherwise than its magnitude requires."""

CONFIRMED = (
    "the motor's angle stays away from target_motor_angle_mechanical, though currents and voltages confirm the "
    "sensor: the target is not the one that the motor follows, or the motor cannot follow it",
    "check sign and scale of the target in the channel map, and its time stamps; then the control and the load of the "
    "motor",
)
"""Cause and action of `not_following` where the sensor turns as the currents indicate."""

UNTWISTED = (
    "the angles of motor, steering wheel and pinion are not compared: without driver_torque the twist of the torsion "
    "bar between them is unknown"
)

MOST_TORQUE = 10.0
"""Upper bound of a plausible driver's torque [N m]; power steering keeps it below 5."""

SUSPECTS = {
    MOTOR: "the motor's angle",
    WHEEL: "the steering wheel's angle",
    PINION: "the pinion's angle",
    NOT_MOTOR: "the steering wheel's angle or the pinion's, not the motor's,",
}

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
    untwisted = (UNTWISTED,) if drive.untwisted else ()
    remarks = inverter_remarks(drive.lost, drive.voltages)
    return replace(finding, warnings=(*finding.warnings, *untwisted, *remarks))


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
    estimate = None
    if drive.counted:
        estimate = Estimate(
            "difference of the motor's angle sensor from the angle that its currents give, electrical",
            drive.offset,
            drive.offset_deviation,
            "rad",
            {"smallest offset worth an alarm": FIVE_DEGREES},
        )
    if drive.starts:
        return _fault(drive, vehicle, estimate, evidence)
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
        f"{math.degrees(drive.rms):.1f}° electrical rms from the angle that currents and "
        f"{'voltages' if drive.lost is None else 'commanded voltages'} give."
    )
    return Finding(drive.monitor, Status.HEALTHY, headline, None, estimate, evidence, action="none")


def root_of(drive: Drive) -> str | None:
    """The alarm from which the others follow; None without any.

    A contradiction of currents and voltages persists, whereas a sensor that stalls the drive, or leaps, disturbs the
    observer only once.
    """
    if not drive.starts:
        return None
    first = min(drive.starts.values())
    together = [each.name for each in ALARMS if drive.starts.get(each.name, math.inf) <= first + TOGETHER]
    disturbing = [name for name in together if name in DISTURBING]
    if together[0] == "model" and disturbing and drive.surprised < 0.5:
        return disturbing[0]
    return together[0]


def _fault(drive: Drive, vehicle: Vehicle, estimate: Estimate | None, evidence: dict[str, float]) -> Finding:
    root = root_of(drive)
    assert root is not None
    cause, action = _cause_of(root, drive)
    if root == "plausibility":
        cause += f"; {SUSPECTS.get(drive.suspect, 'which of them is wrong')}" + (
            " is the wrong one" if drive.suspect else " cannot be decided"
        )
        cause += _or_torque(drive, vehicle)
    if root == "model" and math.isfinite(drive.resistance * drive.flux) and cause == BY_NAME[root].cause:
        cause += (
            f"; they fit {drive.resistance:.2f} times the resistance and {drive.flux:.2f} times the flux of the "
            "vehicle file"
        )
    # The difference from the observer is the magnitude of the fault only where it decided.
    unsettled = (cause, action) == UNSETTLED
    decided = root == "angle" and not unsettled
    magnitude = estimate if decided else None
    by = f" by {math.degrees(drive.offset):+.1f}° electrical" if decided else ""
    since = drive.starts[root]
    headline = f"{cause[0].upper()}{cause[1:]}{by}, since {since:.2f} s."
    return Finding(
        drive.monitor,
        Status.SUSPECT if unsettled else Status.FAULT,
        headline,
        since,
        magnitude,
        evidence,
        cause,
        action,
        decided_by=(BY_NAME[root].decision,),
    )


def _cause_of(root: str, drive: Drive) -> tuple[str, str]:
    """Cause and action of the root alarm."""
    if root == "model" and drive.surprised < PASSING:
        return ONCE
    if root == "model" and drive.voltages == MEASURED and drive.contradicting < FITS:
        return SENSOR_ALONE
    if root in ("angle", "speed") and drive.voltages == MEASURED and drive.contradicting > FITS:
        return UNSETTLED
    confirmed = drive.known >= LEAST_KNOWN and drive.rms < FIVE_DEGREES
    if root == "not_following" and confirmed and set(drive.starts) <= {root, "plausibility"}:
        return CONFIRMED
    return BY_NAME[root].cause, BY_NAME[root].action


def _or_torque(drive: Drive, vehicle: Vehicle) -> str:
    """The driver's torque as an alternative cause: it gives the twist of the bar between wheel and pinion."""
    if drive.suspect not in (NOT_MOTOR, 0.0) or not drive.mismatch > 0.0:
        return ""
    torque = drive.mismatch * vehicle["torsion_bar_stiffness"] / vehicle["superposition_input_ratio"]
    if torque > MOST_TORQUE:
        return ""
    return f", or driver_torque is off by up to {torque:.1f} N·m, so that the twist of the torsion bar is wrong"


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
