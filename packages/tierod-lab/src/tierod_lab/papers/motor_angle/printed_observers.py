"""The paper's observers in the rotor frame, which integrate an estimated speed from the first angle of the sensor."""

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
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver, MotorAngleTuning
from tierod.physics.angle import wrapped
from tierod.physics.clarke_park import RotorVector, StatorVector, direction, electrical_angle, park
from tierod.physics.pm_motor import stator_flux_rate
from tierod_lab.papers.motor_angle.dq_motor import DqMotorParameters, q_axis_motor, with_load
from tierod_lab.papers.motor_angle.luenberger import LinearSpeed, full_observer, reduced_observer
from tierod_lab.papers.motor_angle.printed_kalman import KalmanSpeed, speed_filter

Sample = MotorAngleObserver.Sample

AXES = ("own", "measured")
"""Angle of Park's transform: the observer's own, or that of the sensor, as printed."""

UNITS = {
    "motor_angle": "rad",
    "motor_speed": "rad/s",
    "motor_load_torque": "N*m",
    "angle_residual_electrical": "rad",
    "standing": "",
    "nis": "",
}
"""Units of the outputs."""

WIDEST = 0.3
"""Largest electrical angle per sample by which a vector is rotated while samples are missing [rad]."""


@lru_cache(maxsize=32)
def output_class(*extras: str) -> type:
    """Output class of an observer: angle, speed, further estimates, and electrical residual of the sensor."""
    names = ("motor_angle", "motor_speed", *extras, "angle_residual_electrical")
    return named_tuple("Output", [(name, Annotated[float, UNITS[name]]) for name in names])


def fresh(begun: Scalar, sample: MotorAngleObserver.Sample) -> Truth:
    """Whether this sample is the first with an angle of the sensor, which initialises an observer."""
    return both(begun < 0.5, present(sample.motor_angle_mechanical))


def residual(begun: Scalar, sample: MotorAngleObserver.Sample, angle: Scalar, pole_pairs: Scalar) -> Scalar:
    """Electrical angle of the sensor less that of the observer [rad]; zero before the initialisation."""
    return where(begun, wrapped(pole_pairs * (sample.motor_angle_mechanical - angle)), 0.0)


def flux_rate(sample: MotorAngleObserver.Sample, before: StatorVector, p: SampledMotorParameters) -> StatorVector:
    """Rate of the stator flux over a sample [V], from the current of the sample before [A]."""
    # The voltage is a mean over the sample, so that the ohmic drop takes the mean current.
    mean = StatorVector(
        0.5 * (sample.motor_current_alpha + before.alpha), 0.5 * (sample.motor_current_beta + before.beta)
    )
    voltage = StatorVector(sample.motor_voltage_alpha, sample.motor_voltage_beta)
    return stator_flux_rate(voltage, mean, p.motor_resistance)


FULL_POLES = (-600.0, -700.0)
"""Poles of the error of current and speed [1/s]: faster than the current's own 500 1/s, below a tenth of 10 kHz."""
REDUCED_POLES = (-300.0,)
"""Pole of the error of the speed [1/s]: slower, since the current passes through unfiltered."""
LOAD_POLE = -300.0
"""Pole of the error of the load [1/s], which may reverse within some 10 ms."""


class RotorFrameState(NamedTuple):
    """State of the speed observer, angle, speed, and whether the angle has been initialised by the sensor."""

    inner: Tree
    angle: Scalar
    speed: Scalar
    begun: Scalar


@dataclass(frozen=True)
class RotorFrameObserver:
    """Motor angle as the integral of an estimated speed, initialised by the sensor.

    Nothing corrects the angle afterwards, so that errors of the speed accumulate.

    Args:
        inner: observer of the speed in the rotor frame
        pole_pairs: electrical turns per mechanical turn
        sample_time: sampling interval
        axes: angle of Park's transform: "own", the estimated one; or "measured", that of the sensor as printed, so that
            a fault of the sensor enters the voltages and currents that should reveal it

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
        return RotorFrameState(self.inner.start(), 0.0, 0.0, 0.0)

    def step(self, state: RotorFrameState, sample: MotorAngleObserver.Sample) -> tuple[RotorFrameState, Tree]:
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
        """Voltage and current in the rotor frame; the voltage is a mean over the sample, at the angle halfway."""
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
        p: parameters of the motor, from a vehicle file
        sample_time: sampling interval [s]
        load: whether the load is a state; otherwise a load biases the speed
        poles: poles of the error of current and speed [1/s]
        axes: "own" or "measured"
        torque_constant: "corrected" or "printed"

    Raises:
        ParameterError: a parameter is not possible
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
    """Reduced Luenberger observer of a motor, (25) to (33) corrected; arguments as in `luenberger`."""
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
    """Extended Kalman filter of a motor in the rotor frame, (34) to (45).

    Args:
        p: parameters of the motor, from a vehicle file
        sample_time: sampling interval [s]
        load: whether the load is a state; otherwise a load biases the speed
        tuning: noise levels; the defaults where None
        axes: "own" or "measured"
        jacobian: "corrected" or "printed"

    Raises:
        ParameterError: a parameter is not possible
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
