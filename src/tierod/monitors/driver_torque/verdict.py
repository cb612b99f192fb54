"""What a drive says of the driver's hands, and of the column that a vehicle file describes."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from tierod.findings import Estimate, Finding, Status
from tierod.monitors.driver_torque.contradicting import Contradiction, described
from tierod.monitors.driver_torque.decisions import (
    COLUMN,
    INERTIA_SPREAD,
    INNOVATIONS,
    LAG_SPREAD,
    MOTOR_INERTIA_SPREAD,
    OFFSET_SPREAD,
    RATIO_SPREAD,
    STIFFNESS_SPREAD,
    FitRules,
    misfit,
)
from tierod.monitors.driver_torque.geometry import ColumnGeometry
from tierod.monitors.driver_torque.stretches import Stretch
from tierod.monitors.driver_torque.vehicle_column import usual_tuning
from tierod.vehicles import Vehicle

LEAST_READY = 5.0
"""Time for which the torque must be known before anything is concluded [s]: some seconds of every state."""
STILL_TORQUE, STILL_ANGLE = 0.1, math.radians(0.5)
"""A bar and a wheel that change by less tell nothing of hands: noise and rounding of production sensors."""
LOCKED_TORQUE = 5.0
"""Span of the bar's torque under which no hands keep a wheel still; a lock does [N m]."""
LONG_OFF = 5.0
"""Hands off for longer are listed one by one [s]: driver assistance begins to warn there, or later."""
MOST_LISTED = 20
"""Of those stretches, the longest ones."""
DEGREES, UNIT_MARGIN = math.degrees(1.0), 0.1
"""An angle in degrees that is read as radians, and how close to that factor, in its logarithm, a ratio must be."""

UNNAMED = "the innovations"
"""Begins the sentence of a misfit that names no parameter."""
NO_THIRD = "steering_wheel_angle or driver_torque may be wrong; motor_angle_mechanical would show which"
UNCHECKED = (
    "without motor_angle_mechanical gain and offset of driver_torque and of steering_wheel_angle are not checked"
)


class Drive(NamedTuple):
    """What was collected over a drive.

    Args:
        ready, off, on, uncertain: time for which the torque was known, and of these of each state
        hand_rms, hand_deviation: of the hands' torque, and what the observer says of its own error
        peak, peak_deviation: greatest torque of the hands
        error: of the torque against the truth of a simulation; NaN where there is none
        torque_span, angle_span: least to greatest of bar and wheel
        nis: mean per measurement; NaN where the observer tells none
        sample_time: between two samples
        inertia_error, torque_offset: as learnt without hands
        geometry: what angles and torque say of the column
        motor_inertia: with the gear's at the motor's shaft, as torques and acceleration tell it; None where they do not
        turned: a sentence for every signal whose sign is wrong
        stretches: without hands
        contradiction: what of the bar's three signals contradicts the others; None where they do not say
        motor: signal that the motor's torque was taken from; empty where there was none
    """

    ready: Annotated[float, "s"]
    off: Annotated[float, "s"]
    on: Annotated[float, "s"]
    uncertain: Annotated[float, "s"]
    hand_rms: Annotated[float, "N*m"]
    hand_deviation: Annotated[float, "N*m"]
    peak: Annotated[float, "N*m"]
    peak_deviation: Annotated[float, "N*m"]
    error: Annotated[float, "N*m"]
    torque_span: Annotated[float, "N*m"]
    angle_span: Annotated[float, "rad"]
    nis: Annotated[float, ""]
    sample_time: Annotated[float, "s"]
    inertia_error: Annotated[float, "kg*m**2"]
    torque_offset: Annotated[float, "N*m"]
    geometry: ColumnGeometry | None
    motor_inertia: Annotated[float | None, "kg*m**2"]
    turned: tuple[str, ...]
    stretches: tuple[Stretch, ...]
    contradiction: Contradiction | None = None
    motor: str = ""


