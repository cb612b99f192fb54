"""Registry of the studies."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module

from tierod.core.content import Item
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.metrics import Frame


@dataclass(frozen=True)
class Study:
    """A study that `tierod study` runs."""

    name: str  # name on the command line
    title: str  # subject, in a few words
    summary: str  # subject, in one sentence
    # function that runs the study and yields its claims, tables and charts one after the other
    items: Callable[[Effort, Progress], Iterator[Item | Frame]]
    # title of every group of claims, by the first part of their keys, in the order of display
    groups: Mapping[str, str] = field(default_factory=dict)


def _items(package: str) -> Callable[[Effort, Progress], Iterator[Item | Frame]]:
    """Function that imports the study of a package below `tierod_lab.papers` on its first call and yields its items."""

    def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
        worked_out: Iterator[Item | Frame] = import_module(f"tierod_lab.papers.{package}.study").items(effort, progress)
        return worked_out

    return items


STUDIES: Mapping[str, Study] = {
    study.name: study
    for study in (
        Study(
            "friction",
            "Friction of the steering",
            "The paper of Mohtat et al. claim by claim, and how exact and how soon tierod's own estimator is.",
            _items("friction"),
            {
                "paper": "What the paper says",
                "estimator": "tierod's default estimator",
                "verdict": "tierod's verdict",
                "laws": "Friction laws outside the estimator's model",
            },
        ),
        Study(
            "column",
            "Observers and control of the steering column",
            "The paper of Raffone claim by claim: identification, observability, reduction, observers, control.",
            _items("column"),
            {
                "observability": "Observability by the sensors",
                "reduction": "Reduction of the model",
                "frequency": "Frequency response",
                "identification": "Identification on the bench",
                "torque": "Torque of the driver's hands",
                "hands": "Hands on and off the wheel",
                "natural": "Natural drives",
                "position": "Position control",
            },
        ),
        Study(
            "sideslip",
            "Sideslip from the steering's torque",
            "The paper of Yih, Ryu and Gerdes claim by claim, and how exact its observers and tierod's own are.",
            _items("sideslip"),
            {
                "paper": "What the paper says",
                "observers": "The two observers",
                "combined": "The combined estimator",
                "cars": "A real car",
            },
        ),
        Study(
            "motor-angle",
            "Angle of the steering's motor from its currents",
            "The paper of Reinelt et al. claim by claim, and how exact and how soon tierod watches the motor's sensor.",
            _items("motor_angle"),
            {
                "observers": "The feedforward",
                "operations": "What a step costs",
                "car": "In the car",
                "accuracy": "Motors that differ from the vehicle file",
                "faults": "Faults of the angle sensor",
                "angles": "Which of three angles is wrong",
                "salient": "Salient motors, and loads that step",
                "identified": "Parameters from a drive",
            },
        ),
        Study(
            "condition",
            "Condition of the vehicle's sensors and actuators",
            "The paper of Li, Frey and Gauterin claim by claim, its rules beside tierod's bank of filters.",
            _items("condition"),
            {
                "rules": "The paper's rules",
                "residuals": "The paper's residuals",
                "sensors": "The 48 tests of sensors",
                "actuators": "The tests of actuators",
                "beyond": "More faults, and two at once",
                "uncalibrated": "Vehicles without a calibration",
                "healthy": "Fault-free driving",
                "cars": "Real cars",
            },
        ),
        Study(
            "foreign",
            "Plants of others",
            "Monitors on motulator's drives, CommonRoad's car and a column of its own, worst first.",
            _items("foreign"),
            {
                "cars": "Sensors of CommonRoad's car",
                "friction": "Friction on a foreign column",
                "motors": "Motors of motulator",
            },
        ),
        Study(
            "own-car",
            "Cars without preparation",
            "Virtual cars drawn over the classes and real ones, judged by a brochure and by one identifying drive.",
            _items("own_car"),
            {
                "unknown": "By the brochure alone",
                "identified": "After one drive has identified the car",
                "verdicts": "False verdicts",
                "real": "Real cars",
            },
        ),
        Study(
            "fleet",
            "Fleets over months",
            "False alarms counted on virtual vehicle-years, how soon changes are found, and batches that differ.",
            _items("fleet"),
            {"ramps": "Changes of single cars", "batches": "Cohorts"},
        ),
    )
}
"""All studies by name, as given on the command line."""
