"""Structural analysis of a model from the incidence of its equations: redundancy, detectable and isolable faults."""

from tierod.methods.analysis.structure.isolability import (
    Isolability,
    SensorGain,
    gain_of_sensors,
    isolability,
    overdetermined,
)
from tierod.methods.analysis.structure.structural_model import Equation, StructuralModel, structure_of

__all__ = [
    "Equation",
    "Isolability",
    "SensorGain",
    "StructuralModel",
    "gain_of_sensors",
    "isolability",
    "overdetermined",
    "structure_of",
]
