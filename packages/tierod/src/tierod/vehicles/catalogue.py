"""Catalogue of vehicle parameters: name, unit, meaning and plausible range.

Parameter dataclasses of models and monitors, and vehicle files, use these names.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Quantity:
    """One parameter of a vehicle file."""

    name: str  # of the field in parameter dataclasses
    unit: str  # SI, in the notation of pint; "" for a dimensionless number
    meaning: str  # one sentence fragment, with the point of reference
    # smallest and largest value of a real vehicle, in the unit; others indicate a wrong unit
    plausible: tuple[float, float]
    torque: bool = False  # whether it is a steering torque, which an uncalibrated car gives in counts
    whole: bool = False  # whether it is a whole number, which has no spread


def _catalogue() -> Iterator[Quantity]:
    with Path(__file__).with_name("quantities.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            plausible, kind = (float(row["low"]), float(row["high"])), row["kind"]
            yield Quantity(row["name"], row["unit"], row["meaning"], plausible, kind == "torque", kind == "whole")


QUANTITIES = {quantity.name: quantity for quantity in _catalogue()}  # All parameters of a vehicle file, by name
