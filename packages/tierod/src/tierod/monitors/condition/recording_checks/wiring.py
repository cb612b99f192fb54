"""Wrong wiring, scale or time base from the start, and a clock that leaps during the drive: no faults of sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tierod.core.findings import Episode
from tierod.monitors.condition.recording_checks.contradictions import STEP, Problem, late, misread_speed, scaled, turned
from tierod.monitors.condition.recording_checks.witnesses import (
    MOVING,
    OVER_SPEED,
    TORQUE,
    UNDERSTEERING,
    YAW,
    Witness,
    mean_speed,
)
from tierod.monitors.condition.signals import OF_AUTOMATED, SENSORS, CarParameters

GENTLE = 3.0
"""Largest lateral acceleration at which the steering angle gives the yaw rate by geometry [m/s^2]."""
LEAST_TURNING = 5.0
"""Least time of turning in each part of the beginning [s]."""
PARTS = 3
"""Number of parts of the beginning, each of which must show the same problem."""
TURNING = 0.05
"""Yaw rate from which the vehicle counts as turning [rad/s]."""
KEPT = 180.0
"""Length of the beginning of the drive that is checked [s]: wrong wiring is wrong from the start."""
SMOOTH = 0.3
"""Width of the moving average of the signals [s]."""
SCALE = 1.4
"""Ratio of amplitudes from which a scale is wrong [-]; tyres, radii and slopes cause up to 1.34."""
BRIDGED = 0.1
"""Longest gap between two readings that is interpolated linearly [s], since few buses have the rate of the grid."""
LATE = 0.15
"""Shift in time from which an estimate is wrong [s]; the motion itself lags by up to 0.1 s."""


class CloseLimits(NamedTuple):
    """Limits that sensors of a calibrated vehicle do not reach.

    In fault-free drives of an hour one sensor differs from both others by a factor of 1.07 and by 0.03 s, with tyres a
    tenth larger by a factor of 1.10.

    Args:
        scale, late: see `Wiring`
    """

    scale: float = 1.13
    late: float = 0.045


class Wiring:
    """Checks the beginning of a drive for signals that were connected or described wrongly.

    Args:
        vehicle: parameters of the vehicle
        rate: sampling rate [Hz]
        scale: ratio of amplitudes from which an estimate is wrong
        late: shift in time from which an estimate is wrong [s]
        close: tighter limits between sensors alone, for a calibrated vehicle; None without a calibration
    """

    def __init__(
        self,
        vehicle: CarParameters,
        rate: float,
        scale: float = SCALE,
        late: float = LATE,
        close: CloseLimits | None = None,
    ):
        self.vehicle, self.rate, self.scale, self.late, self.close = vehicle, rate, scale, late, close
        self._pieces: list[dict[str, np.ndarray]] = []
        self._kept = 0

    def add(self, signals: Mapping[str, np.ndarray]) -> None:
        """Add the next piece, signals by name, (n,) each; NaN if missing."""
        left = round(KEPT * self.rate) - self._kept
        if left > 0:
            piece = {name: np.array(values[:left]) for name, values in signals.items()}
            self._kept += len(next(iter(piece.values())))
            self._pieces.append(piece)

    def problems(self) -> tuple[Problem, ...]:
        """Problems of the wiring; empty if there are none, or if the drive turned too little to show any.

        A problem must show in every part of the beginning, each with the same time of turning: what begins later is a
        fault.
        """
        if not self._pieces:
            return ()
        most = round(BRIDGED * self.rate)
        whole = {
            name: _bridged(np.concatenate([each[name] for each in self._pieces]), most) for name in self._pieces[0]
        }
        turned_until = np.cumsum(self._turning(whole))
        edges = np.searchsorted(turned_until, np.linspace(0, turned_until[-1], PARTS + 1)[1:-1])
        parts = [slice(start, stop) for start, stop in pairwise((0, *edges.tolist(), self._kept))]
        each = [self._problems({name: values[part] for name, values in whole.items()}) for part in parts]
        shown = [{(found.kind, found.elements) for found in problems} for problems in each if problems is not None]
        if len(shown) < PARTS:
            return ()
        return tuple(
            found
            for found in self._problems(whole) or ()
            if all((found.kind, found.elements) in part for part in shown)
        )

    def _problems(self, signals: Mapping[str, np.ndarray]) -> tuple[Problem, ...] | None:
        """Problems of a stretch; None if the car turned too little to show any."""
        if np.count_nonzero(self._turning(signals)) < LEAST_TURNING * self.rate:
            return None
        with np.errstate(invalid="ignore"):
            moving = mean_speed(signals) > MOVING
        gentle = moving & ~(np.abs(signals["lateral_acceleration"]) > GENTLE)
        yaw, slowly = self._estimates(YAW, signals, moving), self._estimates(YAW, signals, gentle)
        understeering = self._estimates(UNDERSTEERING, signals, gentle)
        misread = misread_speed(slowly, self.scale)
        # At the centre of gravity, a = v r + rear_distance dr/dt leads v r by rear_distance / v: samples in which that
        # exceeds twice the lead of the witness show no delay.
        fast = moving & (mean_speed(signals) > self.vehicle.rear_distance / (2.0 * YAW[OVER_SPEED].lead))
        timed = {name: each for name, each in yaw.items() if name != OVER_SPEED}
        timed |= self._estimates({OVER_SPEED: YAW[OVER_SPEED]}, signals, fast)
        found = turned(yaw, YAW) or late(timed, YAW, self.late) or misread
        found = found or _scaled(slowly, understeering, self.scale)
        if self.close is not None and not any(each.elements for each in found):
            near = late(_sensed(yaw), YAW, self.close.late)
            near = near or _scaled(_sensed(slowly), _sensed(understeering), self.close.scale)
            found = (*near, *found)
        return found or turned(self._estimates(TORQUE, signals, moving), TORQUE)

    def _turning(self, signals: Mapping[str, np.ndarray]) -> np.ndarray:
        """Whether the vehicle turns, for every sample."""
        with np.errstate(invalid="ignore"):
            yaw = [YAW[name].estimate(signals, self.vehicle) for name in ("rear wheels", "yaw rate sensor")]
            return np.asarray((mean_speed(signals) > MOVING) & (np.nansum(np.abs(yaw), axis=0) > TURNING))

    def _estimates(
        self, witnesses: Mapping[str, Witness], signals: Mapping[str, np.ndarray], when: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Estimates of every witness, low-pass filtered and with their mean removed; NaN outside `when`."""
        width = max(round(SMOOTH * self.rate), 1)
        found = {}
        for name, witness in witnesses.items():
            value = np.where(when, witness.estimate(signals, self.vehicle), np.nan)
            if np.count_nonzero(np.isfinite(value)) > LEAST_TURNING * self.rate:
                smooth = np.convolve(value, np.full(width, 1.0 / width), "same")[:: max(round(STEP * self.rate), 1)]
                # One NaN spoils a whole window: with many pauses no mean may be left.
                if np.isfinite(smooth).any():
                    found[name] = smooth - np.nanmean(smooth)
        return found


