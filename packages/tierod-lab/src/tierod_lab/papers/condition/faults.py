"""Injected faults: element, kind, size and time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

from tierod_lab.ground.faults import (
    Delay,
    Drift,
    Fault,
    Gain,
    Noise,
    Offset,
    Outlier,
    Stuck,
    TorqueLoss,
    TotalLoss,
)
from tierod_lab.ground.faults.fault import AtTime

LOSS, STUCK, OFFSET, GAIN, DRIFT, OUTLIER, NOISE, DELAY = (
    *("loss", "stuck", "offset", "gain", "drift", "outlier", "noise", "delay"),
)
KINDS = (LOSS, STUCK, OFFSET, GAIN, DRIFT, OUTLIER, NOISE, DELAY)
"""Kinds of sensor faults; an actuator has losses only."""

OFFSETS = {
    "wheel_speed_rear_left": 2.0,
    "wheel_speed_rear_right": 2.0,
    "yaw_rate": 0.3,
    "steering_wheel_angle": 1.5,
    "steering_shaft_torque": 3.0,
    "tie_rod_force": 250.0,
}
"""Offset of every sensor in the tests, in the unit of its signal; the paper prints none."""

OUTLIER_FACTOR = 3.0
"""Factor on the signal during an outlier of one second; the paper prints none."""

TORQUES = {
    "steering_motor_1": "steering_motor_1_torque",
    "steering_motor_2": "steering_motor_2_torque",
    "drive_left": "drive_torque_left",
    "drive_right": "drive_torque_right",
}
"""Actuator -> channel of its torque."""

TARGETS = {
    "steering_motor_1": "steering_motor_1_target_torque",
    "steering_motor_2": "steering_motor_2_target_torque",
    "drive_left": "target_drive_torque_left",
    "drive_right": "target_drive_torque_right",
}
"""Actuator -> channel of its commanded torque."""

_READ_IN_THE_LOOP = ("wheel_speed_rear_left", "wheel_speed_rear_right", "yaw_rate", "steering_wheel_angle")


@dataclass(frozen=True)
class Injected:
    """One injected fault of a drive, the truth for its score.

    Args:
        element: signal of a sensor, or name of an actuator ("steering_motor_1")
        kind: one of `KINDS`
        size: fault magnitude: offset in the unit of the signal, factor of a gain or outlier, drift per second, standard
            deviation of noise, delay in seconds, lost share of an actuator's torque; NaN for a kind without one
        start, end: beginning and end of the fault
        in_the_loop: whether the automated driver uses the faulty reading, as well as the recording
    """

    element: str
    kind: str
    size: float = math.nan
    start: Annotated[float, "s"] = 20.0
    end: Annotated[float, "s"] = 40.0
    in_the_loop: bool = False

    @property
    def name(self) -> str:
        """Element, kind and size, for tables."""
        size = "" if math.isnan(self.size) else f" {self.size:g}"
        return f"{self.element} {self.kind}{size}"

    @property
    def in_recording_alone(self) -> bool:
        """Whether the fault affects the recording alone, as in a sensor that no controller uses."""
        return self.element not in TORQUES and not (self.in_the_loop and self.element in _READ_IN_THE_LOOP)

    @property
    def fault(self) -> Fault:
        """The fault as an object of the proving ground."""
        lasts, trigger = self.end - self.start, AtTime(self.start)
        if self.element in TORQUES:
            return Fault(f"actuator.{TORQUES[self.element]}", TorqueLoss(self.size), trigger, lasts)
        prefix = "sensor." if self.in_recording_alone else ""
        return Fault(f"{prefix}{self.element}", self._behaviour, trigger, lasts)

    @property
    def _behaviour(self) -> Any:
        if self.kind == LOSS:
            return TotalLoss()
        if self.kind == STUCK:
            return Stuck()
        sized = {OFFSET: Offset, GAIN: Gain, DRIFT: Drift, OUTLIER: Outlier, NOISE: Noise, DELAY: Delay}
        return sized[self.kind](self.size)


def lost(actuator: str, share: float = 1.0, start: float = 104.0, end: float = 200.0) -> Injected:
    """A loss of torque of an actuator.

    Args:
        actuator: its name
        share: lost share of the torque [-]
        start, end: beginning and end of the fault [s]; by default those of Figures 12 to 17 of Li, Frey, Gauterin
    """
    return Injected(actuator, LOSS, share, start, end)
