"""A motor on a bench: its rotor against a load, or carried along, as one block."""

from dataclasses import dataclass, field
from typing import NamedTuple

from tierod.proving_ground.motor import AFS_MOTOR, PmMotor, Rotor
from tierod.proving_ground.parts import Port


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
        return self.motor.init(), 0.0

    def step(self, state, sample):
        drive, angle = state
        if self.carried:
            rotor = Rotor(angle, sample.carried_speed)
            drive, signals, torque = self.motor.torque(drive, rotor, sample.request, self.step_time, sample.sensor)
            return (drive, angle + self.step_time * sample.carried_speed), (signals, Mean(torque))

        def load(angle, speed, elapsed):
            return sample.load + sample.load_damping * speed

        drive, signals = self.motor.turn(drive, sample.request, self.step_time, load, sample.sensor, sample.locked)
        return (drive, angle), (signals, Mean(0.0))
