"""Made-up filters of a bank that know every sensor's truth but the speed, and a drive for them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tierod.core.block import skeleton
from tierod.core.graph import Bank
from tierod.core.graph.maths import both, log, present, sqrt, where
from tierod.monitors.condition.decision import Decision
from tierod.monitors.condition.judge import ConditionJudge
from tierod.monitors.condition.kinds import KindOfFault
from tierod.monitors.condition.reaction import FaultReaction, Reconfiguration
from tierod.monitors.condition.signals import OF_AUTOMATED, ConditionSample, Hypothesis, Readings
from tierod.monitors.condition.vehicle_filter import LeaveOutFilter
from tierod.monitors.condition.weighing import Limits, Weighing
from tierod.vehicles import load

LEFT, RIGHT, YAW, ANGLE, TORQUE, FORCE = OF_AUTOMATED
MOTOR_1, MOTOR_2 = "steering_motor_1", "steering_motor_2"
HYPOTHESES = (
    Hypothesis("healthy"),
    *(Hypothesis(name, (name,)) for name in (LEFT, RIGHT, TORQUE)),
    *(Hypothesis(name, (), (name,)) for name in (MOTOR_1, MOTOR_2)),
    Hypothesis("both wheels", (LEFT, RIGHT)),
    Hypothesis("left and motor 1", (LEFT,), (MOTOR_1,)),
)
NOISE, WIDTH = (0.03, 0.03, 0.003, 0.01, 0.1, 20.0), (30.0, 30.0, 4.0, 16.0, 60.0, 4000.0)
RATE = 100.0


@dataclass(frozen=True)
class Lane:
    """The speed is estimated from the wheels that are used, all else is known; one share of torque may be lost."""

    use_left: float = 1.0
    use_right: float = 1.0
    use_torque: float = 1.0
    trust_1: float = 1.0
    trust_2: float = 1.0
    wander: float = 0.01
    Sample = ConditionSample

    def init(self):
        return 10.0, 0.0, 0.5

    def step(self, state, sample):
        speed, loss, variance = state
        speed = speed + where(present(sample.longitudinal_acceleration), sample.longitudinal_acceleration, 0.0) / RATE
        asked = sample.steering_motor_1_target_torque, sample.steering_motor_2_target_torque
        lost = where(self.trust_1 > 0.5, 0.0, asked[0]) + where(self.trust_2 > 0.5, 0.0, asked[1])
        torque = asked[0] + asked[1] - loss * lost
        expected = Readings(speed, speed, sample.target_steering_wheel_angle, 1.0, torque, 500.0, 0.0, 0.0)
        uses = (self.use_left, self.use_right, 1.0, 1.0, self.use_torque, 1.0)
        used = [both(present(reading), use > 0.5) for reading, use in zip(sample, uses, strict=False)]
        off = [where(use, y - value, 0.0) for use, y, value in zip(used, sample, expected, strict=False)]
        spread = [noise * noise for noise in NOISE]
        spread[4] = spread[4] + variance * lost * lost
        likelihood = 0.0
        for use, reading, error, square, width in zip(used, sample, off, spread, WIDTH, strict=False):
            inside = -0.5 * (error * error / square + log(2.0 * math.pi * square))
            likelihood = likelihood + where(use, inside, where(present(reading), -log(width), 0.0))
        speed = speed + 0.2 * (off[0] + off[1])
        gain = where(used[4], variance * lost / spread[4], 0.0)
        loss, variance = loss - gain * off[4], (1.0 - gain * lost) * variance + self.wander
        after = Readings(speed, speed, *expected[2:])
        output = skeleton(LeaveOutFilter.Output)._replace(
            log_likelihood=likelihood,
            prediction=expected,
            deviation=Readings(*NOISE, 1.0, 1.0),
            estimate=after,
            torque_loss=loss,
            loss_deviation=sqrt(variance),
            speed=speed,
            moving=where(speed > 0.5, 1.0, 0.0),
            driven=where(sample.longitudinal_acceleration < -8.0, 0.0, 1.0),
        )
        return (speed, loss, variance), output


def lane(hypothesis):
    uses = {f"use_{short}": 0.0 for short, name in zip(("left", "right", "torque"), (LEFT, RIGHT, TORQUE), strict=True)
            if name in hypothesis.sensors}  # fmt: skip
    trusts = {f"trust_{name[-1]}": 0.0 for name in hypothesis.actuators}
    return Lane(**uses, **trusts)


def healthy_drive():
    """Ten seconds at 10 m/s; the torque is split unequally, by turns."""
    time, chance = np.arange(1000) / RATE, np.random.default_rng(5)
    swing = np.where(time % 0.24 < 0.12, 0.65, 0.35)
    total = 4.0 + 2.0 * np.sin(time)
    values = np.zeros((1000, len(ConditionSample._fields)))
    values[:, :2], values[:, 3], values[:, 5] = 10.0, 1.0, 500.0
    values[:, 12] = values[:, 2] = 0.3 * np.sin(0.5 * time)
    values[:, 4], values[:, 8], values[:, 9] = total, swing * total, (1.0 - swing) * total
    values[:, :6] += chance.normal(size=(1000, 6)) * NOISE
    return values


def column(name):
    return ConditionSample._fields.index(name)


def decision_of(hypotheses=HYPOTHESES, fast=3.0):
    count = len(hypotheses) - 1
    return Decision(Weighing(hypotheses, Limits((fast,) * count, (1.0,) * count, gap=1.0, margin=1.0)))


def judged_bank():
    """The made-up lanes with the whole judge of the monitor."""
    reaction = FaultReaction.of(Reconfiguration.of_vehicle(load("smartload")))
    kinds = tuple(KindOfFault.of_sensor(name) for name in OF_AUTOMATED)
    return Bank(tuple(map(lane, HYPOTHESES)), ConditionJudge(decision_of(), kinds, reaction))
