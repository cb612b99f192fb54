"""Identification of a car from ordinary drives: parameters of its motion, and the ratio of its motor's torque."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from math import sqrt

from tierod.core.facts import REPAIR
from tierod.core.recording import Recording
from tierod.methods.identification.experiment import Found
from tierod.methods.identification.vehicle import VehicleIdentification, identify_vehicle
from tierod.methods.identification.vehicle_judgement import CONTRADICTION, LEARNT, NARROWED, NOT_SEEN, Judged
from tierod.methods.identification.vehicle_priors import spread_of
from tierod.monitors.friction.motor_ratio import NAME, DriveRatio, ratio_of_drives
from tierod.monitors.harness.input_defects import InputDefects
from tierod.vehicles import Vehicle
from tierod.vehicles.vehicle import Parameter

CURE = (
    "record ten minutes of bends at 30 to 120 km/h with driver_torque and motor_torque; better: take it from the data "
    "sheet of the steering gear"
)
TORQUES = ("driver_torque", "motor_torque")
_MOTION = 0.8
"""Share of the progress that the identification of the motion takes [-]."""


def identify_own_car(
    recordings: Mapping[str, Recording],
    vehicle: Vehicle,
    free: tuple[str, ...] = (),
    progress: Callable[[float], None] = lambda share: None,
) -> VehicleIdentification:
    """Most probable parameters of a car, given its vehicle file and its drives.

    Args:
        recordings: ordinary drives of one car, by name
        vehicle: prior knowledge, see `identify_vehicle`
        free: parameters of the motion to be estimated; if none is given, all that drives can identify, and the ratio of
            the motor's torque
        progress: called with the completed share, 0 to 1

    Raises:
        InputError: a recording lacks a signal that is needed
        ParameterError: the vehicle lacks a parameter, or a free parameter is not identifiable from drives
    """
    found = identify_vehicle(recordings, vehicle, free, lambda share: progress(_MOTION * share))
    if free or found.doubt or NAME not in vehicle or not spread_of(NAME, vehicle)[0]:
        return found
    if defects := _defects_of_torques(recordings):
        kept = _judged(vehicle, None)._replace(text=f"not identified: {'; '.join(defects)}; {REPAIR}")
        return dataclasses.replace(found, judged=(*found.judged, kept), remarks=(*found.remarks, *defects))
    seen = ratio_of_drives(recordings, _with(vehicle, found), lambda share: progress(_MOTION + (1 - _MOTION) * share))
    each = _judged(vehicle, seen)
    if each.kind != LEARNT:
        return dataclasses.replace(found, judged=(*found.judged, each))
    before = vehicle.parameters[NAME]
    learnt = Found.normal(NAME, (before.value, before.standard_deviation), each.value, each.deviation, "drives")
    return dataclasses.replace(found, found=(*found.found, learnt), judged=(*found.judged, each))


def _defects_of_torques(recordings: Mapping[str, Recording]) -> list[str]:
    """Sentences on torques that are late or clipped, since these bias the ratio from the balance of torques."""
    found = []
    for name, recording in recordings.items():
        if any(torque not in recording for torque in TORQUES):
            continue
        checks = InputDefects(TORQUES)
        checks.add(recording, *recording.span)
        found += [f"{name}: {each.cause}" for each in checks.found()]
    return found


def _with(vehicle: Vehicle, found: VehicleIdentification) -> Vehicle:
    """Vehicle with the parameters that the motion has identified."""
    learnt = {each.name: each.value for each in found.found if each.name in vehicle}
    parameters = {
        name: dataclasses.replace(each, value=learnt[name]) if name in learnt else each
        for name, each in vehicle.parameters.items()
    }
    return dataclasses.replace(vehicle, parameters=parameters)


def _judged(vehicle: Vehicle, seen: DriveRatio | None) -> Judged:
    """Combination of the values of file and drives, weighted by their inverse variances."""
    before: Parameter = vehicle.parameters[NAME]
    spread = spread_of(NAME, vehicle)[0]
    kept = Judged(
        NAME, NOT_SEEN, before.value, spread, before.value, spread, f"not identifiable from these drives; {CURE}"
    )
    if seen is None:
        return kept
    apart = abs(seen.value - before.value) / sqrt(seen.deviation**2 + spread**2)
    if apart > CONTRADICTION:
        text = f"{seen.value:.3g} ± {seen.deviation:.2g} in these drives, {apart:.1f} σ from the file; {CURE}"
        return kept._replace(text=text)
    weights = spread**-2, seen.deviation**-2
    deviation = 1.0 / sqrt(sum(weights))
    if deviation >= NARROWED * spread:
        return kept
    value = (weights[0] * before.value + weights[1] * seen.value) * deviation**2
    return Judged(NAME, LEARNT, before.value, spread, value, deviation, "")
