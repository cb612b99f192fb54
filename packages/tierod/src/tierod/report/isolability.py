"""Detectability and isolability of sensor and actuator faults from the structure of a car's equations."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.content import Cells, Chart, Heading, Item, Panel, Table
from tierod.methods.analysis.structure import Isolability, SensorGain, gain_of_sensors, isolability
from tierod.monitors.condition.signals import MOTORS, further_sensors, listed, rolls, vehicle_structure
from tierod.report.display import words
from tierod.report.html import Analysis
from tierod.vehicles import Vehicle, load

WITH_FORCES = "forces of tyres and tie rods as the model has them"
WITHOUT_FORCES = "forces of tyres and tie rods unknown"
AS_STEERED = "the car turning as it is steered"
# Names of the views, for a vehicle with known torques and for one without: tyre forces known, or arbitrary
ANYHOW = "the car turning anyhow"


def analyse(vehicle: Vehicle | str | Path = "smartload", without: Collection[str] = ()) -> Analysis:
    """Detectable and isolable faults of a vehicle's sensors and actuators, and what one more sensor would add."""
    vehicle = vehicle if isinstance(vehicle, Vehicle) else load(vehicle)
    known, view = (AS_STEERED, ANYHOW) if rolls(vehicle) else (WITH_FORCES, WITHOUT_FORCES)
    poorer = vehicle_structure(vehicle, without, forces_known=False)
    views = {known: isolability(vehicle_structure(vehicle, without)), view: isolability(poorer)}
    gains = gain_of_sensors(poorer, further_sensors(poorer), at_once=2)
    items: list[Item] = [
        Heading("Which faults can be distinguished"),
        _table(views),
        _picture(views[view], view),
        Heading("Which sensor would help"),
        _gains(gains, view),
    ]
    document = {
        "without": sorted(without),
        "faults": list(views[known].faults),
        "views": {name: _document(found) for name, found in views.items()},
        "further_sensors": [_gain_document(gain) for gain in gains],
    }
    return Analysis(
        f"Isolability of {vehicle.name}", _summary(views, gains), items, document, _remarks(views[known].faults)
    )


def _summary(views: dict[str, Isolability], gains: Sequence[SensorGain]) -> tuple[str, ...]:
    lines = []
    for name, found in views.items():
        alike = [group for group in found.groups if len(group) > 1]
        lost = f"; not detectable: {listed(found.undetectable)}" if found.undetectable else ""
        mixed = "; ".join(f"{listed(group)} are not isolable from each other" for group in alike)
        lines.append(
            f"With {name}: {len(found.isolable)} of {len(found.faults)} faults are isolable{lost}"
            f"{'; ' + mixed if mixed else ''}."
        )
    best = gains[0]
    if best.isolated_pairs or best.detectable:
        lines.append(
            f"The sensor that would help most: {best.sensor}; it separates {best.isolated_pairs} more ordered pairs of "
            "faults and double faults."
        )
    return tuple(lines)


def _remarks(faults: Collection[str]) -> tuple[str, ...]:
    motors = (
        "Two steering motors act by their sum. An alternating split of the torque separates them over time; the "
        "structural analysis does not include this.",
    )
    return (
        "The structural analysis considers which variable is in which equation, not its size: a fault that is "
        "isolable here can still be too small to be detected, or the drive too quiet. Results of drives are in "
        "docs/explanation/condition.md.",
        *(motors if MOTORS[0] in faults else ()),
    )


def _table(views: dict[str, Isolability]) -> Table:
    rows = []
    for place, fault in enumerate(next(iter(views.values())).faults):
        verdicts = []
        for found in views.values():
            others = found.mistaken_for(fault)
            verdicts.append(
                "not seen"
                if not found.detectable[place]
                else f"not separable from {listed(others)}"
                if others
                else "isolable"
            )
        rows.append((words(fault), *verdicts))
    return Table("Single faults", ("fault", *views), tuple(rows))


def _picture(found: Isolability, view: str) -> Chart:
    names = [words(fault) for fault in found.faults]
    shares = np.where(found.detectable[:, None], found.mistaken, np.nan).astype(float)
    cells = Cells("explains it", names, names, shares)
    return Chart(
        "isolability",
        f"Which fault explains which, {view}",
        "Row: the present fault. Filled cell: a fault that explains all its effects on the sensors. If only the "
        "diagonal is filled, every fault is separable from every other.",
        "Matrix of faults against their explanations; same content as the tables above.",
        (Panel("", "explanation", "fault", (cells,)),),
    )


def _gains(gains: Sequence[SensorGain], view: str) -> Table:
    rows = tuple(
        (
            words(gain.sensor),
            f"{gain.isolated_pairs}",
            listed(gain.detectable) if gain.detectable else "",
            "yes" if gain.own_isolable else "no",
        )
        for gain in gains
    )
    header = ("one more sensor", "more separated", "now seen", "own fault isolable")
    note = "Ordered pairs among all single and double faults that only this sensor would separate."
    return Table(f"What one more sensor would add, {view}", header, rows, note)


def _document(found: Isolability) -> dict[str, Any]:
    return {
        "detectable": [fault for fault in found.faults if fault not in found.undetectable],
        "isolable": list(found.isolable),
        "not_isolable": [list(group) for group in found.groups if len(group) > 1],
    }


def _gain_document(gain: SensorGain) -> dict[str, Any]:
    return {
        "sensor": gain.sensor,
        "more_isolated": gain.isolated_pairs,
        "now_detectable": list(gain.detectable),
        "own_fault_isolable": gain.own_isolable,
    }
