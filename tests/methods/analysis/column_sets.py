"""Linear columns of the parameter sets that have the eigenvalues of Raffone's Table 3."""

from tierod.models.linear import linearise
from tierod.models.steering_column import ColumnInput, SteeringColumn
from tierod_lab.papers.column.columns import SETS

TORQUES = ("hand_torque", "disturbance_torque")


def column(name="S1"):
    return linearise(SteeringColumn, SETS[name], SteeringColumn.State(*[0.0] * 6), ColumnInput(0.0, 0.0, 0.0))
