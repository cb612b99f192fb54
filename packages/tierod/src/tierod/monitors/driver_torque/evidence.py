"""Statistics over a drive: torque of the hands, times without hands, and properties of the column."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Status
from tierod.core.graph import Result
from tierod.core.statuses import code_of
from tierod.methods.analysis.consistency import Consistency, ConsistencyAccumulator
from tierod.methods.running import Span, Spans
from tierod.monitors.driver_torque.block import SignVerdict, WorkOverDrive, wrong_signs
from tierod.monitors.driver_torque.column import (
    BelowBarOverDrive,
    ColumnGeometry,
    Contradiction,
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


class Drive(NamedTuple):
    """Results over a drive."""

    # Time with a known torque, and its parts in each state of the hands.
    ready: Annotated[float, "s"]
    off: Annotated[float, "s"]
    on: Annotated[float, "s"]
    uncertain: Annotated[float, "s"]
    # Root mean squares of the hands' torque and of its estimated standard deviation.
    hand_rms: Annotated[float, "N*m"]
    hand_deviation: Annotated[float, "N*m"]
    # Torque of the hands that was surely largest, and its standard deviation.
    peak: Annotated[float, "N*m"]
    peak_deviation: Annotated[float, "N*m"]
    error: Annotated[float, "N*m"]  # root mean square error against the truth of a simulation; NaN where there is none
    # Range of the bar's torque and of the wheel's angle.
    torque_span: Annotated[float, "N*m"]
    angle_span: Annotated[float, "rad"]
    nis: Annotated[float, ""]  # mean NIS per measurement; NaN where the observer gives none
    sample_time: Annotated[float, "s"]  # sampling interval
    # Values learnt without hands.
    inertia_error: Annotated[float, "kg*m**2"]
    torque_offset: Annotated[float, "N*m"]
    geometry: ColumnGeometry | None  # geometry of the column, from angles and torque
    # Inertia of motor and gear at the motor's shaft, from torques and acceleration; None where not identifiable.
    motor_inertia: Annotated[float | None, "kg*m**2"]
    turned: tuple[str, ...]  # a sentence for every signal with a wrong sign
    stretches: tuple[Span, ...]  # stretches without hands
    # Contradiction between the three signals of the bar; None where it cannot be tested.
    contradiction: Contradiction | None = None
    motor: str = ""  # signal that gave the motor's torque; empty where there was none
    doubts: tuple[str, ...] = ()  # a sentence for signals whose sign may be wrong


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


class DriveFigures:
    """Accumulated statistics of the estimate over the pieces of a recording, beside those of its signals."""

    def __init__(self, vehicle: Vehicle, rate: float, nis: bool, signals: SignalsOverDrive) -> None:
        self._vehicle, self._signals = vehicle, signals
        self._rate, self._stretches, self._end = rate, Spans(most=MOST_STRETCHES), 0.0
        # A bench has no assist: its motor may pull against the hands throughout, so work shows no wrong sign.
        self._work = None if usual_tuning(vehicle).offset is None else signals.work
        self._consistency = ConsistencyAccumulator() if nis else None
        self.ready = self.compared = 0
        self.hand = self.variance = self.error = self.peak = self.peak_deviation = 0.0
        self.states = dict.fromkeys((OFF, UNCERTAIN, ON), 0)
        self.inertia_error = self.torque_offset = 0.0
        self.judged, self.turned = 0, dict.fromkeys(SIGNED, 0)

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result, brief: bool = False) -> None:
        """Add the next piece; a brief one without what only a report shows."""
        hand, deviation = result["statement.magnitude"], result["statement.deviation"]
        ready = (result["statement.status"] == code_of(Status.ESTIMATED)) & np.isfinite(hand)
        if self._consistency is not None:
            self._consistency.add(result["nis"][ready], result["present"][ready])
        self.ready += int(ready.sum())
        self.hand += float(np.sum(hand[ready] ** 2))
        self.variance += float(np.sum(deviation[ready] ** 2))
        self.judged += int(np.count_nonzero(result["turned.torque_judged"]))
        for name in self.turned:
            self.turned[name] += int(np.count_nonzero(result[f"turned.{name}"]))
        self.inertia_error, self.torque_offset = float(result["inertia_error"][-1]), float(result["torque_offset"][-1])
        if brief:
            return
        self._stretches.add(time, result["hands"] == OFF)
        self._end = float(time[-1]) + 1.0 / self._rate
        for state in self.states:
            self.states[state] += int(np.count_nonzero(ready & (result["hands"] == state)))
        error = (hand - signals[TRUTH])[ready & np.isfinite(signals[TRUTH])]
        self.error += float(error @ error)
        self.compared += len(error)
        if ready.any():
            # The largest value would often be the one that is least known: what is surely so large counts.
            surely = np.where(ready, np.abs(hand) - SURELY * deviation, -math.inf)
            at = int(np.argmax(surely))
            if not self.peak or surely[at] > abs(self.peak) - SURELY * self.peak_deviation:
                self.peak, self.peak_deviation = float(hand[at]), float(deviation[at])

    def consistency(self) -> Consistency | None:
        """Consistency of the observer; None where it has no NIS."""
        return self._consistency.result() if self._consistency is not None else None

    def drive(self) -> Drive:
        """The results so far."""
        count, rate, consistency = max(self.ready, 1), self._rate, self.consistency()
        signals, ratio = self._signals, self._vehicle["motor_ratio"]
        torque, angle = signals.spans
        return Drive(
            ready=self.ready / rate,
            off=self.states[OFF] / rate,
            on=self.states[ON] / rate,
            uncertain=self.states[UNCERTAIN] / rate,
            hand_rms=math.sqrt(self.hand / count),
            hand_deviation=math.sqrt(self.variance / count),
            peak=self.peak,
            peak_deviation=self.peak_deviation,
            error=math.sqrt(self.error / self.compared) if self.compared else math.nan,
            torque_span=torque,
            angle_span=angle,
            nis=consistency.nis if consistency else math.nan,
            sample_time=1.0 / rate,
            inertia_error=self.inertia_error,
            torque_offset=self.torque_offset,
            geometry=signals.geometry.found(),
            motor_inertia=signals.below.inertia(ratio),
            turned=self._turned(),
            stretches=tuple(each._replace(end=min(each.end, self._end)) for each in self._stretches.found()),
            contradiction=signals.contradiction.found(ratio, self._vehicle["torsion_bar_stiffness"]),
            motor=signals.motor if signals.powered else "",
            doubts=self._work.doubts() if self._work is not None and not signals.powered else (),
        )

    def _turned(self) -> tuple[str, ...]:
        turned = {name: float(seen > MOSTLY * self.judged) for name, seen in self.turned.items()}
        verdict = SignVerdict(**turned, angles_judged=1.0, torque_judged=1.0, motor_judged=1.0)
        motor = self._signals.motor
        by_work = self._work.wrong_signs(motor, self._vehicle["motor_ratio"]) if self._work is not None else ()
        return wrong_signs(verdict, motor) or by_work
