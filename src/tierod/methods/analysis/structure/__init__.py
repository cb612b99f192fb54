"""What can be told from the structure of equations alone: redundancy, detectable and isolable faults."""

from tierod.methods.analysis.structure.decomposition import Decomposition, decompose, overdetermined
from tierod.methods.analysis.structure.isolability import Isolability, SensorGain, gain_of_sensors, isolability
from tierod.methods.analysis.structure.of_model import structure_of
from tierod.methods.analysis.structure.redundant_sets import minimal_redundant_sets, minimal_test_sets
from tierod.methods.analysis.structure.structural_model import Equation, StructuralModel

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
