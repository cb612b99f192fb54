"""A motor on a bench: its rotor against a load, or carried along, as one block."""

from dataclasses import dataclass, field
from typing import NamedTuple

from tierod_lab.ground.motor import AFS_MOTOR, PmMotor, Rotor
from tierod_lab.ground.motor.pm_motor import Senses
from tierod_lab.ground.parts import Port, pass_through


class Acting(NamedTuple):
    request: float
    load: float
    load_damping: float
    locked: float
    carried_speed: float
    sensor: Port


class Mean(NamedTuple):
    mean_torque: float


@dataclass(frozen=True)
class MotorBench:
    motor: PmMotor = field(default_factory=lambda: AFS_MOTOR)
    carried: bool = False
    step_time: float = 1e-3

    Sample = Acting

    def init(self):
        return self.motor.init(), 0.0, 0.0

    def step(self, state, sample):
        drive, angle, kept = state

        def sense(value):
            nonlocal kept
            kept, passed = pass_through(sample.sensor, kept, value)
            return passed

        def load(angle, speed, elapsed):
            return sample.load + sample.load_damping * speed

        if self.carried:
            rotor = Rotor(angle, sample.carried_speed)
            drive, signals, torque = self.motor.torque(drive, rotor, sample.request, self.step_time, Senses(sense))
            angle = angle + self.step_time * sample.carried_speed
        else:
            torque = 0.0
            drive, signals = self.motor.turn(drive, sample.request, self.step_time, load, Senses(sense), sample.locked)
        return (drive, angle, kept), (signals, Mean(torque))
