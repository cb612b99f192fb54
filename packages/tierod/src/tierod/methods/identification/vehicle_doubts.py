"""Sentences on the result of a vehicle's identification: remarks, and reasons to write nothing to its file."""

from __future__ import annotations

import numpy as np

from tierod.methods.identification.drive_likelihood import SLOWEST
from tierod.methods.identification.drive_samples import Drive
from tierod.methods.identification.posterior import Posterior
from tierod.methods.identification.vehicle_judgement import (
    CONTRADICTION,
    LEARNT,
    REMARKED,
    Contradiction,
    Judged,
    Odd,
)
from tierod.methods.identification.vehicle_priors import spread_of
from tierod.models.lateral_parameters import LateralParameters
from tierod.physics.gravity import GRAVITY
from tierod.vehicles import Vehicle

EXPLAINED = 1.5
"""Mean squared innovation over its variance (mean NIS) above which the model does not explain a drive [-]."""
NEAR_LIMIT, AT_LIMIT = 0.6, 0.1
"""Share of the largest lateral acceleration, by the friction of the vehicle file, above which tyres are near their
limit; share of a drive near the limit above which it gives wrong values [-]. Race laps, a third of them near the limit,
doubled the error of the sideslip against that of typical values."""
UNBELIEVABLE = 6.0
"""Distance from the typical value of the class above which the drives' value is not believed [standard deviations]."""


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

    Args:
        odd: drive of another car, or None
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
