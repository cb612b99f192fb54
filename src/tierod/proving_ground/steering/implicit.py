"""The implicit part of a car's integration: its steering, linearised."""

from __future__ import annotations

from typing import Any

from tierod.core.block import leaves
from tierod.proving_ground.integration import implicit_inverse, with_entry
from tierod.proving_ground.parts import Loads, Memory, Motion, Steering


def steering_inverse(steering: Steering, motion: Motion, memory: Memory, step: Any) -> list[list[Any]]:
    """What `rosenbrock` takes for a steering at the start of a step.

    All but dry friction is linearised at one point, of parameters alone: that part is worked out once. Friction is
    stiff while it sticks and not at all while it slides, so it comes as it is now: taken as stiff throughout, it would
    brake what slides, and left out, what is light would chatter.

    Args:
        steering: the part
        motion, memory: at the start of the step
        step: [s]
    """
    rest, relaxed = steering.stiff(), steering.remembered()
    idle = Loads(0.0, 0.0, 0.0, (0.0,) * len(steering.actuators), 0.0, 0.0)
    inverse = implicit_inverse(lambda at: steering.derivative(at, at, relaxed, idle), rest, step)
    place = [path for path, _ in leaves(rest)].index
    for (rate, angle), entry in steering.sticking(motion, memory).items():
        inverse = with_entry(inverse, place(rate), place(angle), entry, step)
    return inverse
