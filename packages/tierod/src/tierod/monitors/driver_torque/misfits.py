"""Misfits between a drive and the column of a vehicle file, and their suspected causes."""

from __future__ import annotations

import math

from tierod.monitors.driver_torque.contradicting import described
from tierod.monitors.driver_torque.decisions import (
    COLUMN,
    DOUBTED,
    INERTIA_SPREAD,
    INNOVATIONS,
    LAG_SPREAD,
    OFFSET_SPREAD,
    RATIO_SPREAD,
    STIFFNESS_SPREAD,
    FitRules,
    misfit,
)
from tierod.monitors.driver_torque.drive import Drive
from tierod.monitors.driver_torque.guessed_ratio import ratio_spread
from tierod.monitors.driver_torque.tuning import usual_tuning
from tierod.vehicles import Vehicle

DEGREES, UNIT_MARGIN = math.degrees(1.0), 0.1
"""Factor between an angle in degrees and in radians, and tolerance on the logarithm of a ratio near that factor."""
UNNAMED = "the innovations"
"""Start of the sentence on a misfit that names no parameter."""
OF_ANGLES = "(motor_angle_mechanical over steering_wheel_angle)"
NO_THIRD = (
    "steering_wheel_angle or driver_torque may be wrong; motor_angle_mechanical, named in the channel map or recorded, "
    "would show which"
)


def misfits(drive: Drive, vehicle: Vehicle, rules: FitRules) -> list[str]:
    """Contradictions between the vehicle file and the data, a half-sentence each.

    Args:
        drive: results of the drive
        vehicle: vehicle of the column
        rules: rules on the agreement of vehicle file and recording
    """
    if unit := _wrong_unit(drive, vehicle):
        return [unit]
    wrong = _of_the_column(drive, vehicle, rules)
    # A slow change of a gain or zero appears as a wrong stiffness, an offset or a delay, whichever fits best.
    found = drive.contradiction
    if wrong and found is not None and found.creeps:
        return [described(found)]
    # Signals that contradict each other make large innovations suspicious that alone would only be remarked on.
    if not wrong and found is not None and found.names and drive.nis > 0.0 and misfit(drive.nis) > DOUBTED:
        return [_surprising(drive)]
    return wrong


def _of_the_column(drive: Drive, vehicle: Vehicle, rules: FitRules) -> list[str]:
    """Contradictions on the assumption that each signal had a constant gain, offset and delay."""
    if is_late(drive, vehicle, rules):
        return _misshapen(drive, vehicle, rules)
    wrong = []
    inertia = vehicle["steering_wheel_inertia"]
    if rules.apart(_departures(drive, vehicle)["inertia"], 1.0):
        there = inertia + drive.inertia_error
        wrong.append(
            f"steering_wheel_inertia is {inertia:.3g} kg·m², but the motion without hands shows {there:.3g} "
            "(driver_torque over the acceleration of steering_wheel_angle)"
        )
    wrong += _misshapen(drive, vehicle, rules)
    if rules.misfit(drive.nis) and (drive.geometry is None or not wrong):
        wrong.append(_surprising(drive))
    return wrong


def _surprising(drive: Drive) -> str:
    """Sentence on innovations that are too large."""
    return (
        f"{innovations_of(drive)} are {math.sqrt(drive.nis):.2g} times as large as the observer expects; a signal may "
        "be late, have an offset or the wrong sign, or motor_inertia, gear_stiffness or the noise of the sensors may "
        "be wrong"
    )


def innovations_of(drive: Drive) -> str:
    """The innovations with the signals that they are of."""
    third = "" if drive.contradiction is None else ", motor_angle_mechanical"
    return f"{UNNAMED} of steering_wheel_angle{third} and driver_torque"


def suspected(drive: Drive, wrong: list[str]) -> tuple[str, ...]:
    """Signals that may be wrong instead of the vehicle file, as half-sentences.

    Args:
        drive: results of the drive
        wrong: result of `misfits`
    """
    found = drive.contradiction
    if found is None:
        return (NO_THIRD,)
    if found.creeps:
        return ()
    if found.names:
        return (described(found),)
    if drive.motor and all(each.startswith(UNNAMED) for each in wrong):
        return (f"the angles and the torque of the bar fit each other, so that {drive.motor} is suspected",)
    return ()


