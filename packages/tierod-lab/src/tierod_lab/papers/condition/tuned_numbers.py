"""The tuning of the bank of filters as a list of numbers, each with its places in the bank and its reason."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from tierod.core.block import tuning, with_tuning
from tierod.core.graph import Bank
from tierod.core.graph.bank import BankGraph
from tierod.core.graph.derivatives import tuning_in_use
from tierod.core.graph.trace import trace
from tierod.export.subject import described, meanings
from tierod.monitors.condition.signals import Sensor

COUNTS = ("samples", "samples_of_actuators", "samples_of_both_motors", "proofs", "fewest", "remaining")
"""Fields that count samples or sensors; they change by at least one, since smaller changes would have no effect."""

BY_SENSOR = {"sensor_noise": "noise", "plausible": "plausible", "growth": "growth"}
"""Field with one number per sensor -> column of the sensor table that gives the number."""

ALIKE = "likewise"
"""First word of a description that repeats that of the field before."""

FLAGS = "trusted"
"""Field with the elements that a lane uses as flags 1 or 0: part of the hypothesis, not of the tuning."""


class Number(NamedTuple):
    """A number of the tuning.

    Args:
        name: dotted name without the indices of lanes, sensors and hypotheses
        values: its values in the bank; several where it differs between sensors or hypotheses
        places: indices of these values in `tuning` of the bank
        reason: description of its field
        used: whether the graph of the bank depends on it
    """

    name: str
    values: tuple[float, ...]
    places: tuple[int, ...]
    reason: str
    used: bool

    @property
    def off(self) -> bool:
        """Whether all values are zero or infinite, so that a factor has no effect."""
        return all(value == 0.0 or not math.isfinite(value) for value in self.values)

    def scaled(self, factor: float) -> tuple[float, ...]:
        """The values times a factor; a count is rounded away from its value to a whole number."""
        if self.name.rpartition(".")[2] in COUNTS:
            rounded = math.floor if factor < 1.0 else math.ceil
            return tuple(float(rounded(factor * value)) for value in self.values)
        return tuple(factor * value for value in self.values)


def numbers_of(bank: Bank) -> list[Number]:
    """The tuning of a bank; a number that differs between lanes is listed once per value.

    Parameters of the vehicle, sampling intervals and the signals that a lane leaves out are no tuning.

    Args:
        bank: the monitor
    """
    known, used = {**_meanings("lanes", bank.lanes[0]), **_meanings("judge", bank.judge)}, _in_use(bank)
    groups: dict[tuple[str, float | None], list[int]] = {}
    values = [value for _, value in tuning(bank)]
    for place, (path, value) in enumerate(tuning(bank)):
        name = _without_digits(path)
        if not is_given(name):
            groups.setdefault((name, value if path.startswith("lanes.") else None), []).append(place)
    several = {name for name, _ in groups if sum(other == name for other, _ in groups) > 1}
    return [
        Number(
            f"{name}, {len(places)} of {len(bank.lanes)} lanes" if name in several else name,
            tuple(dict.fromkeys(values[place] for place in places)),
            tuple(places),
            known.get(name, ""),
            name in used,
        )
        for (name, _), places in groups.items()
    ]


def varied(bank: Bank, number: Number, factor: float) -> Bank:
    """The bank with one of its numbers multiplied by a factor.

    Args:
        bank: the monitor
        number: the number
        factor: factor on all its values
    """
    values = [value for _, value in tuning(bank)]
    scaled = dict(zip(number.values, number.scaled(factor), strict=True))
    for place in number.places:
        values[place] = scaled[values[place]]
    changed: Bank = with_tuning(bank, values)
    return changed


def is_given(name: str) -> bool:
    """Whether a float is no tuning but given by vehicle file, sampling interval or hypothesis."""
    *above, last = name.split(".")
    return last == "sample_time" or FLAGS in above or ("vehicle" in above and "fading" not in above)


def _without_digits(path: str) -> str:
    return ".".join(part for part in path.split(".") if not part.isdigit())


def _in_use(bank: Bank) -> set[str]:
    graph = trace(bank)
    assert isinstance(graph, BankGraph)
    used = [f"lanes.{name}" for name in tuning_in_use(graph.lane)]
    return {_without_digits(name) for name in (*used, *(f"judge.{name}" for name in tuning_in_use(graph.judge)))}


def _meanings(prefix: str, block: object) -> Mapping[str, str]:
    of_sensors = meanings(Sensor)
    found: dict[str, str] = {}
    before = ""
    for each in described(block, prefix):
        name = _without_digits(each.path)
        column = next((BY_SENSOR[part] for part in name.split(".") if part in BY_SENSOR), "")
        text = of_sensors[column] if column else each.meaning
        alike = text.startswith(ALIKE)
        found.setdefault(name, f"{before}; {text}" if alike else text)
        before = before if alike else first_clause(text).partition(":")[0]
    return found


def first_clause(text: str) -> str:
    """A description up to its first semicolon or full stop; one with "likewise" keeps the repeated part."""
    before, alike, rest = text.partition(f"; {ALIKE}")
    if alike:
        return f"{before}{alike}{first_clause(rest)}"
    return text.partition("; ")[0].partition(". ")[0].rstrip(".")
