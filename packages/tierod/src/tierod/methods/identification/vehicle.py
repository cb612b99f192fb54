"""Identification of a vehicle's parameters from ordinary drives, with its vehicle file as the prior."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.methods.analysis.consistency import usual_deviation, white_noise
from tierod.methods.identification import vehicle_judgement as judgement
from tierod.methods.identification.drives import (
    ANGLES,
    RATE,
    Drive,
    DriveLikelihood,
    DriveNoises,
    drive_filter,
    drives_of,
    refuse_unlike,
)
from tierod.methods.identification.experiment import UNKNOWN_BEFORE, Found
from tierod.methods.identification.map_search import ENOUGH, TRUSTED, Built, Posterior, Prior, Search, considering
from tierod.models.lateral_motion import LateralParameters
from tierod.physics.motion import GRAVITY, understeer_gradient
from tierod.vehicles import Vehicle
from tierod.vehicles.classes import BOUND, FREE, bound_distance

# Factor on the trusted measurements in each stage of the search, and the increase of the log-posterior that ends it: in
# the first stage the prior dominates
STAGES = ((0.1, 0.5), (1.0, ENOUGH))
CROSSFALL = 0.02  # Standard deviation of the bank of straight roads [rad], whose effect is part of the sensor zeros
OUTPUTS = 2
WIDENED = 10.0  # Factor on the prior standard deviation of a parameter for which file and drives contradict each other
# Parameters without a check for contradictions, since roads have the same effect: bank adds to the roll of a car
LIKE_ROADS = ("roll_share",)


class Zeros(NamedTuple):
    """Zeros of the sensors in a drive: readings without motion, and their standard deviations."""

    steering: tuple[float, float]  # of the measured angle [rad]
    yaw_rate: tuple[float, float]  # [rad/s]
    lateral_acceleration: tuple[float, float]  # with the crossfall of the road [m/s**2]


@dataclass(frozen=True, eq=False)
class VehicleIdentification:
    found: tuple[Found, ...]
    judged: tuple[judgement.Judged, ...]
    zeros: tuple[Zeros, ...]  # sensor zeros of every drive, in their order
    noises: Mapping[str, tuple[float, float]]  # of sensors, model and road, with their standard deviations
    drives: tuple[Drive, ...]
    posterior: Posterior
    contradictory: tuple[judgement.Contradiction, ...]
    odd: judgement.Odd | None  # drive of another car, or None
    remarks: tuple[str, ...]
    doubt: str  # reason why nothing should be written to the file; empty if it may be written


def identify_vehicle(
    recordings: Mapping[str, Recording],
    vehicle: Vehicle,
    free: tuple[str, ...] = (),
    progress: Callable[[float], None] = lambda share: None,
) -> VehicleIdentification:
    """The most probable parameters of a vehicle, given its file and drives.

    Args: vehicle: its values and standard deviations are the prior; without a standard deviation, that of its class;
    free: parameters that may change; by default all that drives may identify. The prior uncertainty of the others is
    considered all the same.
    """
    if unknown := [name for name in free if name not in judgement.SHOWN]:
        raise ParameterError(
            f"'{unknown[0]}' is not identified from ordinary drives; there are {', '.join(judgement.SHOWN)}"
        )
    drives = tuple(drives_of(recordings))
    usual = _usual(drives)
    priors = judgement.priors_of(vehicle, usual, with_ratio=drives[0].angle != ANGLES[0], free=free)
    refuse_unlike(drives, vehicle)
    built = _built(vehicle, usual, drives[0].angle)
    held = judgement.considered(vehicle, priors)
    posterior = _searched(priors, drives, built, progress, held=held)
    alone = [_searched(priors, [each], built, start=posterior.place) for each in drives] if len(drives) > 1 else []
    return _concluded(vehicle, drives, posterior, alone, built, free)


def _searched(
    priors: tuple[Prior, ...],
    drives: Sequence[Drive],
    built: Built,
    progress: Callable[[float], None] = lambda share: None,
    start: np.ndarray | None = None,
    held: Sequence[Prior] | None = None,
) -> Posterior:
    """Result of the search in all stages, or of the last stage from a start near the result.

    With `held`, its standard deviations include fixed parameters and errors of the model; None leaves out both, which
    are common to all drives of a car.
    """
    samples = [each.samples for each in drives]
    stages = STAGES if start is None else STAGES[-1:]
    for number, (share, enough) in enumerate(stages):
        search = Search(priors, samples, built, OUTPUTS, share * TRUSTED)
        found = search.run(start, partial(_part, progress, number), enough)
        start = found.place
    return found if held is None else considering(search, found, held, judgement.MODEL_ERRORS)


def _by_drives_alone(
    posterior: Posterior, names: Sequence[str], drives: Sequence[Drive], built: Built, held: Sequence[Prior]
) -> tuple[judgement.Contradiction, ...]:
    far = [name for name in judgement.contradictory(posterior, names) if name not in LIKE_ROADS]
    if not far:
        return ()
    wide = tuple(
        dataclasses.replace(each, deviation=WIDENED * each.deviation) if each.name in far else each
        for each in posterior.priors
    )
    found = _searched(wide, drives, built, held=held)
    return () if judgement.unexplained(found) else judgement.contradictions(found, posterior.priors, far)


def _part(progress: Callable[[float], None], number: int, done: float) -> None:
    progress((number + done) / len(STAGES))


def _usual(drives: Sequence[Drive]) -> DriveNoises:
    usual = DriveNoises()
    lateral = max(white_noise(each.samples[:, 4]) for each in drives)
    return dataclasses.replace(usual, lateral_acceleration_noise=max(usual.lateral_acceleration_noise, lateral))


def _built(vehicle: Vehicle, usual: DriveNoises, angle: str) -> Callable[..., DriveLikelihood]:
    base = vehicle.parameters_for(LateralParameters)
    of_car = {each.name for each in dataclasses.fields(LateralParameters)}
    ratio = 1.0 if angle == ANGLES[0] else vehicle["steering_ratio"]
    bound = bound_distance(vehicle)

    def built(values: Mapping[str, float], recording: int) -> DriveLikelihood:
        if bound and FREE in values:
            values = {**values, BOUND: vehicle["wheelbase"] - values[FREE]}
        car = dataclasses.replace(base, **{name: value for name, value in values.items() if name in of_car})
        noises = dataclasses.replace(
            usual, **{name: value for name, value in values.items() if name in judgement.NOISES}
        )
        return DriveLikelihood(drive_filter(car, noises, 1.0 / RATE), values.get("steering_ratio", ratio))

    return built


def _concluded(
    vehicle: Vehicle,
    drives: tuple[Drive, ...],
    posterior: Posterior,
    alone: Sequence[Posterior],
    built: Callable[..., DriveLikelihood],
    free: tuple[str, ...],
) -> VehicleIdentification:
    names = tuple(prior.name for prior in posterior.priors if prior.name in judgement.SHOWN)
    held = () if free else judgement.held_distances(vehicle)
    every = [each for each in judgement.judged(posterior, names) if each.name in (free or judgement.SHOWN)]
    every += [
        judgement.kept(name, vehicle[name], judgement.spread_of(name, vehicle)[0]) for name in held if name in vehicle
    ]
    blocks = [built(posterior.values, k) for k in range(len(drives))]
    results = [scan(block, each.samples) for block, each in zip(blocks, drives, strict=True)]
    zeros = tuple(
        _zeros(each.values[-1], block.ratio, block.filter.parameters.sampled.car)
        for block, each in zip(blocks, results, strict=True)
    )
    noises = {name: (posterior.values[name], posterior.deviations[name]) for name in judgement.NOISES}
    noises |= _reading_noise([each.values for each in results])
    against = _by_drives_alone(posterior, names, drives, built, judgement.considered(vehicle, posterior.priors))
    odd = judgement.odd_drive(alone, names)
    learnt = [each for each in every if each.kind == judgement.LEARNT]
    found = [_found(each.name, vehicle, each.value, each.deviation) for each in learnt]
    found += [
        _found(BOUND, vehicle, vehicle["wheelbase"] - each.value, each.deviation)
        for each in learnt
        if each.name == FREE and bound_distance(vehicle)
    ]
    found += [
        _found(name, vehicle, *noises[name])
        for name, usual in WRITTEN_NOISES.items()
        if learnt and noises.get(name, (0.0, 0.0))[0] > usual
    ]
    return VehicleIdentification(
        tuple(found),
        tuple(every),
        zeros,
        noises,
        drives,
        posterior,
        against,
        odd,
        tuple(judgement.remarks_of(vehicle, every, against)),
        judgement.at_limit(vehicle, drives)
        or judgement.doubt_of(vehicle, drives, learnt, against, odd, judgement.unexplained(posterior)),
    )


# Noises that go into the vehicle file if they are above these defaults of the estimators. With lower ones an estimator
# gives its model of the road too much weight: the error of the sideslip grew by half on simulated cars.
WRITTEN_NOISES = {
    "yaw_rate_noise": 0.0035,
    "lateral_acceleration_noise": 0.2,
    "lateral_speed_drift": 0.02,
    "yaw_rate_drift": 0.005,
    "bank_wander": 0.03,
}


def _found(name: str, vehicle: Vehicle, value: float, deviation: float) -> Found:
    given = vehicle.parameters.get(name)
    before = UNKNOWN_BEFORE if given is None else (given.value, given.standard_deviation)
    return Found.normal(name, before, value, deviation, "drives")


def _zeros(last: np.ndarray, ratio: float, car: LateralParameters) -> Zeros:
    """Sensor zeros after the last sample; those of steering and lateral acceleration include the crossfall of roads."""
    values, spreads = last[2 * OUTPUTS : 2 * OUTPUTS + 3], np.sqrt(last[2 * OUTPUTS + 3 : 2 * OUTPUTS + 6])
    stiffness = car.front_cornering_stiffness, car.rear_cornering_stiffness
    gradient = understeer_gradient(car.mass, car.front_distance, car.rear_distance, *stiffness)
    by_road = np.array([gradient, 0.0, 1.0]) * GRAVITY * CROSSFALL
    scale = np.array([1.0 / ratio, 1.0, 1.0])
    pairs = zip((scale * values).tolist(), (scale * np.hypot(spreads, by_road)).tolist(), strict=True)
    return Zeros(*pairs)


def _reading_noise(results: list[np.ndarray]) -> dict[str, tuple[float, float]]:
    """Noise of one measurement of the lateral acceleration, from its innovations; empty without measurements."""
    innovations = np.concatenate([each[:, 1] * np.exp(each[:, OUTPUTS + 1]) for each in results])
    innovations = innovations[innovations != 0.0]
    if not len(innovations):
        return {}
    value = usual_deviation(innovations)
    return {"lateral_acceleration_noise": (value, value / math.sqrt(TRUSTED))}
