"""Every study there is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from tierod.core.content import Item
from tierod.experiments.effort import Effort, Progress


@dataclass(frozen=True)
class Study:
    """One study.

    Args:
        name: as given on the command line
        title: what it is about, a few words
        summary: one sentence
        items: works the study out: claims, tables and charts, one after the other
        groups: title of every group of claims, in the order they are shown
    """

    name: str
    title: str
    summary: str
    items: Callable[[Effort, Progress], Iterator[Item]]
    groups: Mapping[str, str] = field(default_factory=dict)


def _friction(effort: Effort, progress: Progress) -> Iterator[Item]:
    from tierod.papers.friction.study import items

    return items(effort, progress)


def _column(effort: Effort, progress: Progress) -> Iterator[Item]:
    from tierod.papers.column.study import items

    return items(effort, progress)


def _sideslip(effort: Effort, progress: Progress) -> Iterator[Item]:
    from tierod.papers.sideslip.study import items

    return items(effort, progress)


def _motor_angle(effort: Effort, progress: Progress) -> Iterator[Item]:
    from tierod.papers.motor_angle.study import items

    return items(effort, progress)


def _condition(effort: Effort, progress: Progress) -> Iterator[Item]:
    from tierod.papers.condition.study import items

    return items(effort, progress)


STUDIES: Mapping[str, Study] = {
    study.name: study
    for study in (
        Study(
            "friction",
            "Friction of the steering",
            "The paper of Mohtat et al. claim by claim, and how exact and how soon tierod's own estimator is.",
            _friction,
            {
                "paper": "What the paper says",
                "estimator": "tierod's default estimator",
                "verdict": "tierod's verdict",
                "laws": "Friction laws that the estimator does not know",
                "plant": "The virtual car itself",
            },
        ),
        Study(
            "column",
            "Observers and control of the steering column",
            "The paper of Raffone claim by claim: identification, observability, reduction, observers, control.",
            _column,
            {
                "observability": "What the sensors show",
                "reduction": "Reduction of the model",
                "frequency": "Frequency response",
                "identification": "Identification on the bench",
                "torque": "Torque of the driver's hands",
                "hands": "Hands on and off the wheel",
                "natural": "Natural drives",
                "position": "Position control, and a driver who takes the wheel",
            },
        ),
        Study(
            "sideslip",
            "Sideslip from the steering's torque",
            "The paper of Yih, Ryu and Gerdes claim by claim, and how exact its observers and tierod's own are.",
            _sideslip,
            {
                "paper": "What the paper says",
                "observers": "The two observers",
                "combined": "The combined estimator",
                "cars": "Real cars",
            },
        ),
        Study(
            "motor-angle",
            "Angle of the steering's motor from its currents",
            "The paper of Reinelt et al. claim by claim, and how exact and how soon tierod watches the motor's sensor.",
            _motor_angle,
            {
                "motor-angle": "The observers as printed",
                "car": "In the car",
                "accuracy": "Motors that differ from the vehicle file",
                "standing": "Standing, and a wrong beginning",
                "temperature": "Temperature",
                "faults": "Faults of the angle sensor",
                "angles": "Which of three angles is wrong",
                "run-length": "Time between false alarms",
                "identified": "Parameters from a drive",
                "real": "Recordings of a real drive",
            },
        ),
        Study(
            "condition",
            "Condition of the vehicle's sensors and actuators",
            "The paper of Li, Frey and Gauterin claim by claim, its rules beside tierod's bank of filters.",
            _condition,
            {
                "rules": "The paper's rules",
                "sensors": "The 48 tests of sensors",
                "actuators": "The tests of actuators",
                "healthy": "Healthy driving",
                "beyond": "More faults, and two at once",
                "cars": "Real cars",
            },
        ),
    )
}
"""By name, as given on the command line."""
