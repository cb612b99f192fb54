"""The finding over a drive: the driver's hands, and the agreement of the column with the vehicle file."""

from __future__ import annotations

import math

from tierod.core.findings import Estimate, Finding, Status
from tierod.monitors.driver_torque.contradicting import described
from tierod.monitors.driver_torque.decisions import DOUBTED, MOTOR_INERTIA_SPREAD, FitRules, misfit
from tierod.monitors.driver_torque.drive import Drive
from tierod.monitors.driver_torque.misfits import distances, innovations_of, is_late, is_zeroed, misfits, suspected
from tierod.vehicles import Vehicle
from tierod.vehicles.uncertain import torque_gain_deviation

LEAST_READY = 5.0
"""Least time with a known torque for a finding [s]; some seconds of every state."""
STILL_TORQUE, STILL_ANGLE = 0.1, math.radians(0.5)
"""Ranges of torque [N*m] and angle [rad] below which the wheel stood still; noise and rounding of its sensors."""
LOCKED_TORQUE = 5.0
"""Range of the bar's torque above which a still wheel is locked rather than held by hands [N m]."""
LONG_OFF = 5.0
"""Duration above which stretches without hands are listed one by one [s]; driver assistance warns there or later."""
MOST_LISTED = 20
"""Largest number of listed stretches, the longest ones."""
UNCHECKED = (
    "without motor_angle_mechanical gain and offset of driver_torque and of steering_wheel_angle are not checked"
)
UNSIGNED = "without motor_torque and motor_angle_mechanical the sign of driver_torque is not checked"


def judge(drive: Drive, vehicle: Vehicle, name: str, rules: FitRules, remarks: tuple[str, ...] = ()) -> Finding:
    """The finding over a drive.

    Args:
        drive: results of the drive
        vehicle: vehicle of the column
        name: name of monitor and variant
        rules: rules on the agreement of vehicle file and recording
        remarks: notices on the adaptation of the observer
    """
    evidence = _evidence(drive, vehicle, rules)
    if reason := _obstacle(drive):
        status, cause, action = reason
        headline = f"Torque of the driver's hands: {status.value}; {cause}."
        return Finding(name, status, headline, evidence=evidence, cause=cause, action=action)
    if wrong := misfits(drive, vehicle, rules):
        cause = "; ".join((*wrong, *suspected(drive, wrong)))
        action = (
            "correct the vehicle file, or identify the column; if the file is right, check gain and delay of the "
            "sensors"
        )
        headline = f"Torque of the driver's hands: withheld; vehicle file and recording do not fit: {cause}."
        notice = ("the torque of the hands, and when they were on the wheel, are withheld", *remarks)
        decided_by = tuple(name for name, distance in distances(drive, vehicle).items() if rules.beyond(name, distance))
        return Finding(
            name, Status.INCONSISTENT, headline, evidence=evidence, cause=cause, action=action, warnings=notice,
            decided_by=decided_by,
        )  # fmt: skip
    evidence |= _value(drive)
    estimate, gain = None, torque_gain_deviation(vehicle)  # without a deviation there is no interval
    if drive.hand_deviation > 0.0:
        whole = math.hypot(drive.hand_deviation, gain.value * drive.hand_rms)
        assumed, given = gain.parts(drive.hand_rms)
        quantity = "torque of the driver's hands, rms"
        estimate = Estimate(quantity, drive.hand_rms, whole, "N*m", assumed=assumed, given=given)
    notices = _notices(drive, vehicle, rules)
    action = "correct the vehicle file before the disturbance torque is used" if notices else "none"
    notices += (*remarks, *_doubts(drive))
    notices += _unchecked(drive)
    if drive.contradiction is not None and drive.contradiction.names:
        notices += (described(drive.contradiction),)
    status = Status.CONSISTENT
    if drive.contradiction is None or drive.contradiction.names:
        status = Status.ESTIMATED
    return Finding(
        name, status, _headline(drive, estimate, gain.value), None, estimate, evidence, action=action, warnings=notices
    )


def _notices(drive: Drive, vehicle: Vehicle, rules: FitRules) -> tuple[str, ...]:
    """Defects of the vehicle file that hardly affect the torque of the hands."""
    if drive.motor_inertia is None or not is_zeroed(vehicle) or "motor_inertia" not in vehicle:
        return ()
    gear = vehicle["gear_inertia"] / vehicle["motor_ratio"] ** 2 if "gear_inertia" in vehicle else 0.0
    expected = vehicle["motor_inertia"] + gear
    if not rules.apart(math.log(drive.motor_inertia / expected), MOTOR_INERTIA_SPREAD):
        return ()
    return (
        f"motor_inertia with that of the gear is {expected:.2g} kg·m² at the motor's shaft, but the recording shows "
        f"{drive.motor_inertia:.2g}; the disturbance torque is wrong by as much, the torque of the hands hardly "
        "affected",
    )


