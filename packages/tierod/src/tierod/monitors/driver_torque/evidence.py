"""Statistics over a drive: torque of the hands, times without hands, and properties of the column."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tierod.core.findings import Status
from tierod.core.graph import Result
from tierod.core.statuses import code_of
from tierod.methods.analysis.consistency import Consistency, ConsistencyAccumulator
from tierod.methods.running import Spans
from tierod.monitors.driver_torque.block import SignVerdict, WorkOverDrive, wrong_signs
from tierod.monitors.driver_torque.column import (
    BelowBarOverDrive,
    ContradictionOverDrive,
    GeometryOverDrive,
)
from tierod.monitors.driver_torque.design import usual_tuning
from tierod.monitors.driver_torque.hands import OFF, ON, UNCERTAIN
from tierod.vehicles import Vehicle

TRUTH = "truth_hand_torque"  # channel of a virtual car with the true torque of the hands
# Signals whose sign is tested.
SIGNED = ("steering_wheel_angle", "motor_angle_mechanical", "driver_torque", "motor_torque")
SURELY = 2.0  # standard deviations by which the torque of the hands may be smaller [-]: the end of a 95 % band
MOST_STRETCHES = 1_000_000  # largest number of stretches without hands that are kept
MOSTLY = 0.5  # share of the testable time above which a sign must have appeared wrong to count as wrong


class SignalsOverDrive:
    """Statistics of the signals alone, which are those of every vehicle within the spread of its parameters."""

    def __init__(self, rate: float) -> None:
        self.geometry, self.below, self.work = GeometryOverDrive(rate), BelowBarOverDrive(rate), WorkOverDrive(rate)
        self.contradiction = ContradictionOverDrive(rate)
        self._ends = {name: [math.inf, -math.inf] for name in ("driver_torque", "steering_wheel_angle")}
        self.motor, self.powered = "motor_target_torque", False

    def add(self, signals: Mapping[str, np.ndarray]) -> None:
        bar = signals["steering_wheel_angle"], signals["motor_angle_mechanical"], signals["driver_torque"]
        self.geometry.add(*bar)
        self.contradiction.add(*bar)
        given, wanted = signals["motor_torque"], signals["motor_target_torque"]
        motor = np.where(np.isfinite(given), given, wanted)
        self.below.add(motor, *bar[1:])
        self.work.add(bar[0], bar[2], motor)
        for name, (low, high) in self._ends.items():
            values = signals[name]
            self._ends[name] = [
                np.fmin(low, np.nanmin(values, initial=low)),
                np.fmax(high, np.nanmax(values, initial=high)),
            ]
        if np.isfinite(given).any():
            self.motor = "motor_torque"
        self.powered |= bool(np.isfinite(signals[self.motor]).any())

    @property
    def spans(self) -> tuple[float, ...]:
        """Ranges of the bar's torque [N*m] and of the wheel's angle [rad]."""
        return tuple(max(high - low, 0.0) for low, high in self._ends.values())


class Drive:
    """Results over a drive, accumulated piece by piece beside those of its signals; `close` ends it."""

    def __init__(self, vehicle: Vehicle, rate: float, nis: bool, signals: SignalsOverDrive) -> None:
        self._vehicle, self._signals, self._rate = vehicle, signals, rate
        self._stretches, self._end = Spans(most=MOST_STRETCHES), 0.0
        # A bench has no assist: its motor may pull against the hands throughout, so work shows no wrong sign.
        self._work = None if usual_tuning(vehicle).offset is None else signals.work
        self._consistency = ConsistencyAccumulator() if nis else None
        self._ready = self._compared = self._judged = 0
        self._hand = self._variance = self._error = 0.0
        self._states, self._turned = dict.fromkeys((OFF, UNCERTAIN, ON), 0), dict.fromkeys(SIGNED, 0)
        self.sample_time = 1.0 / rate  # sampling interval [s]
        self.peak = self.peak_deviation = 0.0  # torque of the hands that was surely largest, and its deviation [N*m]
        # Values learnt without hands [kg*m**2], [N*m].
        self.inertia_error = self.torque_offset = 0.0

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result, brief: bool = False) -> None:
        """Add the next piece; a brief one without what only a report shows."""
        hand, deviation = result["statement.magnitude"], result["statement.deviation"]
        ready = (result["statement.status"] == code_of(Status.ESTIMATED)) & np.isfinite(hand)
        if self._consistency is not None:
            self._consistency.add(result["nis"][ready], result["present"][ready])
        self._ready += int(ready.sum())
        self._hand += float(np.sum(hand[ready] ** 2))
        self._variance += float(np.sum(deviation[ready] ** 2))
        self._judged += int(np.count_nonzero(result["turned.torque_judged"]))
        for name in self._turned:
            self._turned[name] += int(np.count_nonzero(result[f"turned.{name}"]))
        self.inertia_error, self.torque_offset = float(result["inertia_error"][-1]), float(result["torque_offset"][-1])
        if brief:
            return
        self._stretches.add(time, result["hands"] == OFF)
        self._end = float(time[-1]) + self.sample_time
        for state in self._states:
            self._states[state] += int(np.count_nonzero(ready & (result["hands"] == state)))
        error = (hand - signals[TRUTH])[ready & np.isfinite(signals[TRUTH])]
        self._error += float(error @ error)
        self._compared += len(error)
        if ready.any():
            # The largest value would often be the one that is least known: what is surely so large counts.
            surely = np.where(ready, np.abs(hand) - SURELY * deviation, -math.inf)
            at = int(np.argmax(surely))
            if not self.peak or surely[at] > abs(self.peak) - SURELY * self.peak_deviation:
                self.peak, self.peak_deviation = float(hand[at]), float(deviation[at])

    def consistency(self) -> Consistency | None:
        """Consistency of the observer; None where it has no NIS."""
        return self._consistency.result() if self._consistency is not None else None

    def close(self) -> None:
        """Compute what rests on the whole drive."""
        count, rate, consistency, signals = max(self._ready, 1), self._rate, self.consistency(), self._signals
        ratio, stiffness = self._vehicle["motor_ratio"], self._vehicle["torsion_bar_stiffness"]
        # Time with a known torque, and its parts in each state of the hands [s].
        self.ready = self._ready / rate
        self.off, self.uncertain, self.on = (each / rate for each in self._states.values())
        # Root mean squares of the hands' torque, of its estimated deviation, and of its error against a truth [N*m].
        self.hand_rms, self.hand_deviation = math.sqrt(self._hand / count), math.sqrt(self._variance / count)
        self.error = math.sqrt(self._error / self._compared) if self._compared else math.nan
        self.torque_span, self.angle_span = signals.spans
        self.nis = consistency.nis if consistency else math.nan  # mean NIS per measurement; NaN where there is none
        self.geometry = signals.geometry.found()
        # Inertia of motor and gear at the motor's shaft [kg*m**2]; None where not identifiable.
        self.motor_inertia = signals.below.inertia(ratio)
        self.stretches = tuple(each._replace(end=min(each.end, self._end)) for each in self._stretches.found())
        self.contradiction = signals.contradiction.found(ratio, stiffness)
        self.motor = signals.motor if signals.powered else ""  # signal that gave the motor's torque; "" without one
        # A sentence for every signal with a wrong sign, and for those whose sign may be wrong.
        turned = {name: float(seen > MOSTLY * self._judged) for name, seen in self._turned.items()}
        verdict = SignVerdict(**turned, angles_judged=1.0, torque_judged=1.0, motor_judged=1.0)
        by_work = self._work.wrong_signs(signals.motor, ratio) if self._work is not None else ()
        self.turned = wrong_signs(verdict, signals.motor) or by_work
        self.doubts = self._work.doubts() if self._work is not None and not signals.powered else ()
