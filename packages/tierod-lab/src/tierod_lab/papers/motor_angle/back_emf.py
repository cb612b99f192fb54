"""Angle from the back-EMF: the paper's feedforward, alone and with an observer of the rotor, and a flux observer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar, Tree, Truth
from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, check_ranges
from tierod.core.graph.maths import absolute, all_of, arctan2, both, either, hypot, limit, present, select, sqrt, where
from tierod.methods.estimators.linear_algebra import add
from tierod.models.linear import LinearSystem, sampled
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.clarke_park import Direction, StatorVector, direction, electrical_angle, park, turned, wrapped
from tierod.physics.lag import share_reached
from tierod.physics.pm_motor import rotor_acceleration, torque_constant
from tierod_lab.methods.pole_placement import discrete_poles, observer_gain
from tierod_lab.papers.motor_angle.observers import WIDEST, Sample, flux_rate, fresh, output_class, residual

READINGS = ("corrected", "printed")  # Sign of the inductive term in (46): minus, or plus as printed
SLOW = ("held", "increments")
"""Behaviour while the back-EMF is too small: hold the angle, or follow the increments of the sensor."""


class FeedforwardState(NamedTuple):
    """State of the feedforward."""

    emf: StatorVector  # filtered back-EMF [V]
    current: StatorVector  # current of the last sample [A]
    known: Scalar  # whether that current was available
    speed: Scalar  # electrical speed [rad/s]
    lagging: Scalar  # electrical angle of the filtered back-EMF [rad], not wrapped
    sensed: Scalar  # last angle of the sensor [rad]
    begun: Scalar  # whether the angle has been initialised by the sensor


class Turning(NamedTuple):
    """Angle and speed from the back-EMF."""

    lagging: Scalar  # electrical angle of the filtered back-EMF [rad]
    electrical_angle: Scalar  # the same, compensated for the lag of the filter [rad]
    electrical_speed: Scalar  # signed electrical speed [rad/s]
    standing: Scalar  # 1 while the back-EMF is too small for an angle


@dataclass(frozen=True)
class FeedforwardAngle:
    """Motor angle from the direction of the filtered back-EMF, u - R i - L di/dt, with compensated filter lag.

    Args:
        bandwidth: bandwidth of the filter, which makes the derivative causal [rad/s]; 300 Hz
        least_speed: speed below which the noise of the derivative exceeds the back-EMF, and `slow` applies
        reading: "corrected", or "printed" with +L di/dt, which turns the angle by atan(2 L i_q / psi)
        slow: below the least speed the angle is "held", or follows the "increments" of the sensor

    The quotient of (46) is ambiguous by half a turn: of the two angles the one within a quarter of a turn of the last
    angle is taken, which also gives the sign of the speed.

    Validity: not at low speed, where the back-EMF is too small. If the motor turns by a quarter of an electrical turn
    while the angle is held, the angle stays wrong by half turns.
    Source: Reinelt et al., eq (46); corrected: minus L dI/dt in both axes, the arctangent of two arguments.
    """

    parameters: SampledMotorParameters
    bandwidth: Annotated[float, "rad/s", POSITIVE] = 1885.0
    least_speed: Annotated[float, "rad/s", POSITIVE] = 6.0
    reading: str = "corrected"
    slow: str = "held"

    Sample = Sample

    def __post_init__(self) -> None:
        check_ranges(self)
        for name, known in (("reading", READINGS), ("slow", SLOW)):
            if getattr(self, name) not in known:
                raise ParameterError(
                    f"{name} is '{getattr(self, name)}'{nearest(getattr(self, name), known)}; "
                    f"expected {' or '.join(known)}"
                )

    def init(self) -> FeedforwardState:
        none = StatorVector(0.0, 0.0)
        return FeedforwardState(none, none, 0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, state: FeedforwardState, sample: MotorAngleObserver.Sample) -> tuple[FeedforwardState, Tree]:
        pole_pairs = self.parameters.motor_pole_pairs
        after, turning = self.turned(state, sample)
        angle = turning.electrical_angle / pole_pairs
        away = residual(after.begun, sample, angle, pole_pairs)
        speed = turning.electrical_speed / pole_pairs
        return after, output_class("standing")(angle, speed, turning.standing, away)

    def turned(self, state: FeedforwardState, sample: MotorAngleObserver.Sample) -> tuple[FeedforwardState, Turning]:
        """Advance by one sample; returns the state, and angle and speed from the back-EMF."""
        p = self.parameters
        first = fresh(state.begun, sample)
        begun = where(either(state.begun, first), 1.0, 0.0)
        emf = self._emf(state, sample)
        before = where(first, p.motor_pole_pairs * sample.motor_angle_mechanical, state.lagging)
        turning = self._turning(emf, before, self._increment(state, sample))
        current, complete = (
            StatorVector(sample.motor_current_alpha, sample.motor_current_beta),
            self._has_current(sample),
        )
        kept = select(complete, current, state.current)
        sensed = where(present(sample.motor_angle_mechanical), sample.motor_angle_mechanical, state.sensed)
        known, speed = where(complete, 1.0, 0.0), turning.electrical_speed
        return FeedforwardState(emf, kept, known, speed, turning.lagging, sensed, begun), turning

    def _has_current(self, sample: MotorAngleObserver.Sample) -> Truth:
        return both(present(sample.motor_current_alpha), present(sample.motor_current_beta))

    def _emf(self, state: FeedforwardState, sample: MotorAngleObserver.Sample) -> StatorVector:
        p = self.parameters
        rest = flux_rate(sample, state.current, p)
        slope = p.motor_inductance / p.sample_time * (1.0 if self.reading == "printed" else -1.0)
        alpha = rest.alpha + slope * (sample.motor_current_alpha - state.current.alpha)
        beta = rest.beta + slope * (sample.motor_current_beta - state.current.beta)
        whole = all_of(present(alpha), present(beta), state.known)
        share = share_reached(p.sample_time * self.bandwidth)
        carried = turned(Direction(*state.emf), limit(p.sample_time * state.speed, -WIDEST, WIDEST))
        return StatorVector(
            where(whole, state.emf.alpha + share * (alpha - state.emf.alpha), carried.cosine),
            where(whole, state.emf.beta + share * (beta - state.emf.beta), carried.sine),
        )

    def _increment(self, state: FeedforwardState, sample: MotorAngleObserver.Sample) -> Scalar:
        """Increment of the electrical angle by the sensor [rad]; 0 where it is not used or missing."""
        if self.slow == "held":
            return 0.0
        gained = wrapped(sample.motor_angle_mechanical - state.sensed)
        return self.parameters.motor_pole_pairs * where(both(present(gained), state.begun), gained, 0.0)

    def _turning(self, emf: StatorVector, before: Scalar, increment: Scalar) -> Turning:
        p = self.parameters
        own = park(emf, direction(before))
        sign = where(own.q < 0.0, -1.0, 1.0)
        length = hypot(emf.alpha, emf.beta)
        standing = where(length < p.motor_pole_pairs * p.motor_flux * self.least_speed, 1.0, 0.0)
        lagging = before + where(standing, increment, arctan2(-sign * own.d, sign * own.q))
        lag, speed = self._lag(length / p.motor_flux)
        moved = where(standing, 0.0, sign * lag)
        return Turning(lagging, lagging + moved, where(standing, 0.0, sign * speed), standing)

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


FOLLOWING_POLES = (-250.0, -251.0, -252.0)
"""Poles of the error of angle, speed and load [1/s]: faster than load reversals, slower than the derivative filter."""


class RotorState(NamedTuple):
    """Angle, speed and load torque of the rotor."""

    angle: Annotated[float, "rad"]
    speed: Annotated[float, "rad/s"]
    load_torque: Annotated[float, "N*m"]


class FollowedState(NamedTuple):
    """States of feedforward and rotor, and whether the angle has been initialised by the sensor."""

    feedforward: FeedforwardState
    rotor: RotorState
    begun: Scalar


@dataclass(frozen=True)
class FeedforwardWithLoad:
    """Luenberger observer of angle, speed and load, driven by the torque of the current, corrected by the angle (46).

    Args:
        gain: corrections of angle, speed and load per radian of difference between the two angles

    While the back-EMF is too small, the observer is corrected by the held angle: otherwise a load that reverses at
    standstill would carry the angle away.

    Source: Reinelt et al., eqs (16) and (46); the combination and the load are additions.
    """

    feedforward: FeedforwardAngle
    gain: tuple[float, float, float]

    Sample = Sample

    @classmethod
    def of(
        cls, parameters: SampledMotorParameters, poles: tuple[float, ...] = FOLLOWING_POLES, slow: str = "held"
    ) -> FeedforwardWithLoad:
        """Design the observer of a motor.

        Args:
            poles: poles of the error of angle, speed and load [1/s]
            slow: behaviour of `FeedforwardAngle` below its least speed

        Raises:
            ParameterError: the poles cannot be placed
        """
        p, A = parameters, np.zeros((3, 3))
        A[0, 1], A[1, 1], A[1, 2] = 1.0, -p.motor_damping / p.motor_inertia, -1.0 / p.motor_inertia
        system = sampled(LinearSystem.of(A, [[1.0, 0.0, 0.0]], states=RotorState._fields), p.sample_time)
        gain = observer_gain(system, discrete_poles(poles, p.sample_time))
        return cls(FeedforwardAngle(p, slow=slow), tuple(row[0] for row in gain))  # type: ignore[arg-type]

    def init(self) -> FollowedState:
        return FollowedState(self.feedforward.init(), RotorState(0.0, 0.0, 0.0), 0.0)

    def step(self, state: FollowedState, sample: MotorAngleObserver.Sample) -> tuple[FollowedState, Tree]:
        p = self.feedforward.parameters
        first = fresh(state.begun, sample)
        inner, turning = self.feedforward.turned(state.feedforward, sample)
        rotor = self._predicted(state.rotor, sample)
        away = turning.electrical_angle / p.motor_pole_pairs - rotor.angle
        usable = both(inner.begun, present(away))
        shift = where(usable, away, 0.0)
        rotor = RotorState(*add(rotor, tuple(gain * shift for gain in self.gain)))
        begun = inner.begun
        rotor = select(begun, rotor, state.rotor)
        rotor = rotor._replace(angle=where(first, sample.motor_angle_mechanical, rotor.angle))
        away_from_sensor = residual(begun, sample, rotor.angle, p.motor_pole_pairs)
        output = output_class("motor_load_torque", "standing")(
            rotor.angle, rotor.speed, rotor.load_torque, turning.standing, away_from_sensor
        )
        return FollowedState(inner, rotor, begun), output

    def _predicted(self, rotor: RotorState, sample: MotorAngleObserver.Sample) -> RotorState:
        """Prediction of the rotor by the torque of the current; constant speed where the current is missing."""
        p = self.feedforward.parameters
        own = direction(electrical_angle(rotor.angle, p.motor_pole_pairs))
        current = park(StatorVector(sample.motor_current_alpha, sample.motor_current_beta), own)
        torque = torque_constant(p.motor_pole_pairs, p.motor_flux) * current.q
        gained = p.sample_time * rotor_acceleration(
            torque, rotor.load_torque, rotor.speed, p.motor_inertia, p.motor_damping
        )
        gained = where(present(gained), gained, 0.0)
        angle = rotor.angle + p.sample_time * (rotor.speed + 0.5 * gained)
        return RotorState(angle, rotor.speed + gained, rotor.load_torque)


class FluxState(NamedTuple):
    """State of the observer."""

    flux: StatorVector  # stator flux linkage [V*s]
    current: StatorVector  # current of the last sample [A]
    known: Scalar  # whether that current was available
    angle: Scalar  # electrical angle [rad], not wrapped
    speed: Scalar  # electrical speed [rad/s]
    begun: Scalar  # whether the angle has been initialised by the sensor


@dataclass(frozen=True)
class FluxObserver:
    """Observer that integrates the stator flux, corrects the magnitude of its magnet part and tracks its direction.

    It contains no model of the rotor, so that a load does not disturb it. At low speed it needs the exact resistance;
    at standstill the angle is not observable and drifts.

    Args:
        parameters: parameters of the motor; inertia and damping are not used
        damping: growth of the correction of the magnitude with the speed

    Source: Hinkkanen, Saarakkala, Awan, Molsa, Tuovinen, IEEE Trans. Ind. Appl. 54 (2018) 5506,
    doi 10.1109/TIA.2018.2858753, eqs (9), (10), (30) and (36) for a motor without saliency, in the stator's axes; that
    flux is the active flux of Boldea, Paicu, Andreescu, IEEE Trans. Power Electron. 23 (2008) 2612.
    """

    parameters: SampledMotorParameters
    bandwidth: Annotated[float, "rad/s", POSITIVE] = 400.0
    damping: Annotated[float, "", NOT_NEGATIVE] = 0.2

    Sample = Sample

    def __post_init__(self) -> None:
        check_ranges(self)

    def init(self) -> FluxState:
        return FluxState(StatorVector(self.parameters.motor_flux, 0.0), StatorVector(0.0, 0.0), 0.0, 0.0, 0.0, 0.0)

    def step(self, state: FluxState, sample: MotorAngleObserver.Sample) -> tuple[FluxState, Tree]:
        p, time = self.parameters, self.parameters.sample_time
        first = fresh(state.begun, sample)
        begun = where(either(state.begun, first), 1.0, 0.0)
        current = StatorVector(sample.motor_current_alpha, sample.motor_current_beta)
        ahead = state.angle + time * state.speed
        rotor = direction(ahead)
        flux = self._advanced(state, sample)
        magnets = park(self._less_leakage(flux, current), rotor)
        known = both(present(magnets.d), present(magnets.q))
        short = where(known, p.motor_flux - magnets.d, 0.0)
        away = where(known, limit(magnets.q / p.motor_flux, -1.0, 1.0), 0.0)
        kept = limit(
            (p.motor_resistance / p.motor_inductance + 2.0 * self.damping * absolute(state.speed)) * time, 0.0, 1.0
        )
        flux = StatorVector(flux.alpha + kept * short * rotor.cosine, flux.beta + kept * short * rotor.sine)
        angle = ahead + 2.0 * self.bandwidth * time * away
        speed = state.speed + self.bandwidth * self.bandwidth * time * away
        after = self._begun(state, first, begun, sample, FluxState(flux, current, 1.0, angle, speed, begun))
        shaft = after.angle / p.motor_pole_pairs
        away_from_sensor = residual(begun, sample, shaft, p.motor_pole_pairs)
        return after, output_class()(shaft, after.speed / p.motor_pole_pairs, away_from_sensor)

    def _advanced(self, state: FluxState, sample: MotorAngleObserver.Sample) -> StatorVector:
        p = self.parameters
        rate = flux_rate(sample, state.current, p)
        whole = all_of(present(rate.alpha), present(rate.beta), state.known)
        travel = limit(p.sample_time * state.speed, -WIDEST, WIDEST)
        carried = turned(Direction(*state.flux), travel)
        return StatorVector(
            where(whole, state.flux.alpha + p.sample_time * rate.alpha, carried.cosine),
            where(whole, state.flux.beta + p.sample_time * rate.beta, carried.sine),
        )

    def _less_leakage(self, flux: StatorVector, current: StatorVector) -> StatorVector:
        inductance = self.parameters.motor_inductance
        return StatorVector(flux.alpha - inductance * current.alpha, flux.beta - inductance * current.beta)

    def _begun(
        self, state: FluxState, first: Scalar, begun: Scalar, sample: MotorAngleObserver.Sample, after: FluxState
    ) -> FluxState:
        p = self.parameters
        at = electrical_angle(sample.motor_angle_mechanical, p.motor_pole_pairs)
        rotor: Direction = direction(at)
        known = both(present(after.current.alpha), present(after.current.beta))
        made = [where(known, p.motor_inductance * each, 0.0) for each in after.current]
        flux = [
            where(first, p.motor_flux * axis + own, where(state.begun, new, old))
            for axis, own, new, old in zip(rotor, made, after.flux, state.flux, strict=True)
        ]
        current = select(known, after.current, state.current)
        angle = where(first, at, where(state.begun, after.angle, state.angle))
        speed = where(state.begun, after.speed, state.speed)
        known = where(known, 1.0, 0.0)
        return FluxState(StatorVector(*flux), current, known, angle, speed, begun)
