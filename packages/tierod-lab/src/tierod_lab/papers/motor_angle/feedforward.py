"""The paper's feedforward: angle of the motor from its back-EMF."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.fields import POSITIVE, check_ranges
from tierod.core.graph.maths import all_of, arctan2, both, either, hypot, limit, present, select, sqrt, where
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.friction import share_reached
from tierod.physics.motor import Direction, StatorVector, direction, park, stator_flux_rate, turned
from tierod_lab.papers.motor_angle.observers import fresh, output_class, residual

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
