"""Priors of a vehicle's parameters, and what its drives say about them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields
from typing import NamedTuple

import numpy as np

from tierod.methods.identification.drives import SLOWEST, Drive, DriveNoises
from tierod.methods.identification.map_search import Posterior, Prior
from tierod.models.lateral_motion import LateralParameters
from tierod.physics.motion import GRAVITY
from tierod.vehicles import QUANTITIES, Vehicle
from tierod.vehicles.classes import BOUND as FOLLOWING
from tierod.vehicles.classes import bound_distance, class_of, typical_spread

# Parameters that ordinary drives may identify
SHOWN = (
    "mass",
    "yaw_inertia",
    "front_distance",
    "rear_distance",
    "front_cornering_stiffness",
    "rear_cornering_stiffness",
    "steering_ratio",
    "tyre_friction",
    "rear_friction_ratio",
    "relaxation_length",
    "rear_relaxation_ratio",
    "roll_share",
    "sensor_forward",
)

SIGNED = ("roll_share", "sensor_forward")  # Parameters that may be zero or negative
DISTANCES = ("front_distance", "rear_distance")
# Prior standard deviation of an axle distance above which it is identified from drives [m]. Pneumatic trail, roll steer
# and compliance of the steering have the same effect on the yaw motion as a centre of gravity further ahead: in drives
# of two simulated cars and of a race car the most probable one was 0.19 to 0.23 m ahead of the true one, three to five
# standard deviations.
LEAST_DISTANCE = 0.13
OF_ROAD = ("superelevation",)  # Quantities of the road that may be negative, for a bank towards the outside of bends
# Noises that are identified together with the parameters, and their relative prior standard deviations
NOISES: dict[str, float] = {
    "yaw_rate_noise": 1.7,
    "lateral_speed_drift": 1.7,
    "yaw_rate_drift": 1.7,
    "bank_wander": 1.7,
    "road_wheel_angle_wander": 1.7,
    "superelevation": 1.0,
}


# Standard deviations of the bias by effects that the model lacks (torsion bar, load transfer, an inertial unit below
# the roll axis), relative, for the position of the sensor in m. Measured as the errors of seven simulated cars (13
# minutes each, seed 77) beyond the standard deviations by noise and fixed parameters.
MODEL_ERRORS: dict[str, float] = {
    "yaw_inertia": 0.05,
    "front_cornering_stiffness": 0.08,
    "rear_cornering_stiffness": 0.15,
    "steering_ratio": 0.01,
    "relaxation_length": 0.25,
    "sensor_forward": 0.25,
}


def spread_of(name: str, vehicle: Vehicle) -> tuple[float, bool]:
    """Prior standard deviation of a parameter, and whether it is from the vehicle file (else from its class)."""
    given = vehicle.parameters.get(name)
    if given is not None and given.standard_deviation is not None:
        return given.standard_deviation, True
    return typical_spread(name, _value(name, vehicle), class_of(vehicle)) or 0.0, False


def held_distances(vehicle: Vehicle, free: Sequence[str] = ()) -> tuple[str, ...]:
    """Names of the axle distances whose prior is more accurate than an identification from drives."""
    known = (name for name in DISTANCES if name not in free and not (name == FOLLOWING and bound_distance(vehicle)))
    return tuple(name for name in known if 0.0 < spread_of(name, vehicle)[0] < LEAST_DISTANCE)


def priors_of(
    vehicle: Vehicle, usual: DriveNoises, with_ratio: bool = True, free: Sequence[str] = ()
) -> tuple[Prior, ...]:
    """Priors of parameters and noises; a parameter with a standard deviation of zero is fixed."""
    vehicle.parameters_for(LateralParameters)
    if with_ratio:
        vehicle["steering_ratio"]
    priors = []
    held = held_distances(vehicle, free)
    for name in SHOWN:
        deviation, _ = spread_of(name, vehicle)
        follows = name == FOLLOWING and bound_distance(vehicle)
        if (name == "steering_ratio" and not with_ratio) or not deviation or follows or name in held:
            continue
        priors.append(_prior(name, vehicle, deviation))
    noises = (
        Prior(name, getattr(usual, name), share * getattr(usual, name), name not in OF_ROAD)
        for name, share in NOISES.items()
    )
    return (*priors, *noises)


def considered(vehicle: Vehicle, priors: Sequence[Prior]) -> tuple[Prior, ...]:
    """Priors of the uncertain parameters of the lateral motion that are fixed in the search."""
    taken = {each.name for each in priors} | ({FOLLOWING} if bound_distance(vehicle) else set())
    found = []
    for name in (each.name for each in fields(LateralParameters)):
        deviation, _ = (0.0, False) if name in taken or name.startswith("road_wheel_") else spread_of(name, vehicle)
        if deviation:
            found.append(_prior(name, vehicle, deviation))
    return tuple(found)


def _prior(name: str, vehicle: Vehicle, deviation: float) -> Prior:
    low, high = QUANTITIES[name].plausible
    return Prior(name, _value(name, vehicle), deviation, name not in SIGNED, low, high)


def _value(name: str, vehicle: Vehicle) -> float:
    defaults = {each.name: each.default for each in fields(LateralParameters)}
    return vehicle[name] if name in vehicle else float(defaults[name])  # type: ignore[arg-type]


LEARNT, BOUND, NOT_SEEN = "learnt", "bound", "not seen"
# Standard deviation over the prior one below which a parameter is identified [-]: drives halve its variance
NARROWED = 0.7
TOGETHER = 0.5  # Correlation above which a parameter cannot be separated from another one [-]
CONTRADICTION = 4.0  # Distance between file and drives above which one of them is wrong [standard deviations]
REMARKED = 2.0  # Distance between file and drives above which there is a remark [standard deviations]
ODD = 6.0  # Distance between one drive and all others above which it is of another car [standard deviations]
_AXLES = "drive slow turns and fast bends in one drive; better: measure the wheelbase and weigh the axles"
# Test or measurement that identifies each parameter
CURES = {
    "mass": "weigh the car: drives cannot separate its mass from the stiffnesses",
    "yaw_inertia": "drive quick lane changes or a slalom at 60 to 80 km/h",
    "front_distance": _AXLES,
    "rear_distance": _AXLES,
    "front_cornering_stiffness": "drive bends at 60 to 100 km/h with lateral accelerations of 2 to 4 m/s²",
    "rear_cornering_stiffness": "drive quick lane changes at 80 to 100 km/h",
    "steering_ratio": "drive bends and turns at 20 to 60 km/h",
    "tyre_friction": "drive bends near the limit of grip, on a closed track",
    "rear_friction_ratio": "drive bends near the limit of grip, on a closed track",
    "relaxation_length": "drive a slalom below 40 km/h",
    "rear_relaxation_ratio": "drive a slalom below 40 km/h",
    "roll_share": "drive long steady bends at 2 to 4 m/s², with lateral acceleration recorded",
    "sensor_forward": "drive quick steering at any speed, with lateral acceleration recorded",
}


class Judged(NamedTuple):
    """Judgement of a parameter by drives."""

    name: str
    kind: str  # `LEARNT` (identified), `BOUND` (only in combination with others) or `NOT_SEEN` (not identified)
    before: float  # before, before_deviation: prior value and standard deviation, of file or class
    before_deviation: float
    value: float
    deviation: float
    text: str  # explanation and advice; empty for `LEARNT`


def judged(posterior: Posterior, names: Sequence[str]) -> list[Judged]:
    """Judgement of each named parameter."""
    spread = np.sqrt(np.diag(posterior.covariance))
    correlation = posterior.covariance / np.outer(spread, spread)
    alone = 1.0 / np.sqrt(np.diag(posterior.at.information))
    values, deviations, found = posterior.values, posterior.deviations, []
    for k, prior in enumerate(posterior.priors):
        if prior.name not in names:
            continue
        partners = [
            (float(correlation[k, j]), other.name)
            for j, other in enumerate(posterior.priors)
            if j != k and other.name in names and abs(correlation[k, j]) > TOGETHER
        ]
        kind = LEARNT if spread[k] < NARROWED else BOUND if partners and alone[k] < NARROWED else NOT_SEEN
        text = {LEARNT: "", BOUND: _bound(partners), NOT_SEEN: ""}[kind]
        if kind != LEARNT:
            text = f"{text or 'not identifiable from these drives'}; {CURES[prior.name]}"
        given = prior.name, kind, prior.value, prior.deviation
        found.append(Judged(*given, values[prior.name], deviations[prior.name], text))
    return found


def kept(name: str, value: float, deviation: float) -> Judged:
    """Judgement of a parameter whose prior is more accurate than an identification from drives."""
    text = (
        "known better than from drives, in which tyres and steering have the same effect; measure the wheelbase, "
        "weigh the axles"
    )
    return Judged(name, NOT_SEEN, value, deviation, value, deviation, text)


def _bound(partners: Sequence[tuple[float, str]]) -> str:
    ordered = sorted(partners, reverse=True, key=lambda pair: abs(pair[0]))[:2]
    return "bound together with " + " and ".join(f"{name} ({each:+.2f})".replace("-", "−") for each, name in ordered)


class Contradiction(NamedTuple):
    """A parameter whose value in the file contradicts the drives."""

    name: str
    value: float
    deviation: float
    distance: float  # from the value in the file, in standard deviations of both
    # joint distance of all contradicting parameters, which drives may not separate, as a normal deviate
    together: float


def contradictory(posterior: Posterior, names: Sequence[str]) -> tuple[str, ...]:
    """Names of the parameters whose prior value is far from that of the drives alone.

    The result of the drives alone follows from posterior and prior, both normal, as the difference of their precisions
    and information vectors.
    """
    found = []
    for k, prior in enumerate(posterior.priors):
        share = float(posterior.covariance[k, k])
        if prior.name in names and 0.0 < share < 1.0:
            distance = abs(float(posterior.place[k])) / math.sqrt(1.0 - share)
            found += [prior.name] if distance > CONTRADICTION else []
    return tuple(found)


def contradictions(posterior: Posterior, priors: Sequence[Prior], names: Sequence[str]) -> tuple[Contradiction, ...]:
    """Contradictions between file and drives for some parameters, the largest first."""
    values, deviations = posterior.values, posterior.deviations
    places = [k for k, each in enumerate(priors) if each.name in names]
    before = np.array([priors[k].deviation for k in places])
    apart = np.array([values[priors[k].name] - priors[k].value for k in places])
    spread = np.array([deviations[priors[k].name] for k in places])
    whole = posterior.covariance + posterior.unseen
    own = np.sqrt(np.diag(whole))[places]
    correlation = whole[np.ix_(places, places)] / np.outer(own, own)
    both = correlation * np.outer(spread, spread) + np.diag(before**2)
    together = _normal_deviate(float(apart @ np.linalg.solve(both, apart)), len(places))
    distances = np.abs(apart) / np.sqrt(np.diag(both))
    found = [
        Contradiction(priors[k].name, values[priors[k].name], deviations[priors[k].name], float(distance), together)
        for k, distance in zip(places, distances, strict=True)
        if max(distance, together) > REMARKED
    ]
    return tuple(sorted(found, reverse=True, key=lambda each: each.distance))


def _normal_deviate(square: float, count: int) -> float:
    from scipy.special import chdtrc, ndtri

    # The probability underflows for large squares; the deviate is then close to the root of the square.
    found = -float(ndtri(0.5 * chdtrc(count, square)))
    return found if math.isfinite(found) else math.sqrt(square)


class Odd(NamedTuple):
    """A drive whose parameters differ from those of the others."""

    drive: int
    name: str
    own: float  # own, others: value of this parameter in this drive, and in the others
    others: float
    distance: float
    certain: bool  # whether it is certain which drive is the odd one; false for two drives


def odd_drive(alone: Sequence[Posterior], names: Sequence[str]) -> Odd | None:
    """The drive whose parameters are farthest from those of all others; None if all agree."""
    if len(alone) < 2:
        return None
    kept = [k for k, prior in enumerate(alone[0].priors) if prior.name in names]
    found = [_against_others(alone, drive, kept) for drive in range(len(alone))]
    best = max(found, key=lambda each: each.distance)
    if best.distance < ODD:
        return None
    if len(alone) == 2:  # both have the same distance from each other; take the one farther from the prior
        best = max(found, key=lambda each: float(np.sum(alone[each.drive].place[kept] ** 2)))
    return best._replace(certain=len(alone) > 2)


def _against_others(alone: Sequence[Posterior], drive: int, kept: Sequence[int]) -> Odd:
    size = np.ix_(kept, kept)
    own, others = alone[drive], [each for k, each in enumerate(alone) if k != drive]
    precisions = [np.linalg.inv(each.covariance[size]) for each in others]
    spread = np.linalg.inv(sum(precisions))
    mean = spread @ sum(p @ each.place[kept] for p, each in zip(precisions, others, strict=True))
    apart, both = own.place[kept] - mean, own.covariance[size] + spread
    square, count = float(apart @ np.linalg.solve(both, apart)), len(kept)
    worst = int(np.argmax(np.abs(apart) / np.sqrt(np.diag(both))))
    prior = own.priors[kept[worst]]
    values = prior.at(float(own.place[kept[worst]])), prior.at(float(mean[worst]))
    return Odd(drive, prior.name, *values, (square - count) / math.sqrt(2.0 * count), True)


# Mean squared innovation over its variance (mean NIS) above which the model does not explain a drive [-]
EXPLAINED = 1.5
# Share of the largest lateral acceleration, by the friction of the vehicle file, above which tyres are near their
# limit; share of a drive near the limit above which it gives wrong values [-]. Race laps, a third of them near the
# limit, doubled the error of the sideslip against that of typical values.
NEAR_LIMIT, AT_LIMIT = 0.6, 0.1
# Distance from the typical value of the class above which the drives' value is not believed [standard deviations]
UNBELIEVABLE = 6.0


def remarks_of(vehicle: Vehicle, every: list[Judged], against: tuple[Contradiction, ...]) -> list[str]:
    """Sentences on priors of the class, and on contradictions between file and drives that do not prevent a result."""
    remarks = []
    usual = [each.name for each in every if not spread_of(each.name, vehicle)[1]]
    if usual:
        remarks.append(
            f"the vehicle file gives no standard deviation of {', '.join(usual)}: that of cars of its class was used"
        )
    refused = _refused(vehicle, against)
    learnt = [each.name for each in every if each.kind == LEARNT]
    remarks += [
        f"{each.name}: {_both(vehicle, each)}; "
        + (
            "file and drives are weighted by their standard deviations"
            if spread_of(each.name, vehicle)[1]
            else "the file gives no standard deviation, so the values of the drives are used"
        )
        for each in against
        if each not in refused and each.name in learnt and each.distance > REMARKED
    ]
    return remarks


def _refused(vehicle: Vehicle, against: tuple[Contradiction, ...]) -> list[Contradiction]:
    far = any(max(each.distance, each.together) > CONTRADICTION for each in against)
    return [each for each in against if far and (spread_of(each.name, vehicle)[1] or each.distance > UNBELIEVABLE)]


def _both(vehicle: Vehicle, each: Contradiction) -> str:
    deviation, _ = spread_of(each.name, vehicle)
    before = f"{vehicle[each.name]:.4g} ± {deviation:.2g}" if each.name in vehicle else "the usual value"
    return f"{before} before, {each.value:.4g} ± {each.deviation:.2g} in these drives, {each.distance:.1f} σ apart"


def unexplained(posterior: Posterior) -> str:
    """Message that the model does not explain the drives; empty if it does."""
    squares = [float(np.mean(each[each != 0.0] ** 2)) for each in posterior.at.whitened]
    if posterior.converged and max(squares) < EXPLAINED:
        return ""
    found = f"the mean squared innovation is {max(squares):.2g} of its variance"
    end = "" if posterior.converged else "the search did not converge, and "
    return (
        f"the model of a car does not fit these drives: {end}{found}; leave out driving at the limit of grip, check "
        "that units and signs of the channel map are right, or start from values nearer to the car"
    )


def at_limit(vehicle: Vehicle, drives: tuple[Drive, ...]) -> str:
    """Message on a drive at the limit of grip; empty if there is none."""
    limit = NEAR_LIMIT * GRAVITY * vehicle.parameters_for(LateralParameters).tyre_friction
    for each in drives:
        speed, yaw_rate = each.samples[:, 0], each.samples[:, 3]
        across = np.abs(speed * yaw_rate)[np.isfinite(speed * yaw_rate) & (speed > SLOWEST)]
        share = float(np.mean(across > limit)) if len(across) else 0.0
        if share > AT_LIMIT:
            return (
                f"{each.name} is driven at the limit of grip: {share:.0%} of it is above {limit:.1f} m/s² lateral "
                "acceleration, where the tyre model does not hold and the values would be wrong; identify from "
                "ordinary drives"
            )
    return ""


def doubt_of(
    vehicle: Vehicle,
    drives: tuple[Drive, ...],
    learnt: list[Judged],
    against: tuple[Contradiction, ...],
    odd: Odd | None,
    misfit: str,
) -> str:
    """Reason why nothing should be written to the vehicle file; empty if there is none.

    Args: odd: drive of another car, or None.
    """
    if odd is not None:
        name = drives[odd.drive].name
        which = (
            f"{name} is" if odd.certain else f"the drives are of two cars; {name}, farther from the file, seems to be"
        )
        return (
            f"{which} of another car than the rest: {odd.name} is {odd.own:.4g} there and {odd.others:.4g} in the "
            f"others, {odd.distance:.0f} σ apart; leave it out, or identify it separately"
        )
    if given := _refused(vehicle, against):
        # Values without a standard deviation in the file are also named, since one of them may be the wrong one.
        far = [each for each in against if each in given or each.distance > CONTRADICTION]
        said = "; ".join(f"{each.name} is {_both(vehicle, each)}" for each in far[:3])
        if far[0].distance <= CONTRADICTION:
            said += f", and together they are {far[0].together:.1f} σ apart"
        return (
            f"vehicle file and drives contradict each other: {said}; check that the drives are of this car and that "
            "units and signs of the channel map are right, or give the parameter a wider standard_deviation"
        )
    if not learnt and not misfit:
        return "these drives identify nothing better than the vehicle file; drive as the table recommends"
    return misfit
