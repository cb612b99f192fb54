"""Parts of a scenario as subjects of an export: the whole car with its driver, the driver, the assist unit."""

from __future__ import annotations

from typing import Any

from tierod.core.errors import ParameterError
from tierod.export.subject import Subject, identifier, subject_of_block


def unit_of(what: str, name: str) -> tuple[Subject, dict[str, float]]:
    """Subject of the export of a part of a scenario, and the usual values of its inputs."""
    from tierod_lab.ground.control import AssistController
    from tierod_lab.ground.drivers import Driving
    from tierod_lab.ground.run import started, usual_inputs
    from tierod_lab.ground.scenarios import load

    scenario = load(name)
    car = started(scenario.car, scenario.course)
    part: Any = getattr(car, what, None)
    if what != "plant" and part is None:
        raise ParameterError(
            f"the car '{scenario.car_name}' of the scenario '{scenario.name}' has no {what} unit of its own"
        )
    made: Any = car
    if what != "plant":
        made = Driving(part, car.step_time) if what == "driver" else AssistController(part)
    title = f"{what} of the scenario {scenario.name}"
    subject = subject_of_block(
        identifier(f"{what}_{scenario.name}"), made, 1.0 / car.step_time, title, what, scenario.name, scenario.car_name
    )
    return subject, usual_inputs(made)
