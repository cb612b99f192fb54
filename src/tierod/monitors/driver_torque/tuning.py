"""Tuning of the column observers, and what follows from it and a column's parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.errors import ParameterError
from tierod.methods.analysis.fitness import require_fit
from tierod.methods.estimators.mixing import Switching
from tierod.methods.estimators.stationary_bank import StationaryBank
from tierod.models.column_observation import ColumnObservation, linear_column, observed_column
from tierod.models.linear import LinearSystem
from tierod.models.steering_column import ColumnOutput, ColumnParameters, SteeringColumn
from tierod.models.two_inertia_column import TwoInertiaColumn, TwoInertiaParameters


@dataclass(frozen=True)
class ColumnTuning:
    """Noises of a column and its sensors; those of a walk are per square root of a second.

    The defaults are those of a bench with 0.1 N·m of friction at the motor, tuned on simulated runs: two with hands
    that jump and two with hands that pull within 100 ms; what is reported comes from others.

    Args:
        steering_wheel_angle_noise, motor_angle_noise, driver_torque_noise: standard deviation of a sample
        hand_torque_rate_walk: of the rate of the hands' torque, while they move smoothly
        hand_torque_walk: of the torque itself while it jumps; 0 for hands that never do, which leaves one filter
        calm_time, jump_time: between two jumps of the hands, and for which the filter for one has its say, in the mean
        disturbance_torque_walk: at the motor's shaft
        reversal_walk: of the disturbance torque while friction reverses; 0 for none, which leaves a filter less
        reversal_time, reversing_time: between two reversals, and for which one lasts, in the mean
        pinion_torque_noise: white unknown torque at the gear, of road and rack, per sample of 1 ms
        offset_walk: of the offset, as torque of the bar: learnt within 4 s to 0.002 N·m
        offset: sensor with an offset that is learnt: "motor_angle_mechanical" where nobody has set the angles to zero
            on the unloaded bar, "driver_torque" on a bench where somebody has, None for neither. Both at once show
            themselves alike: as a twist of the bar that its torque does not confirm
        outputs: that are measured
    """

    steering_wheel_angle_noise: Annotated[float, "rad"] = math.radians(0.05)
    motor_angle_noise: Annotated[float, "rad"] = math.radians(0.2)
    driver_torque_noise: Annotated[float, "N*m"] = 0.02
    hand_torque_rate_walk: Annotated[float, "N*m/s**1.5"] = 5.0
    hand_torque_walk: Annotated[float, "N*m/s**0.5"] = 7.0
    calm_time: Annotated[float, "s"] = 10.0
    jump_time: Annotated[float, "s"] = 0.01
    disturbance_torque_walk: Annotated[float, "N*m/s**0.5"] = 0.1
    reversal_walk: Annotated[float, "N*m/s**0.5"] = 1.0
    reversal_time: Annotated[float, "s"] = 0.3
    reversing_time: Annotated[float, "s"] = 0.05
    pinion_torque_noise: Annotated[float, "N*m"] = 0.0
    offset_walk: Annotated[float, "N*m/s**0.5"] = 1e-3
    offset: str | None = None
    outputs: tuple[str, ...] = ColumnOutput._fields

    def variances(self) -> tuple[float, ...]:
        """Of the outputs that are measured."""
        noises = {
            "steering_wheel_angle": self.steering_wheel_angle_noise,
            "motor_angle_mechanical": self.motor_angle_noise,
            "driver_torque": self.driver_torque_noise,
        }
        return tuple(noises[name] ** 2 for name in self.outputs)


class Layout(NamedTuple):
    """What a step needs to know of the column beside its filters.

    Args:
        sample_time: [s]
        stiffness: between steering wheel and motor, or of the bar where there is a gear [N m/rad]
        motor_ratio: []
        hand_torque_growth, disturbance_torque_growth: of their variances while samples are missing [(N m)^2/s]
        outputs: that are measured
        offset: name of the offset's state, or ""
    """

    sample_time: float
    stiffness: float
    motor_ratio: float
    hand_torque_growth: float
    disturbance_torque_growth: float
    outputs: tuple[str, ...]
    offset: str


class Designed(NamedTuple):
    """An observer's filters and its layout."""

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


def linear_of(parameters: Any) -> LinearSystem:
    """The linear column of `ColumnParameters` or `TwoInertiaParameters`.

    Raises:
        ParameterError: other parameters, or inertias, stiffness or ratio that are not positive
    """
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


def design(parameters: Any, sample_time: float, tuning: ColumnTuning, hand_torque_order: int = 2) -> Designed:
    """Filters of the default observer.

    Args:
        parameters: `ColumnParameters` or `TwoInertiaParameters`
        sample_time: [s]
        tuning: noises
        hand_torque_order: 2 for a torque with a rate; 1 for one that walks by itself, always as fast as in a jump

    Raises:
        ParameterError: the column is unstable, cannot be observed, or is too fast for the rate; the eigenvalue or the
            direction is named
    """
    column = linear_of(parameters)
    observed = observed_column(column, sample_time, hand_torque_order, 1, tuning.offset, tuning.outputs)
    require_fit(observed.continuous, "the column", stable="marginal", observable=True, sample_time=sample_time)
    bank = StationaryBank.design(
        observed.discrete,
        observed.model,
        observed.parameters,
        process_noises(observed.discrete.states, parameters, sample_time, tuning),
        tuning.variances(),
        _switching(sample_time, tuning, smooth=hand_torque_order > 1),
    )
    return Designed(bank, _layout(observed, parameters, sample_time, tuning), observed)


def process_noises(
    states: tuple[str, ...], parameters: Any, sample_time: float, tuning: ColumnTuning
) -> tuple[np.ndarray, ...]:
    """Variance that each state gains per sample: with nothing new, while the hands jump, while friction reverses."""
    pinion = tuning.pinion_torque_noise**2 * 1e-3 * sample_time  # intensity of white noise given per sample of 1 ms
    ratio = parameters.motor_ratio
    calm = {
        "hand_torque_rate": tuning.hand_torque_rate_walk**2 * sample_time,
        "disturbance_torque": tuning.disturbance_torque_walk**2 * sample_time,
        "driver_torque_offset": tuning.offset_walk**2 * sample_time,
        "motor_angle_offset": (tuning.offset_walk * ratio / _stiffness(parameters)) ** 2 * sample_time,
    }
    if "gear_rate" in states:
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
    """Events come alike whatever goes on: a jump is no less likely in a reversal. None is shorter than 3 samples."""
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


def _stiffness(parameters: Any) -> float:
    """Of the bar where there is a gear, else of the one spring."""
    with_gear = isinstance(parameters, ColumnParameters)
    return float(parameters.torsion_bar_stiffness if with_gear else parameters.stiffness)


def _layout(observed: ColumnObservation, parameters: Any, sample_time: float, tuning: ColumnTuning) -> Layout:
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
