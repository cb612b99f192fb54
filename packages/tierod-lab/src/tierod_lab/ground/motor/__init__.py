"""Permanent-magnet motor with inverter, current control and winding temperature, at its own sampling rate."""

from tierod_lab.ground.motor.control import CurrentControl
from tierod_lab.ground.motor.machine import Inverter, Machine, Rotor, Warming
from tierod_lab.ground.motor.pm_motor import AFS_MOTOR, EPS_MOTOR, DriveState, PmMotor

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
