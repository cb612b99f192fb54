"""The steering column as an observer sees it that knows the law of its friction, but not the level."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, get_type_hints

from tierod.core.block import named_tuple
from tierod.models.linear import Matrices
from tierod.physics.friction import dahl_update


@dataclass(frozen=True)
class RubbingObservationParameters:
    """A sampled column and the law of its friction.

    Args:
        linear: the column with its torques as states, sampled
        dahl_angle: of the motor, over which friction builds up: level over stiffness [rad]
        sample_time: [s]
    """

    linear: Matrices
    dahl_angle: Annotated[float, "rad"]
    sample_time: Annotated[float, "s"]


@lru_cache(maxsize=64)
def with_dahl_friction(observed: Any) -> Any:
    """The model of an observed column whose disturbance torque is Dahl's friction at the motor and what remains.

    Args:
        observed: discrete model with the states `motor_angle` and `disturbance_torque`, from `observed_column`

    Returns:
        a discrete model with two more states, `normalised_friction` (torque over level) and `friction_level`; its
        `disturbance_torque` is what the friction does not explain

    Source: Raffone, eq (4), for the exponent 1, with the level as a state; the update over a sample is exact, and what
        acts during it is the friction halfway.
    """
    hints = get_type_hints(observed.State, include_extras=True)
    fields = [(name, hints[name]) for name in observed.State._fields]
    fields += [("normalised_friction", Annotated[float, ""]), ("friction_level", Annotated[float, "N*m"])]
    state: Any = named_tuple("RubbingObservationState", fields)

    def transition(x: Any, u: Any, p: RubbingObservationParameters) -> Any:
        halfway = dahl_update(x.normalised_friction, 0.5 * p.sample_time * x.motor_speed, p.dahl_angle)
        friction = halfway * x.friction_level
        column = observed.State(*x[:-2])
        moved = observed.transition(column._replace(disturbance_torque=x.disturbance_torque + friction), u, p.linear)
        travel = moved.motor_angle - x.motor_angle
        built_up = dahl_update(x.normalised_friction, travel, p.dahl_angle)
        return state(*moved._replace(disturbance_torque=x.disturbance_torque), built_up, x.friction_level)

    def output(x: Any, u: Any, p: RubbingObservationParameters) -> Any:
        return observed.output(observed.State(*x[:-2]), u, p.linear)

    members = {
        "__doc__": "Observed column with Dahl's friction at the motor.",
        "__module__": __name__,
        "State": state,
        "Input": observed.Input,
        "Output": observed.Output,
        "Parameters": RubbingObservationParameters,
        "transition": staticmethod(transition),
        "output": staticmethod(output),
    }
    return type("RubbingObservation", (), members)
