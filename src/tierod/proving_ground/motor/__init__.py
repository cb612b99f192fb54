"""A permanent-magnet motor with its inverter, current control and winding temperature, at a rate of its own."""

from tierod.proving_ground.motor.current_control import CurrentControl
from tierod.proving_ground.motor.machine import Inverter, Machine, Warming
from tierod.proving_ground.motor.period import Rotor
from tierod.proving_ground.motor.pm_motor import DriveState, PmMotor
from tierod.proving_ground.motor.presets import AFS_MOTOR, EPS_MOTOR

__all__ = [
    "AFS_MOTOR",
    "EPS_MOTOR",
    "CurrentControl",
    "DriveState",
    "Inverter",
    "Machine",
    "PmMotor",
    "Rotor",
    "Warming",
]