def judge(drive: Drive, vehicle: Vehicle, name: str, rules: FitRules) -> Finding:
    """The finding over a drive.

    Args:
        drive: what was collected
        vehicle: whose column it is
        name: of monitor and variant
        rules: whether vehicle file and recording fit
    """
    evidence = _evidence(drive, vehicle, rules)
    if reason := _obstacle(drive):
        status, cause, action = reason
        headline = f"Torque of the driver's hands: {status.value}; {cause}."
        return Finding(name, status, headline, evidence=evidence, cause=cause, action=action)
    if wrong := _misfits(drive, vehicle, rules):
        cause = "; ".join((*wrong, *_suspected(drive, wrong)))
        action = "correct the vehicle file, or identify the column; if it is right, look for a sensor's gain or delay"
        headline = f"Torque of the driver's hands: withheld; vehicle file and recording do not fit: {cause}."
        notice = ("the torque of the hands, and when they were on the wheel, are withheld",)
        decided_by = tuple(name for name, distance in distances(drive, vehicle).items() if rules.beyond(name, distance))
        return Finding(
            name, Status.SUSPECT, headline, evidence=evidence, cause=cause, action=action, warnings=notice,
            decided_by=decided_by,
        )  # fmt: skip
    evidence |= _value(drive)
    estimate = None  # what has no deviation has no interval
    if drive.hand_deviation > 0.0:
        estimate = Estimate("torque of the driver's hands, rms", drive.hand_rms, drive.hand_deviation, "N*m")
    notices = _notices(drive, vehicle, rules)
    action = "correct the vehicle file before the disturbance torque is used" if notices else "none"
    notices += () if drive.contradiction is not None else (UNCHECKED,)
    return Finding(name, Status.HEALTHY, _told(drive), None, estimate, evidence, action=action, warnings=notices)


def distances(drive: Drive, vehicle: Vehicle) -> dict[str, float]:
    """By the name of the decision, how far the recording is from the vehicle file [standard deviations]."""
    furthest = max(_departures(drive, vehicle).values(), key=abs)
    innovations = {INNOVATIONS: misfit(drive.nis)} if drive.nis > 0.0 else {}
    return {COLUMN: furthest} | innovations


def _departures(drive: Drive, vehicle: Vehicle) -> dict[str, float]:
    """How far every value of the column is from that of the vehicle file [standard deviations]."""
    apart = {"inertia": drive.inertia_error / (INERTIA_SPREAD * vehicle["steering_wheel_inertia"])}
    if (found := drive.geometry) is None:
        return apart
    apart["ratio"] = (found.ratio / vehicle["motor_ratio"] - 1.0) / RATIO_SPREAD
    apart["lag"] = found.lag / LAG_SPREAD if abs(found.lag) > drive.sample_time else 0.0
    bar = found.stiffness / vehicle["torsion_bar_stiffness"]
    apart["stiffness"] = math.log(bar) / STIFFNESS_SPREAD if bar > 0.0 else -math.inf
    if _zeroed(vehicle):
        apart["offset"] = (found.torque_offset - drive.torque_offset) / OFFSET_SPREAD
    return apart


def _notices(drive: Drive, vehicle: Vehicle, rules: FitRules) -> tuple[str, ...]:
    """What is wrong in the vehicle file without touching the torque of the hands."""
    if drive.motor_inertia is None or not _zeroed(vehicle) or "motor_inertia" not in vehicle:
        return ()
    gear = vehicle["gear_inertia"] / vehicle["motor_ratio"] ** 2 if "gear_inertia" in vehicle else 0.0
    expected = vehicle["motor_inertia"] + gear
    if not rules.apart(math.log(drive.motor_inertia / expected), MOTOR_INERTIA_SPREAD):
        return ()
    return (
        f"motor_inertia, with the gear's, is {expected:.2g} kg·m² at the motor's shaft, but the motor turns as with "
        f"{drive.motor_inertia:.2g}; the disturbance torque is wrong by as much, the torque of the hands hardly",
    )


def _told(drive: Drive) -> str:
    share = drive.on / drive.ready if drive.ready > 0.0 else 0.0
    longest = max((each.duration for each in drive.stretches), default=0.0)
    unsure = f", {drive.uncertain / drive.ready:.0%} uncertain" if drive.uncertain > 0.005 * drive.ready else ""
    off = f"off for {longest:.1f} s at the longest" if longest > 0.0 else "never off"
    known_to = f" ± {drive.hand_deviation:.2f}" if drive.hand_deviation > 0.0 else ""
    torque = f"they give {drive.hand_rms:.2f}{known_to} N·m rms, {abs(drive.peak):.1f} N·m at most"
    return f"Hands on the wheel {share:.0%} of the time, {off}{unsure}; {torque}."


def _value(drive: Drive) -> dict[str, float]:
    """What is told of the hands, where it can be believed."""
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
    """What the signals and the innovations show, whether or not the torque of the hands can be told."""
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
        if _zeroed(vehicle):
            found["torque_offset_in_recording_Nm"] = drive.geometry.torque_offset
        if _late(drive, vehicle, rules):
            found[f"{drive.geometry.late}_lag_s"] = drive.geometry.lag
    return found


def _zeroed(vehicle: Vehicle) -> bool:
    """Whether somebody has set the angles to zero on the unloaded bar, so that they tell the offset of its torque."""
    return usual_tuning(vehicle).offset is None


