"""Detectability and isolability of sensor and actuator faults from the structure of a car's equations."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.content import Cells, Chart, Heading, Item, Panel, Table
from tierod.methods.analysis.structure import (
    Isolability,
    SensorGain,
    StructuralModel,
    decompose,
    gain_of_sensors,
    isolability,
    minimal_redundant_sets,
    minimal_test_sets,
)
from tierod.monitors.condition.signals import ACCELERATIONS, MOTORS, SENSORS
from tierod.monitors.condition.statements import listed
from tierod.monitors.condition.structure import (
    further_sensors,
    rolls,
    vehicle_structure,
)
from tierod.report.analysis.analysis import Analysis
from tierod.report.display import words
from tierod.vehicles import Vehicle, load

SHOWN_SETS = 20
"""Largest number of minimal test sets listed on the page; the document contains all."""

WITH_FORCES = "forces of tyres and tie rods as the model has them"
WITHOUT_FORCES = "forces of tyres and tie rods unknown"
AS_STEERED = "the car turning as it is steered"
ANYHOW = "the car turning anyhow"
"""Names of the views, for a vehicle with known torques and for one without: tyre forces known, or arbitrary."""


def analyse(vehicle: Vehicle | str | Path = "smartload", without: Collection[str] = ()) -> Analysis:
    """Detectable and isolable faults of a vehicle's sensors and actuators, as single and double faults.

    Args:
        vehicle: parameter set, its name, or the path of its file, with the parameters of `AutomatedVehicle` or
            those of `RollingCar`
        without: sensors that the vehicle lacks

    Raises:
        ParameterError: parameters are missing, or a sensor does not exist
    """
    vehicle = vehicle if isinstance(vehicle, Vehicle) else load(vehicle)
    known, view = (AS_STEERED, ANYHOW) if rolls(vehicle) else (WITH_FORCES, WITHOUT_FORCES)
    models = {
        known: vehicle_structure(vehicle, without),
        view: vehicle_structure(vehicle, without, forces_known=False),
    }
    single = {name: isolability(model) for name, model in models.items()}
    pairs = {name: isolability(model, at_once=2) for name, model in models.items()}
    model = models[view]
    gains = gain_of_sensors(model, further_sensors(model), at_once=2)
    sets = minimal_test_sets(model)
    items: list[Item] = [
        Heading("One fault at a time"),
        _table(single),
        _picture(single[view], view),
        Heading("Two faults at a time"),
        _pairs(pairs[view], view),
        Heading("What would help, and what would be missed"),
        _gains(gains, view),
        _missing(model, view),
        Heading("What residuals can be made"),
        _sets(model, sets, view),
    ]
    document = {
        "without": sorted(without),
        "faults": list(single[known].faults),
        "views": {name: _document(models[name], single[name], pairs[name]) for name in models},
        "further_sensors": [_gain_document(gain) for gain in gains],
        "minimal_redundant_sets": len(minimal_redundant_sets(model)),
        "minimal_test_sets": [sorted(each) for each in sets],
    }
    return Analysis(
        f"Isolability of {vehicle.name}",
        _summary(single, pairs, gains),
        items,
        document,
        _remarks(single[known].faults),
    )


def _summary(
    single: dict[str, Isolability], pairs: dict[str, Isolability], gains: Sequence[SensorGain]
) -> tuple[str, ...]:
    lines = []
    for name, found in single.items():
        alike = [group for group in found.groups if len(group) > 1]
        lost = f"; not detectable: {listed(found.undetectable)}" if found.undetectable else ""
        mixed = "; ".join(f"{listed(group)} are not isolable from each other" for group in alike)
        lines.append(
            f"With {name}: {len(found.isolable)} of {len(found.faults)} single faults are isolable{lost}"
            f"{'; ' + mixed if mixed else ''}; of {len(pairs[name].faults)} faults and pairs of them, "
            f"{len(pairs[name].isolable)} are."
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


def _pairs(found: Isolability, view: str) -> Table:
    rows = []
    for fault, seen in zip(found.faults, found.detectable, strict=True):
        others = found.mistaken_for(fault) if seen and " + " in fault else ()
        if others:
            more = f"; and {len(others) - 3} more" if len(others) > 3 else ""
            rows.append((_pair(fault), "; ".join(map(_pair, others[:3])) + more))
    total = sum(" + " in fault for fault in found.faults)
    note = f"{total - len(rows)} of {total} pairs are separable from everything else."
    title = f"Pairs that something else explains, {view}"
    return Table(title, ("pair", "explained by"), tuple(rows) or (("none", ""),), note)


def _pair(name: str) -> str:
    return name.replace("_", " ")


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


def _missing(model: StructuralModel, view: str) -> Table:
    accelerations = [name for name in ACCELERATIONS if name in model.by_name]
    rows = []
    for name in [name for name in SENSORS if name in model.by_name]:
        alone, poorer = (isolability(model.without(name, *more)) for more in ((), accelerations))
        rows.append((words(name), _lost(alone), _lost(poorer)))
    header = ("without", "not separable", "without accelerometers too")
    return Table(f"A car that lacks a sensor, {view}", header, tuple(rows))


def _lost(found: Isolability) -> str:
    alike = "; ".join(listed(group) for group in found.groups if len(group) > 1)
    unseen = f"{listed(found.undetectable)} not seen" if found.undetectable else ""
    return "; ".join(filter(None, (alike, unseen)))


def _sets(model: StructuralModel, sets: Sequence[frozenset[str]], view: str) -> Table:
    rows = tuple((listed(sorted(each)), f"{len(each)}") for each in sets[:SHOWN_SETS])
    note = (
        f"{len(sets)} sets in all{', the smallest shown' if len(sets) > SHOWN_SETS else ''}; the over-determined "
        f"part has {decompose(model).redundancy} more equations than unknowns."
    )
    return Table(f"Smallest sets of faults that affect one residual, {view}", ("residual of", "faults"), rows, note)


def _document(model: StructuralModel, single: Isolability, pairs: Isolability) -> dict[str, Any]:
    return {
        "equations": len(model.equations),
        "unknowns": len(model.unknowns),
        "redundancy": decompose(model).redundancy,
        "detectable": [fault for fault in single.faults if fault not in single.undetectable],
        "isolable": list(single.isolable),
        "not_isolable": [list(group) for group in single.groups if len(group) > 1],
        "single_and_double_faults": len(pairs.faults),
        "single_and_double_faults_isolable": len(pairs.isolable),
    }


def _gain_document(gain: SensorGain) -> dict[str, Any]:
    return {
        "sensor": gain.sensor,
        "more_isolated": gain.isolated_pairs,
        "now_detectable": list(gain.detectable),
        "own_fault_isolable": gain.own_isolable,
    }
