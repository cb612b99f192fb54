"""The paper's observers as variants of the monitor of the motor's angle; the package registers each of them.

Source: Reinelt, Lundquist, Johansson, SAE 2005-01-1271.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any

from tierod.core.block import Block, Tree
from tierod.methods.detectors.control_charts import Cusum
from tierod.models.stator_frame_motor import MotorParameters, SampledMotorParameters
from tierod.monitors.baseline import Baseline
from tierod.monitors.motor_angle.definition import DECISIONS, PAPER, MotorAngleMonitor, MotorAngleSession, required
from tierod.monitors.motor_angle.observer import MEASURED, MotorAngleObserver, MotorAngleTuning
from tierod.monitors.session import Conclusion, Variant
from tierod.vehicles import Vehicle
from tierod_lab.papers.motor_angle.observers import (
    FeedforwardAngle,
    RotorFrameObserver,
    extended_kalman,
    luenberger,
    reduced_luenberger,
)


@dataclass(frozen=True)
class PrintedMotorObserver:
    """An observer of the paper in the place of the default one.

    Resistance and flux are those of the vehicle file, and no noise of the angle is estimated: its deviation is zero.
    """

    observer: Block
    parameters: SampledMotorParameters
    tuning: MotorAngleTuning

    Sample = MotorAngleObserver.Sample
    commanded = False

    def init(self) -> Tree:
        return self.observer.init()

    def step(self, state: Tree, sample: MotorAngleObserver.Sample) -> tuple[Tree, MotorAngleObserver.Output]:
        after, found = self.observer.step(state, sample)
        p = self.parameters
        return after, MotorAngleObserver.Output(
            motor_angle=found.motor_angle,
            motor_angle_standard_deviation=0.0,
            motor_speed=found.motor_speed,
            motor_load_torque=getattr(found, "motor_load_torque", 0.0),
            motor_resistance=p.motor_resistance,
            motor_flux=p.motor_flux,
            angle_residual_electrical=found.angle_residual_electrical,
            inverter_voltage_loss=0.0,
            inverter_knee_current=0.0,
            inverter_knee_deviation=0.0,
            standing=getattr(found, "standing", 0.0),
            nis=getattr(found, "nis", 0.0),
        )


SPEED: Annotated[float, "rad/s"] = 2.0
"""Half of the smallest difference of increments over 10 ms that deserves an alarm. With three times as much as
threshold, the sum of twelve fault-free drives of the bench, which reaches 5 rad/s, raises none."""
DRIFTING: Annotated[float, "rad"] = math.pi
"""Drift of the sum of the residual of an integrated angle, beyond which no residual lies: it drifts by itself, so that
only its increments show a fault."""


def monitor_with(observer: Block, vehicle: Vehicle, sample_time: float) -> MotorAngleMonitor:
    """The monitor of a motor's sensor with an observer of the paper."""
    usual = MotorAngleMonitor.of_vehicle(vehicle, sample_time)
    printed: Any = PrintedMotorObserver(observer, usual.observer.parameters, usual.observer.tuning)
    compared = replace(usual.comparison, speed=Cusum(SPEED, 3.0 * SPEED, 6.0 * SPEED))
    if isinstance(observer, RotorFrameObserver):
        compared = replace(compared, angle=Cusum(DRIFTING, DRIFTING, DRIFTING))
    return replace(usual, observer=printed, comparison=compared)


class PrintedSession(MotorAngleSession):
    """The session of the monitor with an observer of the paper."""

    def __init__(self, name: str, observer: Block, vehicle: Vehicle, rate: float):
        super().__init__(monitor_with(observer, vehicle, 1.0 / rate), vehicle, rate)
        self.name = name

    def conclude(self) -> Conclusion:
        found = super().conclude()
        return replace(found, verdict=replace(found.verdict, monitor=f"motor-angle, {self.name}"))


Make = Callable[[Vehicle, float], Block]


def _variant(name: str, summary: str, equations: str, make: Make) -> Variant:
    def opened(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> PrintedSession:
        return PrintedSession(name, make(vehicle, 1.0 / rate), vehicle, rate)

    decided = tuple(each for each in DECISIONS if each.name not in ("angle", "speed"))
    return Variant(name, summary, f"{PAPER}, {equations}", opened, decided, required=required(MEASURED))


def _in_rotor_frame(make: Callable[[MotorParameters, float], Block]) -> Make:
    return lambda vehicle, sample_time: make(vehicle.parameters_for(MotorParameters), sample_time)


def _feedforward(vehicle: Vehicle, sample_time: float) -> FeedforwardAngle:
    return FeedforwardAngle(replace(vehicle.parameters_for(SampledMotorParameters), sample_time=sample_time))


LUENBERGER = _variant(
    "luenberger",
    "Luenberger observer of current, speed and load; its angle drifts, so that increments are compared.",
    "eqs (19) to (24), with the load as a state",
    _in_rotor_frame(luenberger),
)
REDUCED_LUENBERGER = _variant(
    "reduced-luenberger",
    "The same without the current as a state; its angle drifts, so that increments are compared.",
    "eqs (25) to (33), with the load as a state",
    _in_rotor_frame(reduced_luenberger),
)
EXTENDED_KALMAN = _variant(
    "extended-kalman",
    "Kalman filter of currents, speed and load in the rotor's axes; its angle drifts, so that increments are compared.",
    "eqs (34) to (45), with the load as a state",
    _in_rotor_frame(extended_kalman),
)
FEEDFORWARD = _variant(
    "feedforward",
    "Direction of the back-EMF; the angle is held below 6 rad/s.",
    "eq (46)",
    _feedforward,
)
