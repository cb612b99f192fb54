"""Signs of the torques, from the work of hands and motor on a car's column, where no motor angle is measured."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from tierod.monitors.harness.related_signals import WRONG_SIGN_SHARE

WORKED: Annotated[float, "N*m"] = 0.5
"""Torque of the bar from which the motor assists; equal to that of the friction monitors' gate."""

LEAST_WORKED: Annotated[float, "s"] = 5.0
"""Least time with such torques for a test. In fault-free drives the torques oppose each other for 3 % of it at most."""

LEAST_WORK: Annotated[float, "J"] = 10.0
"""Work drawn from the steering from which a sign is wrong: a steering only takes work in the long run. An offset does
work only between the first and the last angle: 0.8 N·m over two turns. Fault-free drives take 50 J a minute."""

CORRECT = "correct it in the channel map (factor -1)"


class WorkOverDrive:
    """Work of motor and bar, and time with opposed hands and motor, over the pieces of a recording.

    Args:
        ratio: turns of the motor per turn of the wheel
        rate: sampling rate [Hz]
    """

    def __init__(self, ratio: float, rate: float) -> None:
        self._ratio, self._rate, self._angle = ratio, rate, np.nan
        self._worked = self._opposed = 0
        self._motor = self._bar = self._alone = 0.0

    def add(self, angle: np.ndarray, bar: np.ndarray, motor: np.ndarray) -> None:
        """Add the next piece; NaN where a value is missing.

        Args:
            angle: steering wheel angle [rad], (n,)
            bar: torque of the bar [N*m], (n,)
            motor: torque at the motor's shaft [N*m], (n,)
        """
        worked = (np.abs(bar) > WORKED) & np.isfinite(motor) & (motor != 0.0)
        self._worked += int(np.count_nonzero(worked))
        self._opposed += int(np.count_nonzero(worked & (bar * motor < 0.0)))
        travel = np.diff(angle, prepend=self._angle)
        by_motor, by_bar = self._ratio * motor * travel, bar * travel
        together = np.isfinite(by_motor) & np.isfinite(by_bar)
        self._motor += float(by_motor[together].sum())
        self._bar += float(by_bar[together].sum())
        self._alone += float(by_bar[np.isfinite(by_bar)].sum())
        self._angle = float(angle[-1]) if len(angle) else self._angle

    def wrong_signs(self, motor: str) -> tuple[str, ...]:
        """A sentence for the signal with the wrong sign; none where all signs may be right.

        Args:
            motor: the signal that gave the motor's torque
        """
        share = self._opposed / max(self._worked, 1)
        if self._worked >= LEAST_WORKED * self._rate and share > WRONG_SIGN_SHARE:
            # Hands may pull against a motor that turns the wheel; a motor that only brakes is not an assist.
            name, work = ("driver_torque", self._bar) if self._bar < self._motor else (motor, self._motor)
            drawn = f", and it takes {-work:.0f} J out of the steering" if work < 0.0 else ""
            opposed = f"driver and motor torque oppose each other for {share:.0%} of the time"
            return (f"{name} has the wrong sign: {opposed}{drawn}; {CORRECT}",)
        if self._motor + self._bar < -LEAST_WORK:
            return (
                f"steering_wheel_angle has the wrong sign, or both driver_torque and {motor}: the torques take "
                f"{-self._motor - self._bar:.0f} J out of the steering, which cannot supply energy; {CORRECT}",
            )
        return ()

    def doubts(self) -> tuple[str, ...]:
        """A remark where the bar draws work from the steering; without motor torque no more can be concluded."""
        if self._alone >= -LEAST_WORK:
            return ()
        return (
            f"the hands take {-self._alone:.0f} J out of the steering, as under lane keeping, or with a wrong sign of "
            "driver_torque or steering_wheel_angle",
        )
