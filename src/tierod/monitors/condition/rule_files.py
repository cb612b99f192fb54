"""The rule files that come with the condition monitor, and those of a user."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from tierod.diagnosis.symptom_files import read_table
from tierod.diagnosis.symptoms import SymptomTable
from tierod.monitors.condition.residuals.catalogue import RESIDUALS
from tierod.monitors.condition.signals import ACTUATORS, SENSORS

FOLDER = Path(__file__).with_name("rules")
"""Where the shipped files are."""

FILES = {"rules-printed": "printed", "rules": "corrected", "rules-discriminating": "discriminating"}
"""Variant of the monitor and name of its file."""


@lru_cache(maxsize=16)
def rules(variant_or_path: str) -> SymptomTable:
    """The rules of a variant, or of a file of one's own.

    Args:
        variant_or_path: "rules", "rules-printed", "rules-discriminating", or the path of a rule file (.toml)

    Raises:
        ParameterError: the file cannot be read or has a slip in it
    """
    name = FILES.get(variant_or_path)
    path = FOLDER / f"{name}.toml" if name else Path(variant_or_path)
    return read_table(path, tuple(RESIDUALS), (*SENSORS, *ACTUATORS))
