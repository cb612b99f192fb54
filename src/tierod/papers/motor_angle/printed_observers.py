"""The printed observers of a motor's angle in the rotor's axes: a speed, integrated from the sensor's first angle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree, Truth, named_tuple
from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import POSITIVE
from tierod.core.graph.maths import both, either, present, where
from tierod.models.linear import LinearSystem
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.monitors.motor_angle.tuning import MotorAngleTuning
from tierod.papers.motor_angle.dq_motor import DqMotorParameters, q_axis_motor, with_load
from tierod.papers.motor_angle.luenberger import LinearSpeed, full_observer, reduced_observer
from tierod.papers.motor_angle.printed_kalman import KalmanSpeed, speed_filter
from tierod.physics.angle import wrapped
from tierod.physics.clarke_park import RotorVector, StatorVector, direction, electrical_angle, park

Sample = MotorAngleObserver.Sample

AXES = ("own", "measured")
"""By which angle Park's transform turns: the observer's own, or the sensor's, as printed."""

UNITS = {
    "motor_angle": "rad",
    "motor_speed": "rad/s",
    "motor_load_torque": "N*m",
    "angle_residual_electrical": "rad",
    "standing": "",
    "nis": "",
}

WIDEST = 0.3
"""Electrical angle between two samples [rad], up to which a vector is carried on while samples are missing."""


@lru_cache(maxsize=32)
def output_class(*extras: str) -> type:
    """Class of an output: angle, speed, what else is estimated, and how the sensor differs (electrical)."""
    names = ("motor_angle", "motor_speed", *extras, "angle_residual_electrical")
    return named_tuple("Output", [(name, Annotated[float, UNITS[name]]) for name in names])


def fresh(begun: Scalar, sample: MotorAngleObserver.Sample) -> Truth:
    """Whether this sample is the first one with an angle."""
    return both(begun < 0.5, present(sample.motor_angle_mechanical))


def residual(begun: Scalar, sample: MotorAngleObserver.Sample, angle: Scalar, pole_pairs: Scalar) -> Scalar:
    """Electrical angle of the sensor less the observer's [rad]; zero until that has begun."""
    return where(begun, wrapped(pole_pairs * (sample.motor_angle_mechanical - angle)), 0.0)


FULL_POLES = (-600.0, -700.0)
"""Of the error of current and speed [1/s]: above the 500 1/s of the current itself, below a tenth of 10 kHz."""
REDUCED_POLES = (-300.0,)
"""Of the error of the speed [1/s]: slower, since the current passes unfiltered."""
LOAD_POLE = -300.0
"""Of the error of the load [1/s]: it may reverse within some 10 ms."""


class RotorFrameState(NamedTuple):
    """Memory of the speed's observer, the angle, the speed, and whether the sensor has given the beginning."""

    inner: Tree
    angle: Scalar
    speed: Scalar
    begun: Scalar