def _obstacle(drive: Drive) -> tuple[Status, str, str] | None:
    """Why nothing can be told: status, cause, what to do; None where something can."""
    if drive.turned:
        return Status.NOT_TESTABLE, "; ".join(drive.turned), "correct the channel map and judge the recording again"
    if drive.ready < LEAST_READY:
        cause = f"the torque was known for {drive.ready:.1f} s, {LEAST_READY:g} s are needed"
        return Status.NOT_ENABLED, cause, "record longer, with angle and torque throughout"
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
        return Status.NOT_ENABLED, cause, "record with a wheel that is free or in a driver's hands"
    return None


def _misfits(drive: Drive, vehicle: Vehicle, rules: FitRules) -> list[str]:
    """What of the vehicle file the data contradicts."""
    if unit := _wrong_unit(drive, vehicle):
        return [unit]
    if _late(drive, vehicle, rules):
        return _misshapen(drive, vehicle, rules)
    wrong = []
    inertia = vehicle["steering_wheel_inertia"]
    if rules.apart(_departures(drive, vehicle)["inertia"], 1.0):
        there = inertia + drive.inertia_error
        wrong.append(
            f"steering_wheel_inertia is {inertia:.3g} kg·m², but without hands the wheel moves as with {there:.3g}"
        )
    wrong += _misshapen(drive, vehicle, rules)
    if rules.misfit(drive.nis) and (drive.geometry is None or not wrong):
        wrong.append(
            f"{UNNAMED} are {math.sqrt(drive.nis):.0f} times as large as the observer expects; a signal may be "
            "late, have an offset or the wrong sign, or motor_inertia, gear_stiffness or the sensors' noise be off"
        )
    return wrong


def _suspected(drive: Drive, wrong: list[str]) -> tuple[str, ...]:
    """Which signal may be wrong in place of the vehicle file."""
    found = drive.contradiction
    if found is None:
        return (NO_THIRD,)
    if found.names:
        return (described(found),)
    if drive.motor and all(each.startswith(UNNAMED) for each in wrong):
        return (f"the angles and the torque of the bar fit each other, so that {drive.motor} is suspected",)
    return ()


def _misshapen(drive: Drive, vehicle: Vehicle, rules: FitRules) -> list[str]:
    """What angles and torque of the bar contradict; a late one spoils what they say of bar and offset."""
    found = drive.geometry
    if found is None:
        return []
    wrong = []
    ratio, bar = vehicle["motor_ratio"], vehicle["torsion_bar_stiffness"]
    apart = _departures(drive, vehicle)
    if rules.apart(apart["ratio"], 1.0):
        wrong.append(f"motor_ratio is {ratio:.4g}, but the angles go by {found.ratio:.4g}")
    if _late(drive, vehicle, rules):
        others = "the others" if found.lag > 0.0 else "both others, which may themselves be late"
        when = "late" if found.lag > 0.0 else "early"
        return [*wrong, f"{found.late} is some {1e3 * abs(found.lag):.0f} ms {when} against {others}"]
    if rules.apart(apart["stiffness"], 1.0):
        wrong.append(f"torsion_bar_stiffness is {bar:.3g} N·m/rad, but the bar twists as with {found.stiffness:.3g}")
    elif rules.apart(apart.get("offset", 0.0), 1.0):
        offset, turn = found.torque_offset, math.degrees(abs(found.torque_offset) / found.stiffness)
        way = "high" if offset > 0.0 else "low"
        wrong.append(
            f"driver_torque is {abs(offset):.2f} N·m too {way} for the twist of the bar (or steering_wheel_angle and "
            f"motor_angle_mechanical, which should agree on the unloaded bar, differ by {turn:.2f} degrees); correct "
            "the offset in the channel map"
        )
    return wrong


def _late(drive: Drive, vehicle: Vehicle, rules: FitRules) -> bool:
    """Whether a signal is late beyond its sampling, and the observer does not get along with it."""
    unfit = math.isnan(drive.nis) or rules.misfit(drive.nis)
    if drive.geometry is None or not unfit:
        return False
    return rules.apart(_departures(drive, vehicle)["lag"], 1.0)


def _wrong_unit(drive: Drive, vehicle: Vehicle) -> str:
    """The sentence for an angle in degrees that passes for radians, or the other way round; "" for none."""
    if drive.geometry is None:
        return ""
    factor = drive.geometry.ratio / vehicle["motor_ratio"]
    if abs(abs(math.log(factor)) - math.log(DEGREES)) > UNIT_MARGIN:
        return ""
    larger, smaller = "motor_angle_mechanical", "steering_wheel_angle"
    if factor < 1.0:
        larger, smaller = smaller, larger
    return (
        f"{larger} is {DEGREES:.1f} times too large against {smaller} for a motor_ratio of "
        f"{vehicle['motor_ratio']:.4g}: one of them has degrees and radians mistaken"
    )
