"""Three columns that have the eigenvalues of Raffone's Table 3, all ten digits.

The table fixes five numbers, the model has eight parameters: a family of sets along torsion bar, ratio and inertia of
the wheel is left. S1 has a typical torsion bar of 2.4 N m per degree and is what tierod ships as `column-bench`; S3 has
a softer one.
"""

from __future__ import annotations

from collections.abc import Mapping

from tierod.models.steering_column import ColumnParameters
from tierod.vehicles import load

SETS: Mapping[str, ColumnParameters] = {
    "S1": load("column-bench").parameters_for(ColumnParameters),
    "S2": ColumnParameters(
        steering_wheel_inertia=0.04,
        steering_wheel_damping=0.4215405411,
        torsion_bar_stiffness=120.0,
        motor_ratio=20.0,
        gear_stiffness=5.631209168,
        gear_inertia=5.629395913e-3,
        motor_inertia=6.915951086e-5,
        motor_damping=4.314438831e-4,
    ),
    "S3": ColumnParameters(
        steering_wheel_inertia=0.032,
        steering_wheel_damping=0.2849700635,
        torsion_bar_stiffness=80.0,
        motor_ratio=12.0,
        gear_stiffness=7.453333774,
        gear_inertia=2.635128442e-3,
        motor_inertia=1.134302023e-4,
        motor_damping=8.928757445e-4,
    ),
}
"""By name."""

EIGENVALUES = (
    -0.491074732452 + 706.750702094704j,
    -0.491074732452 - 706.750702094704j,
    -0.000000000001 + 0.0j,
    -8.114907494361 + 0.0j,
    -3.839922431729 + 79.657898579634j,
    -3.839922431729 - 79.657898579634j,
)
"""Table 3."""
