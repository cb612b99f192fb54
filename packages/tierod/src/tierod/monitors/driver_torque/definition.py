"""The monitor of the driver's hands: its session over one recording, and its variants."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.errors import ParameterError
from tierod.core.facts import Fact
from tierod.core.graph import Result
from tierod.core.recording import Aligned
from tierod.methods.analysis.consistency import nis_figures
from tierod.monitors.baseline import Baseline
from tierod.monitors.driver_torque.block import ColumnSigns, DriverTorqueMonitor
from tierod.monitors.driver_torque.column import SIGNALS, GeometryOverDrive
from tierod.monitors.driver_torque.design import (
    FINE,
    PRODUCTION,
    SensorNoise,
    gear_is_too_fast,
    measured_noise,
    tuning_at,
    usual_tuning,
)
from tierod.monitors.driver_torque.evidence import TRUTH, Drive, SignalsOverDrive
from tierod.monitors.driver_torque.facts import (
    CASES,
    DECISIONS,
    LEAST_READY,
    RATIO_SPREAD,
    FitRules,
    distances,
    judge,
    ratio_spread,
)
from tierod.monitors.driver_torque.hands import HandsMonitor
from tierod.monitors.driver_torque.observer import DELAY, ColumnObserver, DelayedHandTorque
from tierod.monitors.registry import variants_with_plugins
from tierod.monitors.session import BlockSession, Conclusion, Monitor, Session, Variant
from tierod.vehicles import Vehicle
from tierod.vehicles.classes import is_guess

WITHHELD = (
    "The torque of the hands, and whether they are on the wheel, are withheld, since the vehicle file does not fit the "
    "recording; the normalised innovations show where it fits least."
)
SIZED = (
    "NIS is given per measurement, here and in the chart: 1 where the observer's variances are right, more where they "
    "are too small. The observer assumes a quarter more noise than was measured, so two thirds are usual."
)

TRACES = {
    "statement.magnitude": ("hand_torque", "N*m"),
    "statement.deviation": ("hand_torque_standard_deviation", "N*m"),
    "hands": ("hands_on", ""),
    "disturbance_torque": ("disturbance_torque", "N*m"),
    "disturbance_torque_deviation": ("disturbance_torque_standard_deviation", "N*m"),
    "statement.evidence": ("evidence_for_hands", ""),
    "nis": ("nis", ""),
}
"""Outputs of the block that a report shows."""

MEASURED = 60.0  # initial part of a recording on which sensor noise and a guessed motor ratio are measured [s]


class Fitted(NamedTuple):
    """Properties of a recording that the block is adapted to."""

    noise: SensorNoise  # noise of the sensors
    with_motor: bool  # whether the observer uses the motor's angle
    signals: SignalsOverDrive  # statistics of its signals, which every vehicle within the spread shares
    # Ratio of the angles, in place of a guess of the vehicle file; None where the file's is used.
    motor_ratio: float | None = None
    # Whether the motor's angle is present but not used, since its ratio is a guess and cannot be identified.
    hidden: bool = False


# Builder of the block from vehicle, sensor noise, and whether the motor's angle is used.
Builder = Callable[[Vehicle, SensorNoise, bool], DriverTorqueMonitor]


class DriverTorqueSession(BlockSession):
    """Run the block over a recording, and collect the state of the hands and deviations of the column from its file.

    Args:
        delay: delay of the observer's torque; the truth is delayed equally [samples]
    """

    listens = MEASURED  # Length of the first piece, so that the noise does not depend on how the recording is cut [s]

    def __init__(
        self,
        build: Builder,
        usual: SensorNoise,
        vehicle: Vehicle,
        rate: float,
        name: str,
        lacking: tuple[str, ...] = (),
        delay: int = 0,
        remark: str = "",
    ):
        shown = {key: each for key, each in TRACES.items() if key not in lacking}
        super().__init__(build(vehicle, usual, True), shown)
        self._build, self._usual, self.rate, self.name = build, usual, rate, name
        self.vehicle = self._given = vehicle
        self._fitted = Fitted(usual, True, SignalsOverDrive(rate))
        self.traces = {**self.traces, "true_hand_torque": "N*m"}
        self.signals = (*self.signals, TRUTH)
        self._has_nis, self._remark, self.rules = "nis" not in lacking, remark, FitRules()
        self._drive = self._drive_of(self._fitted)
        self._truth, self._nis = np.full(delay, np.nan), np.empty(0)

    def prepared(self, aligned: Aligned) -> Aligned:
        columns = aligned.columns
        if self.fitted is None:
            self.refit(self._suited(columns))
        if not self._fitted.hidden and not len(self._truth):
            return aligned
        values = aligned.values.copy()
        if self._fitted.hidden:
            values[:, aligned.names.index("motor_angle_mechanical")] = np.nan
        if len(self._truth):
            truth = np.concatenate([self._truth, columns[TRUTH]])
            kept = len(truth) - len(self._truth)
            values[:, aligned.names.index(TRUTH)], self._truth = truth[:kept], truth[kept:]
        return replace(aligned, values=values)

    def taken(self, aligned: Aligned, result: Result) -> Mapping[str, np.ndarray]:
        shown = {**super().taken(aligned, result), "true_hand_torque": aligned.columns[TRUTH]}
        return {name: self._nis if name == "nis" else trace for name, trace in shown.items()}

    def refit(self, fitted: Fitted) -> None:
        self.fitted = self._fitted = fitted
        if fitted.motor_ratio is not None:
            # A deviation of zero, so that the identified ratio no longer counts as a guess.
            known = replace(self._given.parameters["motor_ratio"], value=fitted.motor_ratio, standard_deviation=0.0)
            self.vehicle = replace(self._given, parameters={**self._given.parameters, "motor_ratio": known})
        self._drive = self._drive_of(fitted)
        self.block = self._build(self.vehicle, fitted.noise, fitted.with_motor)

    def _drive_of(self, fitted: Fitted) -> Drive:
        return Drive(self.vehicle, self.rate, self._has_nis, fitted.signals)

    def _suited(self, columns: Mapping[str, np.ndarray]) -> Fitted:
        first = slice(round(MEASURED * self.rate))
        wheel, motor, torque = (columns[name][first] for name in SIGNALS)
        noise = measured_noise(wheel, torque, self.rate, self._usual)
        fitted = self._fitted._replace(noise=noise)
        if not np.isfinite(columns["motor_angle_mechanical"]).any():
            return fitted._replace(with_motor=False)
        known = self._given.parameters["motor_ratio"]
        # A ratio that is less certain than a design value and wrong by more imitates torques.
        if not is_guess(known, RATIO_SPREAD):
            return fitted
        geometry = GeometryOverDrive(self.rate)
        geometry.add(wheel, motor, torque)
        found = geometry.found()
        if found is None or found.ratio_uncertainty > RATIO_SPREAD:
            return fitted._replace(with_motor=False, hidden=True)
        fits = not self.rules.apart(found.ratio / known.value - 1.0, ratio_spread(self._given))
        return fitted._replace(motor_ratio=found.ratio if fits else None)

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        self._nis = result["nis"] / np.where(result["present"] > 0.0, result["present"], np.nan)
        if not self.moved:
            self._fitted.signals.add(signals)
        self._drive.add(time, signals, result, brief=self.moved)

    def _remarks(self, drive: Drive) -> tuple[Fact, ...]:
        seen = self._fitted.motor_ratio
        if seen is None and not self._fitted.hidden:
            return ()
        known = self._given.parameters["motor_ratio"]
        given = {"given": known.value, "deviation": known.standard_deviation or 0.0}
        if seen is None:
            return (CASES["ratio unknown"].filled(**given),)
        there = seen if drive.geometry is None else drive.geometry.ratio
        return (CASES["ratio found"].filled(**given, there=there),)

    def conclude(self) -> Conclusion:
        drive, found = self._drive, self._drive.consistency()
        drive.close()
        verdict = judge(drive, self.vehicle, self.name, self.rules, self._remarks(drive))
        fits, unfit = verdict.status.quiet, verdict.status.alarm
        withheld = (TRUTH,) if fits else (TRUTH, *(name for name in self.traces if not (unfit and name == "nis")))
        remarks = {"estimate": WITHHELD if unfit else self._remark if fits else "", "consistency": SIZED * bool(found)}
        return Conclusion(
            verdict,
            consistency=nis_figures(found, wide=True) if found else {},
            remarks={part: remark for part, remark in remarks.items() if remark},
            withheld=withheld,
            distances=distances(drive, self.vehicle) if fits or unfit else {},
        )


PAPER = "Raffone, Observers of an electric power steering column"

FAST = 500.0  # rate from which sensors are assumed to be those of a test bench [Hz]; buses of cars are slower

_DELAYED = ("disturbance_torque", "disturbance_torque_deviation", "nis")

LATER = f"The torque is given {1e3 * DELAY:.0f} ms after it acted; truth and error refer to the time at which it acted."
NO_GEAR = (
    "The gear's vibration is too fast for {rate:g} samples per second, so it is left out: bar and gear are one spring, "
    "and gear and motor one inertia."
)

Opener = Callable[[Vehicle, float, Baseline | None], Session]
# Builder of an observer from vehicle, rate [Hz], sensor noise, and whether the motor's angle is used.
Observer = Callable[[Vehicle, float, SensorNoise, bool], Block]


def opener(
    name: str, observer: Observer, lacking: tuple[str, ...] = (), delay: float = 0.0, whole_column: bool = False
) -> Opener:
    """Function that opens a session with an observer.

    Args:
        whole_column: whether it keeps the gear even where the gear's vibration is too fast for the sampling
    """

    def open_(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
        if not vehicle.calibrated:
            raise ParameterError(
                f"the torques of the vehicle '{vehicle.name}' are raw counts, but the wheel's inertia needs N·m; give "
                "the N·m of one count in the channel map, and take torque_unit out of the vehicle file"
            )

        def build(column: Vehicle, noise: SensorNoise, with_motor: bool) -> DriverTorqueMonitor:
            hands = HandsMonitor.of_vehicle(column, 1.0 / rate, noise=noise)
            signs = ColumnSigns(
                column["motor_ratio"], 1.0 / rate, torsion_bar_stiffness=column["torsion_bar_stiffness"]
            )
            return DriverTorqueMonitor(observer(column, rate, noise, with_motor), hands, signs)

        remark = LATER if delay > 0.0 else ""
        if not whole_column and gear_is_too_fast(vehicle, 1.0 / rate):
            remark = f"{remark} {NO_GEAR.format(rate=rate)}".lstrip()
        usual = FINE if rate >= FAST else PRODUCTION
        return DriverTorqueSession(
            build, usual, vehicle, rate, f"driver-torque, {name}", lacking, round(delay * rate), remark
        )

    return open_


def _default(vehicle: Vehicle, rate: float, noise: SensorNoise, with_motor: bool) -> ColumnObserver:
    tuning = tuning_at(rate, usual_tuning(vehicle), noise, with_motor)
    return ColumnObserver.of_vehicle(vehicle, 1.0 / rate, tuning=tuning)


def _delayed(vehicle: Vehicle, rate: float, noise: SensorNoise, with_motor: bool) -> DelayedHandTorque:
    tuning = tuning_at(rate, usual_tuning(vehicle), noise, with_motor)
    return DelayedHandTorque.of_vehicle(vehicle, 1.0 / rate, tuning=tuning)


INTERACTING = Variant(
    "interacting",
    "Three filters in parallel: for a hand torque that changes at a rate, one that jumps, and friction that reverses.",
    f"beyond {PAPER}; docs/explanation/driver-torque.md",
    opener("interacting", _default),
    DECISIONS,
)

FIXED_LAG = Variant(
    "fixed-lag",
    "The torque of the hands 20 ms ago, from all samples until now: smoother and more accurate, but late.",
    f"beyond {PAPER}; docs/explanation/driver-torque.md",
    opener("fixed-lag", _delayed, _DELAYED, DELAY),
    DECISIONS,
)

DRIVER_TORQUE = Monitor(
    name="driver-torque",
    title="Torque of the driver's hands",
    subject="Driver's hands",
    summary="Estimates the torque that the driver's hands put on the wheel, and decides whether they are on it.",
    source=PAPER,
    drive=f"At least {LEAST_READY:g} s in which the wheel turns: a drive, or a bench whose motor turns the column.",
    required=("steering_wheel_angle", "driver_torque"),
    optional=("motor_torque", "motor_target_torque", "motor_angle_mechanical", TRUTH),
    rate=1000.0,
    minimum_rate=50.0,
    maximum_age=0.05,
    variants=variants_with_plugins(
        "driver-torque",
        {
            "interacting": "tierod.monitors.driver_torque.definition:INTERACTING",
            "fixed-lag": "tierod.monitors.driver_torque.definition:FIXED_LAG",
        },
    ),
    default="interacting",
    slower=(500.0, 200.0, 100.0, 50.0),
    estimates=True,
)
