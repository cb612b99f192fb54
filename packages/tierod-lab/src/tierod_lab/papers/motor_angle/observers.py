"""The paper's motor in the rotor frame, its observers of a speed, and its feedforward from the back-EMF."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.block import Model, Scalar, Tree, Truth, named_tuple, skeleton
from tierod.core.errors import ParameterError
from tierod.core.fields import POSITIVE, check_ranges
from tierod.core.graph.maths import all_of, arctan2, both, either, hypot, limit, present, select, sqrt, where
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.shapes import Belief
from tierod.models.linear import LinearSystem, Matrices, as_model, discretise, sampled
from tierod.models.stator_frame_motor import MotorParameters, SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver, MotorAngleTuning
from tierod.physics.friction import share_reached
from tierod.physics.motor import (
    Direction,
    RotorVector,
    StatorVector,
    back_emf_constant,
    current_rate,
    direction,
    electrical_angle,
    electromagnetic_torque,
    park,
    rotor_acceleration,
    stator_flux_rate,
    torque_constant,
    turned,
    wrapped,
)
from tierod_lab.methods.pole_placement import place

INPUTS = ("voltage_q", "current_q")  # Inputs of a continuous observer


class DqMotor:
    """Model of the currents in the rotor frame and the speed, with the load as an input.

    Validity: no saturation; the rotor frame turns with the true electrical angle.
    Source: Reinelt et al., eqs (12) to (14), where theta is the mechanical angle; corrected: the torque constant is
    3/2 c_M with amplitude-invariant vectors, and a salient motor makes torque by (L_sd - L_sq) i_sd i_sq too.
    """

    class State(NamedTuple):
        current_d: Annotated[float, "A"]
        current_q: Annotated[float, "A"]
        speed: Annotated[float, "rad/s"]

    class Input(NamedTuple):
        voltage_d: Annotated[float, "V"]
        voltage_q: Annotated[float, "V"]
        load_torque: Annotated[float, "N*m"]

    class Output(NamedTuple):
        current_d: Annotated[float, "A"]
        current_q: Annotated[float, "A"]

    Parameters = MotorParameters

    @staticmethod
    def derivative(x: State, u: Input, p: MotorParameters) -> State:
        return DqMotor.State(*_rates(x, u, u.load_torque, p))

    @staticmethod
    def output(x: State, u: Input, p: MotorParameters) -> Output:
        return DqMotor.Output(x.current_d, x.current_q)


class LoadedDqMotor:
    """The same model with the load as a constant state, which process noise turns into a random walk.

    Source: as `DqMotor`; the load state is an addition, since a neglected load biases the speed.
    """

    class State(NamedTuple):
        current_d: Annotated[float, "A"]
        current_q: Annotated[float, "A"]
        speed: Annotated[float, "rad/s"]
        load_torque: Annotated[float, "N*m"]

    class Input(NamedTuple):
        voltage_d: Annotated[float, "V"]
        voltage_q: Annotated[float, "V"]

    Output = DqMotor.Output
    Parameters = MotorParameters

    @staticmethod
    def derivative(x: State, u: Input, p: MotorParameters) -> State:
        return LoadedDqMotor.State(*_rates(x, u, x.load_torque, p), 0.0)

    @staticmethod
    def output(x: State, u: Input, p: MotorParameters) -> DqMotor.Output:
        return DqMotor.Output(x.current_d, x.current_q)


def _rates(x: Any, u: Any, load_torque: Scalar, p: MotorParameters) -> tuple[Scalar, Scalar, Scalar]:
    current = RotorVector(x.current_d, x.current_q)
    along, across = p.motor_inductance, p.inductance_across
    currents = current_rate(
        current,
        RotorVector(u.voltage_d, u.voltage_q),
        x.speed,
        resistance=p.motor_resistance,
        inductance_d=along,
        inductance_q=across,
        flux=p.motor_flux,
        pole_pairs=p.motor_pole_pairs,
    )
    torque = electromagnetic_torque(current, p.motor_pole_pairs, p.motor_flux, along, across)
    return (*currents, rotor_acceleration(torque, load_torque, x.speed, p.motor_inertia, p.motor_damping))


def q_axis_motor(p: MotorParameters, load: bool = False) -> LinearSystem:
    """Linear system from the q-axis voltage to the q-axis current.

    Validity: no d-axis current.
    Source: Reinelt et al., eqs (15), (16), (19) and (20), which print c_M where 3/2 c_M belongs in the mechanical row.
    """
    emf, torque = (make(p.motor_pole_pairs, p.motor_flux) for make in (back_emf_constant, torque_constant))
    A, B, C = np.zeros((3, 3)), np.array([[1.0 / p.motor_inductance], [0.0], [0.0]]), np.array([[1.0, 0.0, 0.0]])
    A[0, :2] = -p.motor_resistance / p.motor_inductance, -emf / p.motor_inductance
    A[1] = torque / p.motor_inertia, -p.motor_damping / p.motor_inertia, -1.0 / p.motor_inertia
    states = ("current_q", "speed", "load_torque")
    n = 3 if load else 2
    return LinearSystem(A[:n, :n], B[:n], C[:, :n], np.zeros((1, 1)), states[:n], ("voltage_q",), ("current_q",))


def full_observer(motor: LinearSystem, poles: Sequence[complex]) -> LinearSystem:
    """Luenberger observer as a system from voltage and current to its estimates.

    Args:
        motor: result of `q_axis_motor`, with or without load
        poles: poles of the error [1/s], one per state

    Source: Reinelt et al., eqs (21) to (24).
    """
    gain = place(motor, poles)
    A, B = motor.A - gain @ motor.C, np.hstack([motor.B, gain])
    estimated = motor.states[1:]
    return LinearSystem(A, B, np.eye(len(A))[1:], np.zeros((len(estimated), 2)), motor.states, INPUTS, estimated)


def reduced_observer(motor: LinearSystem, poles: Sequence[complex]) -> LinearSystem:
    """Reduced Luenberger observer, which takes the current as measured; its states are x_B = x_2 - K I_q.

    Args:
        motor: result of `q_axis_motor`, with or without load
        poles: poles of the error [1/s], one per state except the current

    Source: Reinelt et al., eqs (25) to (33). Corrected in (32): K multiplies c_M/L_sq in the factor of x_B and
    R_s/L_sq in that of I_sq, where z_p is printed, and the voltage counts with -K/L_sq.
    """
    estimated = motor.states[1:]
    A11, A12, A21, A22 = motor.A[:1, :1], motor.A[:1, 1:], motor.A[1:, :1], motor.A[1:, 1:]
    gain = place(LinearSystem.of(A22, A12, states=estimated), poles)
    A = A22 - gain @ A12
    current = A @ gain + A21 - gain @ A11
    voltage = motor.B[1:] - gain @ motor.B[:1]
    D = np.hstack([np.zeros_like(gain), gain])
    return LinearSystem(A, np.hstack([voltage, current]), np.eye(len(estimated)), D, estimated, INPUTS, estimated)


class LinearMemory(NamedTuple):
    """States of the observer, its last estimates, and the current of the last sample."""

    x: Tree
    estimate: Tree
    current: Scalar


@dataclass(frozen=True)
class LinearSpeed:
    """A linear observer with exact sampling, so that its steady-state errors are those of the continuous observer.

    The voltage is the mean over the sample, the current the mean of the values at its ends.
    """

    model: Model  # model, parameters: model and matrices of the sampled observer
    parameters: Matrices
    extras: tuple[str, ...]  # names of its estimates besides the speed

    @classmethod
    def of(cls, observer: LinearSystem, sample_time: float) -> LinearSpeed:
        """Sample a continuous observer, which must be stable."""
        fastest = np.linalg.eigvals(observer.A).real.max()
        if not fastest < 0.0:
            raise ParameterError(f"the observer diverges with {fastest:+.3g} 1/s; give poles below zero")
        classes = [_numbers(names) for names in (observer.states, INPUTS, observer.outputs)]
        model, parameters = as_model(sampled(observer, sample_time), *classes)
        return cls(model, parameters, ("motor_load_torque",) if "load_torque" in observer.outputs else ())

    def start(self) -> LinearMemory:
        return LinearMemory(skeleton(self.model.State), skeleton(self.model.Output), 0.0)

    def advance(
        self, before: LinearMemory, voltage: RotorVector, current: RotorVector
    ) -> tuple[LinearMemory, tuple[Scalar, ...]]:
        whole = both(present(voltage.q), present(current.q))
        mean = self.model.Input(voltage.q, 0.5 * (before.current + current.q))
        x = self.model.transition(before.x, mean, self.parameters)
        estimate = self.model.output(x, self.model.Input(voltage.q, current.q), self.parameters)
        kept = where(present(current.q), current.q, before.current)
        after = LinearMemory(select(whole, x, before.x), select(whole, estimate, before.estimate), kept)
        return after, tuple(after.estimate)


@lru_cache(maxsize=32)
def _numbers(names: tuple[str, ...]) -> type:
    return named_tuple("Numbers", [(name, Annotated[float, ""]) for name in names])


@dataclass(frozen=True)
class KalmanSpeed:
    """Speed by an extended Kalman filter with three states, or four with the load."""

    filter: KalmanFilter  # result of `speed_filter`

    @property
    def extras(self) -> tuple[str, ...]:
        """Names of the estimates besides the speed."""
        return ("motor_load_torque", "nis") if self._loaded else ("nis",)

    @property
    def _loaded(self) -> bool:
        return "load_torque" in self.filter.model.State._fields

    def start(self) -> Belief:
        return self.filter.init()

    def advance(self, before: Belief, voltage: RotorVector, current: RotorVector) -> tuple[Belief, tuple[Scalar, ...]]:
        model = self.filter.model
        inputs = model.Input(*voltage) if self._loaded else model.Input(*voltage, 0.0)
        after, estimate = self.filter.step(before, self.filter.Sample(inputs, model.Output(*current)))
        return after, (*after.mean[2:], estimate.nis)


def speed_filter(p: MotorParameters, sample_time: float, tuning: MotorAngleTuning, load: bool) -> KalmanFilter:
    """Extended Kalman filter of currents and speed, and of the load on request.

    Args:
        sample_time: sampling interval [s], at most a fifth of the electrical time constant, since (34) is discretised
            by Euler's method
        tuning: noise levels; those of voltage, current, speed and load are used

    Source: Reinelt et al., eqs (34) to (45). Corrected: the Jacobian (40) comes from the graph, and (42) takes the
    expected output at the predicted state.
    """
    share = sample_time * p.motor_resistance / p.motor_inductance
    if not share <= 0.2:
        raise ParameterError(
            f"a sample of {sample_time:g} s is {share:.2g} of the electrical time constant; expected 0.2 at most"
        )
    model = discretise(LoadedDqMotor if load else DqMotor, "euler")
    current = (tuning.voltage_noise * sample_time / p.motor_inductance) ** 2
    process = (current, current, tuning.speed_wander**2, tuning.load_wander**2)
    start = (tuning.current_noise**2, tuning.current_noise**2, tuning.first_speed**2, tuning.first_load**2)
    n = 4 if load else 3
    readings = (tuning.current_noise**2,) * 2
    return KalmanFilter(model, model.Parameters(p, sample_time), (0.0,) * n, start[:n], process[:n], readings)


UNITS = {
    "motor_angle": "rad",
    "motor_speed": "rad/s",
    "motor_load_torque": "N*m",
    "angle_residual_electrical": "rad",
    "standing": "",
    "nis": "",
}
"""Units of the outputs."""


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


class RotorFrameState(NamedTuple):
    """State of the speed observer, angle, speed, and whether the angle has been initialised by the sensor."""

    inner: Tree
    angle: Scalar
    speed: Scalar
    begun: Scalar


@dataclass(frozen=True)
class RotorFrameObserver:
    """Motor angle as the integral of an estimated speed, initialised by the sensor.

    Nothing corrects the angle afterwards, so that errors of the speed accumulate. Park's transform turns by the angle
    of the sensor, as printed, so that a fault of the sensor enters the voltages and currents that should reveal it.

    Source: Reinelt et al., eqs (8), (9), (19) to (45), where the theta of (8) and (9) is electrical.
    """

    inner: LinearSpeed | KalmanSpeed  # observer of the speed in the rotor frame
    pole_pairs: Annotated[float, ""]
    sample_time: Annotated[float, "s", POSITIVE]

    Sample = MotorAngleObserver.Sample

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
        at = where(present(sensed), sensed, predicted)
        rotor = direction(electrical_angle(at, self.pole_pairs))
        halfway = direction(electrical_angle(at - 0.5 * travel, self.pole_pairs))
        voltage = StatorVector(sample.motor_voltage_alpha, sample.motor_voltage_beta)
        current = StatorVector(sample.motor_current_alpha, sample.motor_current_beta)
        return park(voltage, halfway), park(current, rotor)


FULL_POLES = (-600.0, -700.0)
"""Poles of the error of current and speed [1/s]: faster than the current's own 500 1/s, below a tenth of 10 kHz."""
REDUCED_POLES = (-300.0,)  # Pole of the error of the speed [1/s]: slower, since the current passes through unfiltered
LOAD_POLE = -300.0  # Pole of the error of the load [1/s], which may reverse within some 10 ms


