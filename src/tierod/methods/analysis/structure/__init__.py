"""Structural analysis of a model from the incidence of its equations: redundancy, detectable and isolable faults."""

from tierod.methods.analysis.structure.isolability import Isolability, SensorGain, gain_of_sensors, isolability
from tierod.methods.analysis.structure.redundancy import (
    Decomposition,
    decompose,
    minimal_redundant_sets,
    minimal_test_sets,
    overdetermined,
)
from tierod.methods.analysis.structure.structural_model import Equation, StructuralModel, structure_of

__all__ = [
    "Decomposition",
    "Equation",
    "Isolability",
    "SensorGain",
    "StructuralModel",
    "decompose",
    "gain_of_sensors",
    "isolability",
    "minimal_redundant_sets",
    "minimal_test_sets",
    "overdetermined",
    "structure_of",
]
