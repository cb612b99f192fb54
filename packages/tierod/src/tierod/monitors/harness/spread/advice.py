"""Advice for a verdict that depends on guesses: only what a user can do, the surest way first."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

from tierod.core.findings import ParameterEffect
from tierod.vehicles.uncertain import may_move
from tierod.vehicles.vehicle import SHIPPED, Vehicle

PLACEHOLDER, BASELINE_FILE = "FAULT_FREE_DRIVE", "my-car.json"
"""Names of a recording and of a baseline in a command that is to be adapted."""


def in_words(names: Sequence[str]) -> str:
    """Names as part of a sentence.

    Args:
        names: names, at least one
    """
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def measurable(names: Sequence[str]) -> tuple[str, ...]:
    """Those parameters that a measurement makes more certain: neither chosen limits nor whole numbers.

    Args:
        names: names of parameters
    """
    return tuple(name for name in names if may_move(name))


def first_to_measure(effects: Sequence[ParameterEffect]) -> ParameterEffect | None:
    """Effect of the parameter that is to be measured first; None if none can be measured.

    Args:
        effects: effects of the parameters, the largest first
    """
    return next((each for each in effects if measurable((each.name,))), None)


def baseline_command(monitor: str, vehicle: Vehicle) -> str:
    """Command that learns the baseline of a car from a recording that the user knows to be fault-free.

    Args:
        monitor: name of monitor and variant, as in findings
        vehicle: vehicle of the recording
    """
    name, _, variant = monitor.partition(", ")
    car = vehicle.name if vehicle.path.parent == SHIPPED else str(vehicle.path)
    return (
        f"tierod diagnose {PLACEHOLDER} --vehicle {shlex.quote(car)} --monitor {name} --variant {variant} "
        f"--baseline {BASELINE_FILE} --fault-free"
    )


def cure(names: Sequence[str], assumed: Sequence[str], baseline: str) -> str:
    """What decides a verdict that depends on guesses.

    Args:
        names: names of the parameters and assumptions that decide
        assumed: those of them that are assumptions on the sensors, which a calibration replaces
        baseline: command that learns a baseline; "" where the verdict does not use one
    """
    ways = []
    if baseline:
        ways.append(
            f"give a fault-free drive of this car as baseline: '{baseline}', and judge this recording with --baseline "
            f"{BASELINE_FILE}"
        )
    if assumed:
        ways.append(f"calibrate driver_torque and motor_torque, and enter {in_words(assumed)} in the vehicle file")
    if known := measurable([name for name in names if name not in assumed]):
        ways.append(
            f"measure {in_words(known)} first, enter value and standard_deviation in the vehicle file, and judge again"
        )
    return "; or ".join(ways)
