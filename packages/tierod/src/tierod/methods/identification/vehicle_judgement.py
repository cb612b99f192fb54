"""Judgement of every parameter of a vehicle after identification, contradictions to its file, and outlier drives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.methods.identification.posterior import Posterior, Prior

LEARNT, BOUND, NOT_SEEN = "learnt", "bound", "not seen"
NARROWED = 0.7
"""Standard deviation over the prior one below which a parameter is identified [-]: drives halve its variance."""
TOGETHER = 0.5
"""Correlation above which a parameter cannot be separated from another one [-]."""
CONTRADICTION = 4.0
"""Distance between file and drives above which one of them is wrong [standard deviations]."""
REMARKED = 2.0
"""Distance between file and drives above which there is a remark [standard deviations]."""
ODD = 6.0
"""Distance between one drive and all others above which it is of another car [standard deviations]."""

_AXLES = "drive slow turns and fast bends in one drive; better: measure the wheelbase and weigh the axles"
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
"""Test or measurement that identifies each parameter."""


class Judged(NamedTuple):
    """Judgement of a parameter by drives.

    Args:
        kind: `LEARNT` (identified), `BOUND` (only in combination with others) or `NOT_SEEN` (not identified)
        before, before_deviation: prior value and standard deviation, of file or class
        text: explanation and advice; empty for `LEARNT`
    """

    name: str
    kind: str
    before: float
    before_deviation: float
    value: float
    deviation: float
    text: str


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
    """A parameter whose value in the file contradicts the drives.

    Args:
        distance: from the value in the file, in standard deviations of both
        together: joint distance of all contradicting parameters, which drives may not separate, as a normal deviate
    """

    name: str
    value: float
    deviation: float
    distance: float
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
    """A drive whose parameters differ from those of the others.

    Args:
        own, others: value of this parameter in this drive, and in the others
        certain: whether it is certain which drive is the odd one; false for two drives
    """

    drive: int
    name: str
    own: float
    others: float
    distance: float
    certain: bool


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