def luenberger(p: MotorParameters, sample_time: float, load: bool = True) -> RotorFrameObserver:
    """Luenberger observer of a motor, (19) to (24); without the load as a state a load biases the speed."""
    return _linear(full_observer, FULL_POLES, p, sample_time, load)


def reduced_luenberger(p: MotorParameters, sample_time: float, load: bool = True) -> RotorFrameObserver:
    """Reduced Luenberger observer of a motor, (25) to (33) corrected."""
    return _linear(reduced_observer, REDUCED_POLES, p, sample_time, load)


def extended_kalman(p: MotorParameters, sample_time: float, load: bool = True) -> RotorFrameObserver:
    """Extended Kalman filter of a motor in the rotor frame, (34) to (45)."""
    inner = KalmanSpeed(speed_filter(p, sample_time, MotorAngleTuning(), load))
    return RotorFrameObserver(inner, p.motor_pole_pairs, sample_time)


def _linear(
    design: Callable[[LinearSystem, Sequence[complex]], LinearSystem],
    poles: tuple[float, ...],
    p: MotorParameters,
    sample_time: float,
    load: bool,
) -> RotorFrameObserver:
    observer = design(q_axis_motor(p, load), (*poles, LOAD_POLE) if load else poles)
    return RotorFrameObserver(LinearSpeed.of(observer, sample_time), p.motor_pole_pairs, sample_time)


