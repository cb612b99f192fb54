"""Tuning of the column observers for bench, road and measured noise, and the design of their filters."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.signals import residue_of
from tierod.methods.analysis.consistency import differences, usual_deviation
from tierod.methods.estimators.stationary_bank import StationaryBank, Switching
from tierod.models.column_observation import ColumnObservation, linear_column, observed_column, require_fit
from tierod.models.linear import LinearSystem
from tierod.models.steering_column import (
    BelowBarParameters,
    ColumnOutput,
    ColumnParameters,
    SteeringColumn,
    TwoInertiaColumn,
    TwoInertiaParameters,
    without_gear,
)
from tierod.vehicles import Vehicle

FEWEST = 500  # least number of samples for a measurement of the noise
# Noise assumed by a filter over the measured one; motion hides some of the noise, and none is quite white.
MARGIN = 1.25
# Longest time for which a rounding error stays the same while a wheel turns [s]; a wheel at rest shows none.
LONGEST_STEP = 0.01
# Share of a signal's changes that may be smaller than a step of its sensor; an export interpolates single values.
SMALLER = 0.01


@dataclass(frozen=True)
class SensorNoise:
    """Noise of both sensors, one standard deviation per sample, rounding included.

    The defaults are those of good transducers read every millisecond."""

    angle: Annotated[float, "rad"] = math.radians(0.008)  # noise of the steering wheel angle
    torque: Annotated[float, "N*m"] = 0.012  # noise of the torque of the torsion bar


FINE = SensorNoise()  # sensors of a test bench
# Sensors of production cars, as transmitted on their bus.
PRODUCTION = SensorNoise(angle=math.radians(0.04), torque=0.05)
# Noise of the motor's angle sensor, rounding included [rad]; bench and production car have the same one.
MOTOR_NOISE = math.radians(0.06)


def measured_noise(angle: np.ndarray, torque: np.ndarray, rate: float, usual: SensorNoise) -> SensorNoise:
    """Noise of both sensors per sample.

    Second differences contain the white noise, and hardly the motion of a wheel; steps of equal size reveal rounding,
    whose error lasts for several samples while the wheel turns slowly and then counts as correspondingly more noise."""
    return SensorNoise(
        max(_noise("steering_wheel_angle", angle, rate, usual.angle), 0.5 * FINE.angle),
        max(_noise("driver_torque", torque, rate, usual.torque), 0.5 * FINE.torque),
    )


def _noise(name: str, values: np.ndarray, rate: float, usual: float) -> float:
    second, first = differences(values, 2), np.diff(values)
    second, first = second[np.isfinite(second)], np.abs(first[np.isfinite(first)])
    changed = first[first > residue_of(name)]
    if len(second) < FEWEST or len(changed) < FEWEST // 10:
        return usual
    rounding = float(np.quantile(changed, SMALLER, method="lower")) / math.sqrt(12.0)
    lasting = min(len(first) / len(changed), max(LONGEST_STEP * rate, 1.0))
    return MARGIN * max(usual_deviation(second), rounding * math.sqrt(lasting))


@dataclass(frozen=True)
class ColumnTuning:
    """Noises of a column and its sensors; random walks are per square root of a second.

    The defaults are for a bench with 0.1 N·m of friction at the motor, tuned on simulated runs: two with hands that
    jump and two with hands that pull within 100 ms; reported results come from other runs."""

    # Standard deviation of a sample.
    steering_wheel_angle_noise: Annotated[float, "rad"] = math.radians(0.05)
    motor_angle_noise: Annotated[float, "rad"] = math.radians(0.2)
    driver_torque_noise: Annotated[float, "N*m"] = 0.02
    # Walk of the rate of the hands' torque, while they move smoothly.
    hand_torque_rate_walk: Annotated[float, "N*m/s**1.5"] = 5.0
    # Walk of the torque itself while it jumps; 0 for hands that never do, which leaves one filter.
    hand_torque_walk: Annotated[float, "N*m/s**0.5"] = 7.0
    # Mean time between two jumps of the hands, and mean duration of one.
    calm_time: Annotated[float, "s"] = 10.0
    jump_time: Annotated[float, "s"] = 0.01
    disturbance_torque_walk: Annotated[float, "N*m/s**0.5"] = 0.1  # walk of the disturbance torque at the motor's shaft
    # Walk of the disturbance torque while friction reverses; 0 for none, which leaves out one filter.
    reversal_walk: Annotated[float, "N*m/s**0.5"] = 1.0
    # Mean time between two reversals, and mean duration of one.
    reversal_time: Annotated[float, "s"] = 0.3
    reversing_time: Annotated[float, "s"] = 0.05
    # White unknown torque at the gear, of road and rack, per sample of 1 ms.
    pinion_torque_noise: Annotated[float, "N*m"] = 0.0
    # Walk of the offset, as torque of the bar; learnt within 4 s to 0.002 N·m.
    offset_walk: Annotated[float, "N*m/s**0.5"] = 1e-3
    # Sensor with an offset that is learnt: "motor_angle_mechanical" where the angles are not set to zero on the
    # unloaded bar, "driver_torque" on a bench where they are, None for neither. The two offsets are not separable: both
    # appear as a twist of the bar that its torque does not confirm.
    offset: str | None = None
    outputs: tuple[str, ...] = ColumnOutput._fields  # measured outputs

    def variances(self) -> tuple[float, ...]:
        """Variances of the measured outputs."""
        noises = {
            "steering_wheel_angle": self.steering_wheel_angle_noise,
            "motor_angle_mechanical": self.motor_angle_noise,
            "driver_torque": self.driver_torque_noise,
        }
        return tuple(noises[name] ** 2 for name in self.outputs)


# Noises of a car on the road: unmeasured torques of rack and road act on the pinion, and the angles are not zeroed.
ROAD = replace(ColumnTuning(), disturbance_torque_walk=0.5, pinion_torque_noise=1.0, offset="motor_angle_mechanical")
LONGEST_JUMP = 3.0  # least duration of a jump of the hands' torque, in samples


def usual_tuning(vehicle: Vehicle) -> ColumnTuning:
    """Tuning of the road for a vehicle file with `column_inertia`, else that of a bench."""
    return ROAD if "column_inertia" in vehicle else ColumnTuning()


def tuning_at(rate: float, usual: ColumnTuning, noise: SensorNoise, with_motor: bool) -> ColumnTuning:
    """The tuning of the observer for a sampling rate and the noise of the sensors."""
    outputs = ColumnOutput._fields if with_motor else ("steering_wheel_angle", "driver_torque")
    offset = usual.offset if with_motor or usual.offset != "motor_angle_mechanical" else None
    jump = max(usual.jump_time, LONGEST_JUMP / rate)
    return replace(
        usual,
        steering_wheel_angle_noise=noise.angle,
        motor_angle_noise=MOTOR_NOISE,
        driver_torque_noise=noise.torque,
        jump_time=jump,
        outputs=outputs,
        offset=offset,
    )


Column: TypeAlias = ColumnParameters | TwoInertiaParameters  # parameters of a column with a gear, or without one


class Layout(NamedTuple):
    """Properties of the column that the observer needs beside its filters."""

    sample_time: float  # sampling interval [s]
    stiffness: float  # stiffness between steering wheel and motor, or of the bar where there is a gear [N m/rad]
    motor_ratio: float  # turns of the motor per turn of the wheel [-]
    # hand_torque_growth, disturbance_torque_growth: growth of their variances while samples are missing [(N m)^2/s]
    hand_torque_growth: float
    disturbance_torque_growth: float
    outputs: tuple[str, ...]  # measured outputs
    offset: str  # name of the offset's state, or ""


class Designed(NamedTuple):
    """Filters of an observer and its layout."""

    bank: StationaryBank
    layout: Layout
    observation: ColumnObservation


_POSITIVE = (
    "steering_wheel_inertia",
    "torsion_bar_stiffness",
    "stiffness",
    "motor_ratio",
    "gear_stiffness",
    "gear_inertia",
    "motor_inertia",
)


def linear_of(parameters: Column) -> LinearSystem:
    """The linear column of `ColumnParameters` or `TwoInertiaParameters`."""
    if not isinstance(parameters, ColumnParameters | TwoInertiaParameters):
        raise ParameterError(
            f"the parameters are {type(parameters).__name__}; expected ColumnParameters (with gear) or "
            "TwoInertiaParameters (without)"
        )
    for name in _POSITIVE:
        value = getattr(parameters, name, 1.0)
        if not 0.0 < value < math.inf:
            raise ParameterError(f"{name} of the column is {value:g}; expected a number greater than zero")
    return linear_column(SteeringColumn if isinstance(parameters, ColumnParameters) else TwoInertiaColumn, parameters)


@lru_cache(maxsize=256, typed=True)
def design(parameters: Column, sample_time: float, tuning: ColumnTuning, hand_torque_order: int = 2) -> Designed:
    """Design the filters of the default observer.

    The result is cached, since a fleet needs the same filters for every recording of a car.
    """
    observed = _observed(parameters, sample_time, hand_torque_order, tuning.offset, tuning.outputs)
    bank = StationaryBank.design(
        observed.discrete,
        observed.model,
        observed.parameters,
        process_noises(observed.discrete.states, parameters, sample_time, tuning),
        tuning.variances(),
        _switching(sample_time, tuning, smooth=hand_torque_order > 1),
    )
    return Designed(bank, _layout(observed, parameters, sample_time, tuning), observed)


@lru_cache(maxsize=256, typed=True)  # typed: both parameter classes may hold equal numbers
def _observed(
    parameters: Column, sample_time: float, hand_torque_order: int, offset: str | None, outputs: tuple[str, ...]
) -> ColumnObservation:
    """The observed column without noises, cached because a session designs filters for usual and for measured noise."""
    observed = observed_column(linear_of(parameters), sample_time, hand_torque_order, 1, offset, outputs)
    require_fit(observed.continuous, "the column", sample_time)
    return observed


def process_noises(
    states: tuple[str, ...], parameters: Column, sample_time: float, tuning: ColumnTuning
) -> tuple[np.ndarray, ...]:
    """Process noise variances per sample for each mode: calm, jump of the hands, reversal of friction."""
    pinion = tuning.pinion_torque_noise**2 * 1e-3 * sample_time  # spectral density of a white noise given per 1 ms
    ratio = parameters.motor_ratio
    calm = {
        "hand_torque_rate": tuning.hand_torque_rate_walk**2 * sample_time,
        "disturbance_torque": tuning.disturbance_torque_walk**2 * sample_time,
        "driver_torque_offset": tuning.offset_walk**2 * sample_time,
        "motor_angle_offset": (tuning.offset_walk * ratio / _stiffness(parameters)) ** 2 * sample_time,
    }
    if isinstance(parameters, ColumnParameters):
        calm["gear_rate"] = pinion / parameters.gear_inertia**2
    else:
        calm["motor_speed"] = pinion / (ratio * parameters.motor_inertia) ** 2
    jump = calm | {"hand_torque": tuning.hand_torque_walk**2 * sample_time}
    smooth = "hand_torque_rate" in states
    chosen = [calm if smooth else jump]
    if smooth and tuning.hand_torque_walk > 0.0:
        chosen.append(jump)
    if tuning.reversal_walk > 0.0:
        chosen.append(calm | {"disturbance_torque": tuning.reversal_walk**2 * sample_time})
    return tuple(np.array([each.get(name, 0.0) for name in states]) for each in chosen)


def _switching(sample_time: float, tuning: ColumnTuning, *, smooth: bool) -> Switching:
    """Transition probabilities between the modes; events are independent of each other, and last 3 samples or more."""
    events, ends = [], []
    for walk, between, during in (
        (tuning.hand_torque_walk if smooth else 0.0, tuning.calm_time, tuning.jump_time),
        (tuning.reversal_walk, tuning.reversal_time, tuning.reversing_time),
    ):
        if not (between > 0.0 and during > 0.0):
            raise ParameterError(f"times of the tuning are {between} and {during} s; expected both above zero")
        if walk > 0.0:
            events.append(min(sample_time / between, 1.0 / 3.0))
            ends.append(min(sample_time / during, 1.0 / 3.0))
    rows = [(1.0 - sum(events), *events)]
    for k, end in enumerate(ends):
        others = [0.0 if k == j else share for j, share in enumerate(events)]
        rows.append((end, *(1.0 - end - sum(others) if k == j else share for j, share in enumerate(events))))
    return tuple(rows)


def _stiffness(parameters: Column) -> float:
    return parameters.torsion_bar_stiffness if isinstance(parameters, ColumnParameters) else parameters.stiffness


def _layout(observed: ColumnObservation, parameters: Column, sample_time: float, tuning: ColumnTuning) -> Layout:
    last = observed.discrete.states[-1]
    return Layout(
        float(sample_time),
        _stiffness(parameters),
        float(parameters.motor_ratio),
        max(tuning.hand_torque_walk, 1.0) ** 2,
        max(tuning.disturbance_torque_walk, tuning.reversal_walk) ** 2,
        tuning.outputs,
        last if tuning.offset is not None else "",
    )


def column_of_vehicle(vehicle: Vehicle, sample_time: float | None = None) -> Column:
    """The column of a vehicle, with its gear where the file gives `gear_stiffness` and the rate can follow it.

    Otherwise it has two inertias. A file with a motor inertia and no column inertia gives them directly; in other
    files, the part of `column_inertia` and `column_damping` beyond the steering wheel turns with the motor.

    Args:
        sample_time: sampling interval at which the column must be followed; None: not checked [s]
    """
    if "gear_stiffness" in vehicle:
        column = vehicle.parameters_for(ColumnParameters)
        return without_gear(column) if sample_time and gear_is_too_fast(vehicle, sample_time) else column
    if "motor_inertia" in vehicle and "column_inertia" not in vehicle:
        return _stiff(vehicle)
    below = vehicle.parameters_for(BelowBarParameters)
    needed = ("steering_wheel_inertia", "torsion_bar_stiffness", "motor_ratio")
    for name in needed:
        vehicle[name]
    if below.inertia <= 0.0 or below.damping < 0.0:
        raise ParameterError(
            f"below the torsion bar of '{vehicle.name}' remain {below.inertia:g} kg m^2 and {below.damping:g} "
            "N m s/rad of column_inertia and column_damping; expected both larger than those of the steering wheel"
        )
    ratio = vehicle["motor_ratio"]
    return TwoInertiaParameters(
        below.steering_wheel_inertia,
        below.steering_wheel_damping,
        below.torsion_bar_stiffness,
        ratio,
        below.inertia / ratio**2,
        below.damping / ratio**2,
    )


def gear_is_too_fast(vehicle: Vehicle, sample_time: float) -> bool:
    """Whether the samples would alias the vibration of the gear, but not that of the rest of the column."""
    if "gear_stiffness" not in vehicle:
        return False
    column = vehicle.parameters_for(ColumnParameters)
    whole, rest = (
        float(np.max(np.abs(np.linalg.eigvals(linear_of(each).A).imag))) for each in (column, without_gear(column))
    )
    return whole * sample_time >= math.pi > rest * sample_time


def _stiff(vehicle: Vehicle) -> TwoInertiaParameters:
    ratio, inertia = vehicle["motor_ratio"], vehicle["motor_inertia"]
    if "gear_inertia" in vehicle:
        inertia += vehicle["gear_inertia"] / ratio**2
    return TwoInertiaParameters(
        vehicle["steering_wheel_inertia"],
        vehicle["steering_wheel_damping"],
        vehicle["torsion_bar_stiffness"],
        ratio,
        inertia,
        vehicle["motor_damping"],
    )
