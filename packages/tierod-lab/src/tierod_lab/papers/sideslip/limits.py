"""Limits of the observers at low speed: the virtual car with upright kingpins, short tyre relaxation, or both."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

from tierod.core.content import Item, Table
from tierod_lab.papers.sideslip.estimators import NAMES, courses, error
from tierod_lab.papers.sideslip.matching import matched_to
from tierod_lab.papers.sideslip.reported import SEEDS, SIDE_BY_SIDE
from tierod_lab.papers.sideslip.setting import SLOW, driven, virtual_car
from tierod_lab.studies.effort import Effort


def items(effort: Effort) -> Iterator[Item]:
    rows = effort.made(_row, list(_cars()))
    yield Table(
        "What limits the observers at 6.7 m/s: root mean square error on changed virtual cars (degrees)",
        ("car", "matched trail (mm)", *NAMES),
        tuple(rows),
        "Tyres build up their force over a rolled distance, at 6.7 m/s in some 60 ms; no observer of the paper knows "
        "of it. Kingpins that lean inwards lift the car as it is steered; the matched trail takes that in.",
    )


def _row(name: str) -> tuple[str, ...]:
    car = _cars()[name]
    p = matched_to(car, SLOW.speed, SLOW.steer)
    drive = driven(car, SLOW.course(), SEEDS.of(SIDE_BY_SIDE, 1)[0])
    found = courses(p, drive)
    trail = p.mechanical_trail + p.pneumatic_trail
    return name, f"{1e3 * trail:.0f}", *(f"{error(found[each], drive):.3f}" for each in NAMES)


def _cars() -> dict[str, Any]:
    car = virtual_car()
    chassis = car.chassis
    upright = dataclasses.replace(chassis.kingpins, inclination=0.0)
    quick = _following_at_once(chassis)
    return {
        "as it is": car,
        "kingpins upright": dataclasses.replace(car, chassis=dataclasses.replace(chassis, kingpins=upright)),
        "tyres follow at once": dataclasses.replace(car, chassis=quick),
        "both": dataclasses.replace(car, chassis=dataclasses.replace(quick, kingpins=upright)),
    }


def _following_at_once(chassis: Any) -> Any:
    axles = {}
    for name in ("front", "rear"):
        axle = getattr(chassis, name)
        axles[name] = dataclasses.replace(axle, tyre=dataclasses.replace(axle.tyre, lateral_relaxation=0.05))
    return dataclasses.replace(chassis, **axles)