def _misshapen(drive: Drive, vehicle: Vehicle, rules: FitRules) -> list[str]:
    """Contradictions between angles and torque of the bar; a late signal distorts stiffness and offset."""
    found = drive.geometry
    if found is None:
        return []
    wrong = []
    ratio, bar = vehicle["motor_ratio"], vehicle["torsion_bar_stiffness"]
    apart = _departures(drive, vehicle)
    if rules.apart(apart["ratio"], 1.0):
        wrong.append(f"motor_ratio is {ratio:.4g}, but the ratio of the angles is {found.ratio:.4g} {OF_ANGLES}")
    if is_late(drive, vehicle, rules):
        others = "the others" if found.lag > 0.0 else "both others, which may themselves be late"
        when = "late" if found.lag > 0.0 else "early"
        return [*wrong, f"{found.late} is about {1e3 * abs(found.lag):.0f} ms {when} relative to {others}"]
    if rules.apart(apart["stiffness"], 1.0):
        wrong.append(
            f"torsion_bar_stiffness is {bar:.3g} N·m/rad, but the twist of the bar shows {found.stiffness:.3g} "
            "(driver_torque over steering_wheel_angle less motor_angle_mechanical)"
        )
    elif rules.apart(apart.get("offset", 0.0), 1.0):
        offset, turn = found.torque_offset, math.degrees(abs(found.torque_offset) / found.stiffness)
        way = "high" if offset > 0.0 else "low"
        wrong.append(
            f"driver_torque is {abs(offset):.2f} N·m too {way} for the twist of the bar (or steering_wheel_angle and "
            f"motor_angle_mechanical, which should agree on the unloaded bar, differ by {turn:.2f} degrees); correct "
            "the offset in the channel map"
        )
    return wrong


def is_late(drive: Drive, vehicle: Vehicle, rules: FitRules) -> bool:
    """Whether a signal is late by more than the sampling interval, and the observer's innovations confirm it.

    Args:
        drive: results of the drive
        vehicle: vehicle of the column
        rules: rules on the agreement of vehicle file and recording
    """
    unfit = math.isnan(drive.nis) or rules.misfit(drive.nis)
    if drive.geometry is None or not unfit:
        return False
    return rules.apart(_departures(drive, vehicle)["lag"], 1.0)


def _wrong_unit(drive: Drive, vehicle: Vehicle) -> str:
    """Sentence on an angle with degrees and radians confused; "" for none."""
    if drive.geometry is None:
        return ""
    factor = drive.geometry.ratio / vehicle["motor_ratio"]
    if abs(abs(math.log(factor)) - math.log(DEGREES)) > UNIT_MARGIN:
        return ""
    larger, smaller = "motor_angle_mechanical", "steering_wheel_angle"
    if factor < 1.0:
        larger, smaller = smaller, larger
    return (
        f"{larger} is {DEGREES:.1f} times too large relative to {smaller} for a motor_ratio of "
        f"{vehicle['motor_ratio']:.4g}: one of them has degrees and radians confused"
    )


def distances(drive: Drive, vehicle: Vehicle) -> dict[str, float]:
    """Distances of the recording from the vehicle file [standard deviations], by the name of the decision.

    Args:
        drive: results of the drive
        vehicle: vehicle of the column
    """
    furthest = max(_departures(drive, vehicle).values(), key=abs)
    innovations = {INNOVATIONS: misfit(drive.nis)} if drive.nis > 0.0 else {}
    return {COLUMN: furthest} | innovations


def _departures(drive: Drive, vehicle: Vehicle) -> dict[str, float]:
    """Distance of each property of the column from that of the vehicle file [standard deviations]."""
    apart = {"inertia": drive.inertia_error / (INERTIA_SPREAD * vehicle["steering_wheel_inertia"])}
    if (found := drive.geometry) is None:
        return apart
    spread = math.hypot(RATIO_SPREAD, found.ratio_uncertainty, ratio_spread(vehicle))
    apart["ratio"] = (found.ratio / vehicle["motor_ratio"] - 1.0) / spread
    apart["lag"] = found.lag / LAG_SPREAD if abs(found.lag) > drive.sample_time else 0.0
    bar = found.stiffness / vehicle["torsion_bar_stiffness"]
    apart["stiffness"] = math.log(bar) / STIFFNESS_SPREAD if bar > 0.0 else -math.inf
    if is_zeroed(vehicle):
        apart["offset"] = (found.torque_offset - drive.torque_offset) / OFFSET_SPREAD
    return apart


def is_zeroed(vehicle: Vehicle) -> bool:
    """Whether the angles are zero on the unloaded bar, so that they reveal the offset of its torque."""
    return usual_tuning(vehicle).offset is None