def _doubts(drive: Drive) -> tuple[str, ...]:
    """Notice that the observer is overconfident, though not by so much that the torque is withheld."""
    if not drive.nis > 0.0 or misfit(drive.nis) <= DOUBTED:
        return ()
    return (
        f"{innovations_of(drive)} are {math.sqrt(drive.nis):.1f} times as large as the observer expects: the standard "
        "deviation of the torque of the hands may be too small by this factor",
    )


def _unchecked(drive: Drive) -> tuple[str, ...]:
    """Properties of the signals that the recording cannot reveal."""
    if drive.contradiction is not None:
        return ()
    return (UNCHECKED,) if drive.motor else (*(drive.doubts or (UNSIGNED,)), UNCHECKED)


def _headline(drive: Drive, estimate: Estimate | None, gain: float) -> str:
    share = drive.on / drive.ready if drive.ready > 0.0 else 0.0
    longest = max((each.duration for each in drive.stretches), default=0.0)
    unsure = f", {drive.uncertain / drive.ready:.0%} uncertain" if drive.uncertain > 0.005 * drive.ready else ""
    off = f"off for {longest:.1f} s at the longest" if longest > 0.0 else "never off"
    known_to = "" if estimate is None else f" ± {estimate.standard_deviation:.2f}"
    included = "" if estimate is None else f" (torque gain ± {100.0 * gain:.2g} % included)"
    # With the same share of the gain, which scales every torque alike.
    peak_deviation = math.hypot(drive.peak_deviation, gain * drive.peak)
    peak_known_to = "" if estimate is None else f" ± {peak_deviation:.2f}"
    torque = f"they give {drive.hand_rms:.2f}{known_to} N·m rms{included}"
    torque += f", up to {abs(drive.peak):.2f}{peak_known_to} N·m"
    return f"Hands on the wheel {share:.0%} of the time, {off}{unsure}; {torque}."


def _value(drive: Drive) -> dict[str, float]:
    """Evidence on the hands, where vehicle file and recording agree."""
    found = {
        "hands_on_s": drive.on,
        "hands_off_s": drive.off,
        "hands_uncertain_s": drive.uncertain,
        "longest_hands_off_s": max((each.duration for each in drive.stretches), default=0.0),
        "hands_off_stretches": float(len(drive.stretches)),
        "hand_torque_rms_Nm": drive.hand_rms,
        "hand_torque_peak_Nm": drive.peak,
    }
    if math.isfinite(drive.error):
        found["error_against_truth_rms_Nm"] = drive.error
    long = sorted((each for each in drive.stretches if each.duration > LONG_OFF), key=lambda each: -each.duration)
    for number, each in enumerate(sorted(long[:MOST_LISTED]), start=1):
        found[f"hands_off_{number}_from_s"] = each.start
        found[f"hands_off_{number}_for_s"] = each.duration
    return found


def _evidence(drive: Drive, vehicle: Vehicle, rules: FitRules) -> dict[str, float]:
    """Evidence on signals and innovations, whether or not the torque of the hands is stated."""
    found = {
        "ready_s": drive.ready,
        "torsion_bar_torque_span_Nm": drive.torque_span,
        "steering_wheel_angle_span_rad": drive.angle_span,
        "learnt_torque_offset_Nm": drive.torque_offset,
        "learnt_inertia_error_kgm2": drive.inertia_error,
    }
    if math.isfinite(drive.nis):
        found["nis_mean"] = drive.nis
    if drive.geometry is not None:
        found["motor_ratio_in_recording"] = drive.geometry.ratio
        found["stiffness_in_recording_Nm_per_rad"] = drive.geometry.stiffness
        if is_zeroed(vehicle):
            found["torque_offset_in_recording_Nm"] = drive.geometry.torque_offset
        if is_late(drive, vehicle, rules):
            found[f"{drive.geometry.late}_lag_s"] = drive.geometry.lag
    return found


def _obstacle(drive: Drive) -> tuple[Status, str, str] | None:
    """Why no statement is possible: status, cause, action; None where one is possible."""
    if drive.turned:
        return Status.NOT_TESTABLE, "; ".join(drive.turned), "correct the channel map and judge the recording again"
    if drive.ready < LEAST_READY:
        cause = f"the driver torque could be estimated for {drive.ready:.1f} s only; {LEAST_READY:g} s are needed"
        return Status.NOT_ENABLED, cause, "record longer, with steering_wheel_angle and driver_torque throughout"
    if drive.torque_span < STILL_TORQUE and drive.angle_span < STILL_ANGLE:
        cause = (
            f"the wheel stood still: its angle changed by {math.degrees(drive.angle_span):.2f} degrees, the torque of "
            f"the bar by {drive.torque_span:.2f} N·m"
        )
        return Status.NOT_ENABLED, cause, "record a drive, or let the motor turn the column"
    if drive.torque_span > LOCKED_TORQUE and drive.angle_span < STILL_ANGLE:
        cause = (
            f"the wheel was locked: its angle changed by {math.degrees(drive.angle_span):.2f} degrees, the torque of "
            f"the bar by {drive.torque_span:.0f} N·m"
        )
        return Status.NOT_ENABLED, cause, "record with the wheel free or in a driver's hands"
    return None
