"""Errors of the combined estimator: right and wrong parameters, road and wind disturbances, missing measurements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Item, Table
from tierod_lab.papers.sideslip.combined_drives import (
    FRONT,
    NOTHING,
    READINGS,
    REAR,
    WITH,
    WITHOUT_TORQUE,
    Belief,
    both_stiff,
    errors,
    estimated,
    general,
    on,
    right,
    rms,
    scaled,
)
from tierod_lab.papers.sideslip.reported import COMBINED, SEEDS
from tierod_lab.studies.effort import Effort

GOAL = "goal of tierod"
UNFOLLOWED = "nothing followed"


@dataclass(frozen=True)
class Case:
    """A drive, the assumed parameters, and the goal of the claim on it.

    Args:
        course: name of the course in `COURSES`
        belief: change from the parameters of the vehicle file to the assumed ones
        goal: largest root mean square error with all signals [deg]; None makes no claim
        claim: name of the claim after its group
    """

    course: str
    belief: Belief = right
    goal: float | None = None
    claim: str = ""


RANDOM = "random steering"
CASES = {
    "random steering": Case(RANDOM, right, 0.05, "nominal"),
    "sine, 0.3 Hz": Case("sine, 0.3 Hz", right, 0.05, "nominal-sine"),
    "mixed drive from standstill": Case("mixed drive from standstill"),
    "front stiffness +20 %": Case(RANDOM, scaled(**{FRONT: 1.2}), 0.05, "front-stiffness"),
    "rear stiffness +20 %": Case(RANDOM, scaled(**{REAR: 1.2}), 0.05, "rear-stiffness"),
    "both stiffnesses +20 %": Case(RANDOM, both_stiff, 0.05, "both-stiffnesses"),
    "both stiffnesses -20 %": Case(RANDOM, scaled(**{FRONT: 0.8, REAR: 0.8}), 0.05, "both-stiffnesses-soft"),
    "steering friction +50 %": Case(RANDOM, scaled(road_wheel_friction=1.5), 0.07, "steering-friction-high"),
    "steering friction -50 %": Case(RANDOM, scaled(road_wheel_friction=0.5), 0.07, "steering-friction-low"),
    "mass +3 %, yaw inertia +10 %": Case(RANDOM, scaled(mass=1.03, yaw_inertia=1.1)),
    "axles and roll of no car in particular": Case(RANDOM, general),
    "the same, sine, 0.3 Hz": Case("sine, 0.3 Hz", general),
    "bank 3°": Case("bank 3°", right, 0.05, "bank"),
    "bank 3°, both stiffnesses +20 %": Case("bank 3°", both_stiff),
    "crosswind 500 N": Case("crosswind 500 N", right, 0.05, "crosswind"),
    "low friction, 0.35": Case("low friction, 0.35", right, 0.3, "low-friction"),
    "sine, 0.05 Hz": Case("sine, 0.05 Hz"),
    "sine, 0.05 Hz, both stiffnesses +20 %": Case("sine, 0.05 Hz", both_stiff),
}
"""Name in the table -> case."""


@dataclass(frozen=True)
class Measured:
    """Errors and coverage of one case.

    Args:
        spread: standard deviation of the true sideslip angle [deg]
        errors: root mean square error [deg], by name in `READINGS` and for `UNFOLLOWED`
        covered: share of the errors within the 95 % band [-], likewise
    """

    spread: float
    errors: dict[str, float]
    covered: dict[str, float]


def measured(case: Case, seeds: tuple[int, ...]) -> Measured:
    """Runs all variants of the estimator over the drives of a case and pools the seeds."""
    drives = [on(case.course, seed) for seed in seeds]
    found: dict[str, float] = {}
    covered: dict[str, float] = {}
    for name in (*READINGS, UNFOLLOWED):
        readings, tuning = (WITH, NOTHING) if name == UNFOLLOWED else (name, None)
        pairs = [errors(drive, estimated(drive, case.belief, readings, tuning)) for drive in drives]
        found[name] = rms(np.concatenate([error for error, _ in pairs]))
        covered[name] = float(np.mean(np.concatenate([inside for _, inside in pairs])))
    spread = np.degrees(np.std(np.concatenate([drive.truth("sideslip_angle") for drive in drives])))
    return Measured(float(spread), found, covered)


def _of_case(seeds: tuple[int, ...], name: str) -> Measured:
    return measured(CASES[name], seeds)


def items(effort: Effort) -> Iterator[Item]:
    seeds = tuple(SEEDS.of(COMBINED, 1 if effort.quick else 3))
    found = dict(zip(CASES, effort.made(partial(_of_case, seeds), list(CASES)), strict=True))
    yield _table(found)
    for name, case in CASES.items():
        if case.goal is None:
            continue
        yield Claim(
            f"combined.{case.claim}",
            f"Sideslip on the virtual car after a minute, {name}: root mean square error with all signals.",
            GOAL,
            None,
            found[name].errors[WITH],
            at_most(case.goal),
            "deg",
            f"Without the steering's torque {found[name].errors[WITHOUT_TORQUE]:.3f}.",
        )
    covered = [each.covered[WITH] for each in found.values()]
    least = min(found, key=lambda name: found[name].covered[WITH])
    rms_error = found[least].errors[WITH]
    yield Claim(
        "combined.coverage",
        "The 95 % band of the sideslip angle holds the truth, worst case of the table.",
        GOAL,
        None,
        min(covered),
        at_least(0.88),
        "",
        f"Mean over the cases {np.mean(covered):.2f}.",
        cause=f"Worst: {least}, {rms_error:.3f} deg; {sum(each < 0.88 for each in covered)} of {len(covered)} cases "
        "are below the goal. Larger noises would widen every band, also where it is wide enough.",
    )


def _table(found: dict[str, Measured]) -> Table:
    columns = (*READINGS, UNFOLLOWED)
    rows = [
        (
            name,
            f"{each.spread:.2f}",
            *(f"{each.errors[column]:.3f}" for column in columns),
            f"{each.covered[WITH]:.2f}",
        )
        for name, each in found.items()
    ]
    return Table(
        "Combined estimator: root mean square error of the sideslip angle after the first minute (degrees)",
        ("case", "sideslip, std", *columns, "95 % band holds"),
        tuple(rows),
        "Three drives each, at 25 m/s but for the mixed one, with the parameters of the vehicle file. The column on "
        "the last but one has all signals and assumes the file to be exact.",
    )
