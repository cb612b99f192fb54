"""The study of the motor angle, from the observers of the paper to sensor faults, identification and a real drive."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tierod.core.content import Item
from tierod_lab.papers.motor_angle.reported import SEEDS
from tierod_lab.papers.parts import items_of
from tierod_lab.studies.effort import Effort, Progress

PARTS: Mapping[str, str] = {
    "load_bias": "what an unknown load does",
    "printed": "the observers side by side",
    "table_one": "what a step costs",
    "resistance": "a warmer winding",
    "inverter": "voltages as commanded",
    "figures": "the observers in the car",
    "drawn_motors": "motors that differ from the vehicle file",
    "standing": "standing, and a wrong beginning",
    "temperature": "temperature",
    "sensor_faults": "faults of the angle sensor",
    "three_angles": "which of three angles is wrong",
    "run_length": "time between false alarms",
    "salient": "salient motors, and loads that step",
    "identified": "parameters from a drive",
    "guaranteed": "guaranteed intervals",
    "real_drives": "recordings of a real drive",
}
"""Subject of every part, by name of its module."""


def items(effort: Effort, progress: Progress) -> Iterator[Item]:
    yield from items_of("motor_angle", PARTS, effort, progress)
    yield SEEDS.table()
    progress(1.0, "done")
