"""Motors with typical numbers; no paper prints a whole set."""

from __future__ import annotations

from tierod.proving_ground.motor.current_control import CurrentControl
from tierod.proving_ground.motor.machine import Machine
from tierod.proving_ground.motor.pm_motor import PmMotor

AFS_MOTOR = PmMotor(machine=Machine(friction=0.3))
"""Of an active front steering, as those of Reinelt et al. in kind; most of the dry friction is that of its worm."""

EPS_MOTOR = PmMotor(
    machine=Machine(
        resistance=0.016,
        inductance_d=7e-5,
        inductance_q=9e-5,
        flux=0.0083,
        inertia=1.5e-4,
        damping=3e-4,
        friction=0.03,
        cogging=0.015,
    ),
    control=CurrentControl(
        resistance=0.016, inductance_d=7e-5, inductance_q=9e-5, flux=0.0083, lag=4e-4, current_limit=80.0
    ),
)
"""Of an electric power steering: 4 N*m, slightly salient; 0.05 N*m/A as in Mohtat et al."""
