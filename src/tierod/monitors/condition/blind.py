"""Faults that are not observable with the sensors of a car and its recording, by the structure of the equations."""

from __future__ import annotations

from collections.abc import Collection

from tierod.methods.analysis.structure import Isolability, isolability
from tierod.monitors.condition.statements import listed
from tierod.monitors.condition.structure import vehicle_structure
from tierod.vehicles import Vehicle

SHOWN = 3
"""Pairs that are named; 'tierod isolability' shows all."""


def limitations(vehicle: Vehicle, missing: Collection[str]) -> tuple[str, ...]:
    """Which faults are not detectable or not isolable without some sensors, in sentences.

    Args:
        vehicle: that is judged
        missing: sensors that the recording lacks, accelerations included
    """
    model = vehicle_structure(vehicle, missing)
    single, pairs = isolability(model), isolability(model, at_once=2)
    lack = f"without {listed(sorted(missing))}, " if missing else ""
    unseen, alike = single.undetectable, [group for group in single.groups if len(group) > 1]
    notes = [f"{lack}faults of {listed(unseen)} do not show in any equation"] if unseen else []
    notes += [f"{lack}faults of {listed(group)} are not told apart" for group in alike]
    if not notes and single.faults:
        notes = [f"{lack}single faults of {listed(single.faults)} are still told apart by the equations"]
    return (*notes, *_double(pairs))


def _double(pairs: Isolability) -> tuple[str, ...]:
    """Of two faults at once, those that something else explains as well."""
    both = [name for name in pairs.faults if " + " in name]
    mixed = [name for name in both if name not in pairs.isolable]
    if not mixed:
        return ()
    named = "; ".join(f"{_plain(name)} look like {_plain(_other(pairs, name))}" for name in mixed[:SHOWN])
    more = f"; and {len(mixed) - SHOWN} more" if len(mixed) > SHOWN else ""
    return (f"of {len(both)} pairs of faults {len(mixed)} are not told from others: {named}{more}",)


def _other(pairs: Isolability, name: str) -> str:
    others = pairs.mistaken_for(name)
    return others[0] if others else "nothing at all"


def _plain(name: str) -> str:
    return listed(name.split(" + "))