def _bridged(values: np.ndarray, most: int) -> np.ndarray:
    """Values with gaps of up to `most` samples interpolated linearly; longer gaps stay NaN."""
    there = np.flatnonzero(np.isfinite(values))
    if not 1 < len(there) < len(values):
        return values
    place = np.arange(len(values))
    apart = np.concatenate(([len(values)], np.diff(there), [len(values)]))[np.searchsorted(there, place)]
    between = np.isnan(values) & (apart <= most)
    return np.where(between, np.interp(place, there, values[there]), values)


def _scaled(
    by_geometry: Mapping[str, np.ndarray], understeering: Mapping[str, np.ndarray], limit: float
) -> tuple[Problem, ...]:
    """Problem of a wrong scale that no understeer between none and that of the vehicle file, often a guess, explains.

    Args:
        by_geometry: estimates without understeer
        understeering: estimates with that of the vehicle file
        limit: ratio of amplitudes from which an estimate is wrong
    """
    without = {each.elements for each in scaled(by_geometry, YAW, limit)}
    return tuple(each for each in scaled(understeering, UNDERSTEERING, limit) if each.elements in without)


def _sensed(estimates: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Estimates of judged sensors only, which road slopes and banks do not affect."""
    return {name: values for name, values in estimates.items() if YAW[name].elements}


BUSES = (OF_AUTOMATED[:3], OF_AUTOMATED[3:])
"""Sensors that share a bus and its clock: those of the chassis, and those of the steering."""
BEFORE = 1.0
"""Time before the declaration of two sensors of one bus within which the first may have been declared alone [s]."""


class ClockLeap:
    """Tests for a shift in time between the buses after two sensors of one bus have been declared together.

    A single late sensor is a fault. If two sensors of one bus are declared, and the angle is late or early against the
    other estimates of the yaw rate, the bus has lost its time base. Two faults of which one is a delay of the angle
    look the same.

    Args:
        look: function that makes a check of the wiring, for the signals from then on
    """

    def __init__(self, look: Callable[[], Wiring]):
        self._look = look
        self._wiring: Wiring | None = None
        self._since = 0.0

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray], faulty: np.ndarray) -> None:
        """Add the next piece.

        Args:
            time: time stamps [s], (n,)
            signals: signals by name, (n,) each; NaN if missing
            faulty: whether each element is declared, the sensors first, (n, elements)
        """
        first = 0
        if self._wiring is None:
            together = np.zeros(len(time), bool)
            for bus in BUSES:
                together |= faulty[:, [SENSORS.index(name) for name in bus]].sum(axis=1) >= 2
            if not together.any():
                return
            first = int(np.argmax(together))
            self._wiring, self._since = self._look(), float(time[first])
        self._wiring.add({name: values[first:] for name, values in signals.items()})

    def problems(self, episodes: Sequence[Episode]) -> tuple[Problem, ...]:
        """Problem that the buses have lost their common time base; empty if not, or if a fault began earlier.

        Args:
            episodes: episodes of all faults of the drive
        """
        if self._wiring is None or any(each.declared_at < self._since - BEFORE for each in episodes):
            return ()
        return tuple(
            found._replace(cause=f"{found.cause} since about {self._since:.0f} s")
            for found in self._wiring.problems()
            if found.kind == "time" and found.elements == ("steering_wheel_angle",)
        )
