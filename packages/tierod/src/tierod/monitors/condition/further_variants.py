"""Further variants of the monitor from optional packages, which are looked up by name."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from tierod.core.recording import Recording
from tierod.monitors.harness.session import Variant
from tierod.vehicles import Vehicle

Table: TypeAlias = Mapping[str, float | str | Mapping[str, float]]
"""Table of thresholds in a vehicle file."""

_VARIANTS = "tierod_lab.papers.condition.rules.definition:VARIANTS"
_CALIBRATION = "tierod_lab.papers.condition.rules.definition:calibrated_tables"


def further_variants() -> Mapping[str, Variant]:
    """Further variants by name: the rules of the paper; empty if the package is not installed."""
    return _found(_VARIANTS) or {}


def further_calibration() -> Callable[[Vehicle, Sequence[Recording], Sequence[Recording], str], Mapping[str, Table]]:
    """Calibration of the further variants: (vehicle, drives to fit, drives for limits, source) -> tables by name."""
    return _found(_CALIBRATION) or (lambda vehicle, fitted, healthy, source: {})


def _found(place: str) -> Any:
    """Object at "package.module:name"; None where the package is not installed."""
    module, _, name = place.partition(":")
    try:
        return getattr(importlib.import_module(module), name)
    except ModuleNotFoundError as error:
        # Only the absence of the package itself is expected; a missing import inside of it is an error.
        if error.name is not None and (module == error.name or module.startswith(f"{error.name}.")):
            return None
        raise
