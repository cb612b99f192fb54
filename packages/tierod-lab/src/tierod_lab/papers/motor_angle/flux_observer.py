"""Sensorless flux observer with a phase-locked loop, as in present-day drives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, check_ranges
from tierod.core.graph.maths import absolute, all_of, both, either, limit, present, select, where
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.clarke_park import Direction, StatorVector, direction, electrical_angle, park, turned
from tierod_lab.papers.motor_angle.printed_observers import WIDEST, Sample, flux_rate, fresh, output_class, residual


class FluxState(NamedTuple):
    """State of the observer.

    Args:
        flux: stator flux linkage [V*s]
        current: current of the last sample [A]
        known: whether that current was available
        angle: electrical angle [rad], not wrapped
        speed: electrical speed [rad/s]
        begun: whether the angle has been initialised by the sensor
    """

    flux: StatorVector
    current: StatorVector
    known: Scalar
    angle: Scalar
    speed: Scalar
    begun: Scalar


@dataclass(frozen=True)
class FluxObserver:
    """Observer that integrates the stator flux, corrects the magnitude of its magnet part and tracks its direction.

    It contains no model of the rotor, so that a load does not disturb it. At low speed it needs the exact resistance;
    at standstill the angle is not observable and drifts.

    Args:
        parameters: parameters of the motor; inertia and damping are not used
        bandwidth: both poles of the phase-locked loop
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