WIDEST = 0.3  # Largest electrical angle per sample by which a vector is rotated while samples are missing [rad]


class FeedforwardState(NamedTuple):
    """State of the feedforward."""

    emf: StatorVector  # filtered back-EMF [V]
    current: StatorVector  # current of the last sample [A]
    known: Scalar  # whether that current was available
    speed: Scalar  # electrical speed [rad/s]
    lagging: Scalar  # electrical angle of the filtered back-EMF [rad], not wrapped
    begun: Scalar  # whether the angle has been initialised by the sensor


@dataclass(frozen=True)
class FeedforwardAngle:
    """Motor angle from the direction of the filtered back-EMF, u - R i - L di/dt, with compensated filter lag.

    The quotient of (46) is ambiguous by half a turn: of the two angles the one within a quarter of a turn of the last
    angle is taken, which also gives the sign of the speed.

    Validity: not at low speed, where the back-EMF is too small and the angle is held. If the motor turns by a quarter
    of an electrical turn meanwhile, the angle stays wrong by half turns.
    Source: Reinelt et al., eq (46); corrected: minus L dI/dt in both axes, the arctangent of two arguments. With plus
    L dI/dt, as printed, the angle is turned by atan(2 L i_q / psi).
    """

    parameters: SampledMotorParameters
    # bandwidth of the filter, which makes the derivative causal; 300 Hz
    bandwidth: Annotated[float, "rad/s", POSITIVE] = 1885.0
    # speed below which the noise of the derivative exceeds the back-EMF, and the angle is held
    least_speed: Annotated[float, "rad/s", POSITIVE] = 6.0

    Sample = MotorAngleObserver.Sample

    def __post_init__(self) -> None:
        check_ranges(self)

    def init(self) -> FeedforwardState:
        return FeedforwardState(StatorVector(0.0, 0.0), StatorVector(0.0, 0.0), 0.0, 0.0, 0.0, 0.0)

    def step(self, state: FeedforwardState, sample: MotorAngleObserver.Sample) -> tuple[FeedforwardState, Tree]:
        p = self.parameters
        first = fresh(state.begun, sample)
        begun = where(either(state.begun, first), 1.0, 0.0)
        emf = self._emf(state, sample)
        before = where(first, p.motor_pole_pairs * sample.motor_angle_mechanical, state.lagging)
        # The sign of the speed is that for which the angle is within a quarter of a turn of the last one.
        own = park(emf, direction(before))
        sign = where(own.q < 0.0, -1.0, 1.0)
        length = hypot(emf.alpha, emf.beta)
        standing = where(length < p.motor_pole_pairs * p.motor_flux * self.least_speed, 1.0, 0.0)
        lagging = before + where(standing, 0.0, arctan2(-sign * own.d, sign * own.q))
        lag, pace = self._lag(length / p.motor_flux)
        angle = (lagging + where(standing, 0.0, sign * lag)) / p.motor_pole_pairs
        speed = where(standing, 0.0, sign * pace)
        current = StatorVector(sample.motor_current_alpha, sample.motor_current_beta)
        complete = both(present(current.alpha), present(current.beta))
        kept = select(complete, current, state.current)
        after = FeedforwardState(emf, kept, where(complete, 1.0, 0.0), speed, lagging, begun)
        away = residual(begun, sample, angle, p.motor_pole_pairs)
        return after, output_class("standing")(angle, speed / p.motor_pole_pairs, standing, away)

    def _emf(self, state: FeedforwardState, sample: MotorAngleObserver.Sample) -> StatorVector:
        p, current = self.parameters, state.current
        # The voltage is a mean over the sample, so that the ohmic drop takes the mean current.
        mean = StatorVector(
            0.5 * (sample.motor_current_alpha + current.alpha), 0.5 * (sample.motor_current_beta + current.beta)
        )
        voltage = StatorVector(sample.motor_voltage_alpha, sample.motor_voltage_beta)
        rest = stator_flux_rate(voltage, mean, p.motor_resistance)
        slope = p.motor_inductance / p.sample_time
        alpha = rest.alpha - slope * (sample.motor_current_alpha - current.alpha)
        beta = rest.beta - slope * (sample.motor_current_beta - current.beta)
        whole = all_of(present(alpha), present(beta), state.known)
        share = share_reached(p.sample_time * self.bandwidth)
        carried = turned(Direction(*state.emf), limit(p.sample_time * state.speed, -WIDEST, WIDEST))
        return StatorVector(
            where(whole, state.emf.alpha + share * (alpha - state.emf.alpha), carried.cosine),
            where(whole, state.emf.beta + share * (beta - state.emf.beta), carried.sine),
        )

    def _lag(self, filtered: Scalar) -> tuple[Scalar, Scalar]:
        """Lag of the filtered back-EMF [rad], and speed [rad/s], from its amplitude over the flux.

        A first-order filter s/(1 - a/z), a = 1 - s, reduces the amplitude by sqrt(1 + a x^2/s^2) and delays by
        atan2(a x, s + a x^2/2) at an angle x per sample, up to its third power. The mean voltage adds a lag of x/2.
        """
        p = self.parameters
        share = share_reached(p.sample_time * self.bandwidth)
        kept = 1.0 - share
        shortened = limit(filtered * p.sample_time * kept**0.5 / share, 0.0, 0.8)
        speed = filtered / sqrt(1.0 - shortened * shortened)
        per_sample = p.sample_time * speed
        behind = arctan2(kept * per_sample, share + 0.5 * kept * per_sample * per_sample)
        return behind + 0.5 * per_sample, speed