@dataclass(frozen=True)
class RotorFrameObserver:
    """A motor's angle as the integral of an estimated speed, begun by the sensor.

    Nothing corrects the angle afterwards: what the speed errs adds up.

    Args:
        inner: estimates the speed in the rotor's axes
        pole_pairs: electrical turns per turn
        sample_time: between two samples
        axes: "own" turns by the estimated angle; "measured" by the sensor's as printed, so that a fault of the sensor
            enters the voltages and currents that should find it

    Source: Reinelt et al., eqs (8), (9), (19) to (45), where the theta of (8) and (9) is electrical.
    """

    inner: LinearSpeed | KalmanSpeed
    pole_pairs: Annotated[float, ""]
    sample_time: Annotated[float, "s", POSITIVE]
    axes: str = "own"

    Sample = Sample

    def __post_init__(self) -> None:
        if self.axes not in AXES:
            raise ParameterError(f"axes is '{self.axes}'{nearest(self.axes, AXES)}; expected {' or '.join(AXES)}")

    def init(self) -> RotorFrameState:
        """State before the first sample."""
        return RotorFrameState(self.inner.start(), 0.0, 0.0, 0.0)

    def step(self, state: RotorFrameState, sample: MotorAngleObserver.Sample) -> tuple[RotorFrameState, Tree]:
        """One sample on."""
        first = fresh(state.begun, sample)
        begun = where(either(state.begun, first), 1.0, 0.0)
        before = where(first, sample.motor_angle_mechanical, state.angle)
        travel = where(state.begun, self.sample_time * state.speed, 0.0)
        inner, (speed, *extras) = self.inner.advance(state.inner, *self._turned(before + travel, travel, sample))
        angle = where(state.begun, before + 0.5 * (travel + self.sample_time * speed), before)
        away = residual(begun, sample, angle, self.pole_pairs)
        output = output_class(*self.inner.extras)(angle, speed, *extras, away)
        return RotorFrameState(inner, angle, speed, begun), output

    def _turned(
        self, predicted: Scalar, travel: Scalar, sample: MotorAngleObserver.Sample
    ) -> tuple[RotorVector, RotorVector]:
        """Voltage and current in the rotor's axes; the voltage is a mean, so it is turned by the angle halfway."""
        sensed = sample.motor_angle_mechanical
        at = predicted if self.axes == "own" else where(present(sensed), sensed, predicted)
        rotor = direction(electrical_angle(at, self.pole_pairs))
        halfway = direction(electrical_angle(at - 0.5 * travel, self.pole_pairs))
        voltage = StatorVector(sample.motor_voltage_alpha, sample.motor_voltage_beta)
        current = StatorVector(sample.motor_current_alpha, sample.motor_current_beta)
        return park(voltage, halfway), park(current, rotor)


def luenberger(
    p: DqMotorParameters,
    sample_time: float,
    *,
    load: bool = True,
    poles: tuple[float, ...] = FULL_POLES,
    axes: str = "own",
    torque_constant: str = "corrected",
) -> RotorFrameObserver:
    """Luenberger observer of a motor, (19) to (24).

    Args:
        p: of the motor; a vehicle file gives them
        sample_time: [s]
        load: whether the load is a state; without, it makes the speed wrong
        poles: of the error of current and speed [1/s]
        axes: "own" or "measured"
        torque_constant: "corrected" or "printed"

    Raises:
        ParameterError: a parameter cannot be
    """
    return _linear(full_observer, p, sample_time, load, poles, axes, torque_constant)


def reduced_luenberger(
    p: DqMotorParameters,
    sample_time: float,
    *,
    load: bool = True,
    poles: tuple[float, ...] = REDUCED_POLES,
    axes: str = "own",
    torque_constant: str = "corrected",
) -> RotorFrameObserver:
    """Reduced Luenberger observer of a motor, (25) to (33) corrected; arguments as `luenberger`."""
    return _linear(reduced_observer, p, sample_time, load, poles, axes, torque_constant)


def extended_kalman(
    p: DqMotorParameters,
    sample_time: float,
    *,
    load: bool = True,
    tuning: MotorAngleTuning | None = None,
    axes: str = "own",
    jacobian: str = "corrected",
) -> RotorFrameObserver:
    """Extended Kalman filter of a motor in the rotor's axes, (34) to (45).

    Args:
        p: of the motor; a vehicle file gives them
        sample_time: [s]
        load: whether the load is a state; without, it makes the speed wrong
        tuning: noises; the usual ones where None
        axes: "own" or "measured"
        jacobian: "corrected" or "printed"

    Raises:
        ParameterError: a parameter cannot be
    """
    inner = KalmanSpeed(speed_filter(p, sample_time, tuning or MotorAngleTuning(), load, jacobian))
    return RotorFrameObserver(inner, p.motor_pole_pairs, sample_time, axes)


def _linear(
    design: Callable[[LinearSystem, Sequence[complex]], LinearSystem],
    p: DqMotorParameters,
    sample_time: float,
    load: bool,
    poles: tuple[float, ...],
    axes: str,
    torque_constant: str,
) -> RotorFrameObserver:
    motor = q_axis_motor(p, torque_constant)
    if load:
        motor, poles = with_load(motor, p.motor_inertia), (*poles, LOAD_POLE)
    inner = LinearSpeed.of(design(motor, poles), sample_time)
    return RotorFrameObserver(inner, p.motor_pole_pairs, sample_time, axes)
