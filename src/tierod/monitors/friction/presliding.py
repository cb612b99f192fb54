"""The default friction estimator: a regression on friction as it builds up, of a law and a length that it learns."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, NamedTuple

from tierod.errors import ParameterError
from tierod.estimators.kernels import correct
from tierod.estimators.linear_algebra import add, dot, from_diagonal, product, unpack
from tierod.filters import Butterworth
from tierod.graph.maths import absolute, all_of, exp, limit, log, maximum, sqrt, where
from tierod.models.friction_estimation import FrictionParameters
from tierod.monitors.friction.conditioning import SAMPLE_TIME, ConditionedSteering, SteeringConditioning
from tierod.monitors.friction.gate import FrictionGate
from tierod.monitors.friction.presliding_tuning import Coefficients, FrictionTorque, PreslidingTuning
from tierod.monitors.friction.steering_sample import SteeringSample
from tierod.physics.aligning import aligning_torque_from_yaw
from tierod.physics.friction_build_up import (
    RELAXED,
    BuildUp,
    exponential_build_up,
    finite_build_up,
    long_build_up,
)
from tierod.physics.steering_ratio import column_torque_of_motor, torque_at_steering_wheel
from tierod.vehicles import Vehicle

COUNTS_OF_HANDS_ON = 10.0
"""Driver's torque that opens the gate where torques are raw counts: 0.03 to 0.1 N*m at the
100 to 300 counts per N*m that are usual [assumed]."""

FASTEST_STEERING = 15.0
"""Rate of the steering wheel above which the gate closes [rad/s]: faster than people turn it even in an emergency, so a
fault of the signal or a car out of control."""


class _Regressors(NamedTuple):
    """Everything that is low-passed once more before it meets the torque balance."""

    finite: Any
    finite_sensitivity: Any
    exponential: Any
    exponential_sensitivity: Any
    long: Any
    long_sensitivity: Any
    aligning_torque: Any
    squared_aligning_torque: Any
    loaded_friction: Any
    rate: Any
    acceleration: Any
    torque: Any
    driver_torque: Any
    motor_torque: Any


@dataclass(frozen=True)
class PreslidingFrictionFilter:
    """Estimate the dry friction of the steering without the bias of pre-sliding.

    The torque balance of eq (2) with friction that builds up over an angle, in place of Tf sgn(theta'):

        Td + n Tm = sum_j F_j h_j + (k + d |rho Mz|) rho Mz + c (|rho Mz| - reference) h + offset + B w + J w'

    where each h_j follows the steering wheel by Dahl's law with exponent 1/2, 1, 2, of one common angle that is learnt.
    Both sides pass the same low-pass, after the law and not before it: filtering the angle instead would blunt the
    reversals. One scalar update per sample while the gate is open; outside of it nothing is learnt or forgotten.

    Args:
        parameters: the vehicle's; `sample_time` of them is that of the samples
        tuning: noises and priors
        conditioning: of the signals
        gate: eq (14) with an upper limit on the rate that no driver reaches (the law is valid at any rate, and the
            printed limit biases by -0.2 to -0.7 N*m, simulated), and a lower limit on speed for tyre scrub
        regressor_cutoff: of the low-pass on both sides of the balance [Hz]; 5 passes steering and stops its noise

    Validity: torques calibrated together: a common factor on both scales everything learnt and is seen by no signal.
    Source: docs/friction.md; grown from the "single-law estimator" there by six changes: the low-pass after the law,
    three laws in place of one, friction that depends on load, a trail that drops, no play, no influence of single
    outliers. What each one brings is measured there.
    """

    parameters: FrictionParameters
    tuning: PreslidingTuning = field(default_factory=PreslidingTuning)
    conditioning: SteeringConditioning = field(default_factory=SteeringConditioning)
    gate: FrictionGate = field(default_factory=lambda: FrictionGate(maximum_rate=FASTEST_STEERING, minimum_speed=3.0))
    regressor_cutoff: Annotated[float, "Hz"] = 5.0
    low_pass: Butterworth = field(init=False, repr=False)

    Sample = SteeringSample

    class State(NamedTuple):
        """Memories of conditioning, build-up and low-pass, and what has been learnt."""

        conditioning: Any
        finite: BuildUp
        exponential: BuildUp
        long: BuildUp
        low_pass: Any
        mean: Coefficients
        covariance: tuple[Any, ...]
        innovation_power: Any
        excitation: Any

    def __post_init__(self) -> None:
        sample_time = self.conditioning.sample_time
        if self.parameters.sample_time != sample_time:
            raise ParameterError(
                f"the vehicle's parameters are for samples every {self.parameters.sample_time} s, the conditioning for "
                f"every {sample_time} s; give both the same sample_time"
            )
        low_pass = Butterworth(_Regressors, sample_time, 0.0, self.regressor_cutoff)
        object.__setattr__(self, "low_pass", low_pass)

    @classmethod
    def of_vehicle(cls, vehicle: Vehicle, sample_time: float = SAMPLE_TIME) -> PreslidingFrictionFilter:
        """The filter for a car, with every tuning as measured in docs/friction.md.

        Args:
            vehicle: its parameters
            sample_time: time between two samples [s]

        Raises:
            ParameterError: the vehicle file lacks a parameter; the message names it
        """
        parameters = replace(vehicle.parameters_for(FrictionParameters), sample_time=sample_time)
        driver_torque = FrictionGate().minimum_driver_torque if vehicle.calibrated else COUNTS_OF_HANDS_ON
        gate = FrictionGate(driver_torque, maximum_rate=FASTEST_STEERING, minimum_speed=3.0)
        return cls(parameters, conditioning=SteeringConditioning(sample_time), gate=gate)

    def init(self) -> State:
        """Nothing learnt yet: the priors."""
        tuning = self.tuning
        mean = Coefficients(
            finite=0.0,
            exponential=tuning.initial_friction,
            long=0.0,
            log_dahl_angle=log(tuning.initial_dahl_angle),
            aligning_gain=1.0,
            trail_drop=0.0,
            load_share=0.0,
            offset=0.0,
            damping=self.parameters.column_damping,
            inertia=self.parameters.column_inertia,
        )
        variances = from_diagonal([deviation * deviation for deviation in tuning.deviations])
        return self.State(
            self.conditioning.init(), RELAXED, RELAXED, RELAXED, self.low_pass.init(), mean, variances, 0.0, 0.0
        )

    def step(self, state: State, sample: SteeringSample) -> tuple[State, FrictionTorque]:
        """One sample on."""
        conditioning, clean = self.conditioning.step(state.conditioning, sample)
        angle = exp(state.mean.log_dahl_angle)
        laws = (
            finite_build_up(state.finite, clean.angle_increment, angle),
            exponential_build_up(state.exponential, clean.angle_increment, angle),
            long_build_up(state.long, clean.angle_increment, angle),
        )
        low_pass, regressors = self.low_pass.step(state.low_pass, self._regressors(clean, laws))
        conditions = self.gate.conditions(
            regressors.driver_torque,
            regressors.motor_torque,
            regressors.rate,
            clean.signals.vehicle_speed,
        )
        enabled = all_of(*conditions, clean.settled, clean.present)
        row = _row(state.mean, regressors)
        innovation = regressors.torque - _expected(state.mean, row)
        spread = dot(row, product(unpack(state.covariance), row))
        mean, covariance = self._update(state, row, innovation, enabled)
        noise = self.tuning.error_density / self.conditioning.sample_time
        share = self.conditioning.sample_time / self.tuning.excitation_memory
        power = _followed(state.innovation_power, innovation * innovation, share, enabled)
        excitation = _followed(state.excitation, absolute(regressors.exponential), share, enabled)
        misfit = self._misfit(power)
        after = self.State(conditioning, *laws, low_pass, mean, covariance, power, excitation)
        return after, FrictionTorque(
            friction_torque=mean.friction_torque,
            friction_deviation=_deviation(covariance) * misfit,
            misfit=misfit,
            residual=sqrt(power),
            enabled=enabled,
            hands_on=conditions.hands_on,
            same_direction=conditions.same_direction,
            moving=conditions.moving,
            rolling=conditions.rolling,
            settled=clean.settled,
            dahl_angle=exp(mean.log_dahl_angle),
            aligning_gain=mean.aligning_gain,
            trail_drop=mean.trail_drop,
            load_share=mean.load_share,
            offset=mean.offset,
            damping=mean.damping,
            inertia=mean.inertia,
            build_up=regressors.exponential,
            excitation=excitation,
            innovation=innovation,
            innovation_variance=spread + noise,
            nis=innovation * innovation / (spread + noise),
        )

    def _regressors(self, clean: ConditionedSteering, laws: tuple[BuildUp, BuildUp, BuildUp]) -> _Regressors:
        """Both sides of the balance before their low-pass."""
        p, signals = self.parameters, clean.signals
        about_kingpins = aligning_torque_from_yaw(
            signals.lateral_acceleration,
            clean.yaw_acceleration,
            mass=p.mass,
            yaw_inertia=p.yaw_inertia,
            front_distance=p.front_distance,
            rear_distance=p.rear_distance,
            trail=p.trail,
        )
        aligning = torque_at_steering_wheel(about_kingpins, p.steering_ratio)
        finite, exponential, long = laws
        return _Regressors(
            *finite,
            *exponential,
            *long,
            aligning_torque=aligning,
            squared_aligning_torque=aligning * absolute(aligning),
            loaded_friction=exponential.level * (absolute(aligning) - self.tuning.reference_load),
            rate=signals.steering_wheel_rate,
            acceleration=clean.steering_wheel_acceleration,
            torque=signals.driver_torque + column_torque_of_motor(signals.motor_torque, p.motor_ratio),
            driver_torque=signals.driver_torque,
            motor_torque=signals.motor_torque,
        )

    def _update(
        self, state: State, row: Coefficients, innovation: Any, enabled: Any
    ) -> tuple[Coefficients, tuple[Any, ...]]:
        """One scalar update where enabled; elsewhere neither mean nor covariance changes."""
        tuning, sample_time = self.tuning, self.conditioning.sample_time
        noise = tuning.error_density / sample_time * maximum(1.0, absolute(innovation) / tuning.outlier)
        correction = correct(state.covariance, [row], [where(enabled, innovation, math.inf)], [noise], state.mean)
        mean = Coefficients(*correction.shift)
        smallest, largest = log(tuning.smallest_dahl_angle), log(tuning.largest_dahl_angle)
        wander = tuning.error_density / (tuning.memory * tuning.memory)
        process = tuning.process
        gained = process._replace(
            finite=wander * process.finite, exponential=wander * process.exponential, long=wander * process.long
        )
        growth = from_diagonal([where(enabled, rate * sample_time, 0.0) for rate in gained])
        return (
            mean._replace(log_dahl_angle=limit(mean.log_dahl_angle, smallest, largest)),
            add(correction.covariance, growth),
        )

    def _misfit(self, innovation_power: Any) -> Any:
        """Factor on the standard deviation where the balance fits worse than the tuning expects."""
        expected = self.tuning.error_density / self.tuning.error_time
        return sqrt(maximum(1.0, innovation_power / expected))


def _row(mean: Coefficients, regressors: _Regressors) -> Coefficients:
    """d torque / d coefficient."""
    return Coefficients(
        finite=regressors.finite,
        exponential=regressors.exponential,
        long=regressors.long,
        log_dahl_angle=mean.finite * regressors.finite_sensitivity
        + mean.exponential * regressors.exponential_sensitivity
        + mean.long * regressors.long_sensitivity,
        aligning_gain=regressors.aligning_torque,
        trail_drop=regressors.squared_aligning_torque,
        load_share=regressors.loaded_friction,
        offset=1.0,
        damping=regressors.rate,
        inertia=regressors.acceleration,
    )


def _expected(mean: Coefficients, row: Coefficients) -> Any:
    """Torque of the balance: linear in every coefficient but the angle, which acts through the build-up."""
    return dot(mean, row._replace(log_dahl_angle=0.0))


def _deviation(covariance: tuple[Any, ...]) -> Any:
    """Standard deviation of the friction torque, the sum of its three shares."""
    full = unpack(covariance)
    return sqrt(maximum(sum(full[i][j] for i in range(3) for j in range(3)), 0.0))


def _followed(average: Any, value: Any, share: Any, enabled: Any) -> Any:
    """A running mean over the enabled samples."""
    return where(enabled, average + share * (value - average), average)
