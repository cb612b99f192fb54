"""The default friction estimator: a regression on friction as it builds up; law and Dahl angle are learnt."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar, NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import absolute, all_of, exp, limit, log, maximum, minimum, sqrt, where
from tierod.methods.estimators.kernels import correct
from tierod.methods.estimators.linear_algebra import add, dot, from_diagonal, product, unpack
from tierod.methods.filters import Butterworth
from tierod.models.friction_estimation import FrictionParameters
from tierod.monitors.friction.judged import VerdictSample
from tierod.monitors.friction.signals import SAMPLE_TIME, FrictionGate, SteeringConditioning, SteeringSample
from tierod.monitors.friction.torque_balance import (
    ROLLING_SPEED,
    Coefficients,
    PreslidingTuning,
    Regressors,
    column_motion,
    expected_torque,
    reference_load,
    regressors,
    row_of,
)
from tierod.physics.friction import RELAXED, BuildUp, build_ups
from tierod.vehicles import Vehicle

COUNTS_OF_HANDS_ON = 10.0
"""Driver's torque in raw counts that opens the gate; 0.03 to 0.1 N*m at the usual 100 to 300 counts per N*m
[assumed]."""

FASTEST_STEERING = 15.0
"""Rate of the steering wheel above which the gate closes [rad/s]; drivers do not reach it even in an emergency, so a
higher rate is a signal fault or a car out of control."""


class FrictionTorque(NamedTuple):
    """Output of the estimator after a sample.

    Args:
        friction_torque: level of dry friction at the steering wheel axis, at the reference load
        friction_deviation: its standard deviation, for correct torque sensors
        misfit: factor by which it was widened because the torque balance fits worse than the tuning expects
        residual: root mean square of `innovation` over the last enabled time
        enabled: 1 where the sample was used
        hands_on, same_direction, moving, rolling, settled: the enabling conditions, one by one
        dahl_angle: travel over which friction builds up
        aligning_gain, trail_drop, weight_lever, turn_slip, drive_share, load_share, offset, damping, inertia: see
            `Coefficients`
        reference_load: road torque at the steering wheel for which friction is stated
        build_up: share of the full level that friction has reached, with sign
        excitation: mean magnitude of `build_up` over the enabled time; 1 is permanent sliding, below 0.5 the strokes
            end before friction has built up
        innovation: measured less expected torque
        innovation_variance: variance expected by the filter; set wide for errors that last over many samples
        nis: normalised innovation squared; far below 1 for that reason
    """

    friction_torque: Annotated[Scalar, "N*m"]
    friction_deviation: Annotated[Scalar, "N*m"]
    misfit: Annotated[Scalar, ""]
    residual: Annotated[Scalar, "N*m"]
    enabled: Annotated[Scalar, ""]
    hands_on: Annotated[Scalar, ""]
    same_direction: Annotated[Scalar, ""]
    moving: Annotated[Scalar, ""]
    rolling: Annotated[Scalar, ""]
    settled: Annotated[Scalar, ""]
    dahl_angle: Annotated[Scalar, "rad"]
    aligning_gain: Annotated[Scalar, ""]
    trail_drop: Annotated[Scalar, "1/(N*m)"]
    weight_lever: Annotated[Scalar, "m"]
    turn_slip: Annotated[Scalar, "m**2"]
    drive_share: Annotated[Scalar, ""]
    load_share: Annotated[Scalar, ""]
    reference_load: Annotated[Scalar, "N*m"]
    offset: Annotated[Scalar, "N*m"]
    damping: Annotated[Scalar, "N*m*s/rad"]
    inertia: Annotated[Scalar, "kg*m**2"]
    build_up: Annotated[Scalar, ""]
    excitation: Annotated[Scalar, ""]
    innovation: Annotated[Scalar, "N*m"]
    innovation_variance: Annotated[Scalar, "N**2*m**2"]
    nis: Annotated[Scalar, ""]


@dataclass(frozen=True)
class PreslidingFrictionFilter:
    """Estimate the dry friction of the steering without the bias of pre-sliding.

    The torque balance of eq (2) with friction that builds up over an angle, in place of Tf sgn(theta'):

        Td + n Tm = sum_j F_j h_j + c (|road| - reference) h + road + offset + B w + J w'
        road = (k + d |rho Mz|) rho Mz + rho (lever W sin(delta) + s W phi - share trail X sin(delta))

    where each h_j follows the column by Dahl's law with exponent 1/2, 1, 2; their common Dahl angle is learnt. The
    column angle is that below the torsion bar: the steering wheel angle less Td over the bar's stiffness. Beside the
    self-aligning torque, the road torque contains the effects of the weight W of the front axle, of the turn slip phi
    of the tyres, and of the drive and brake force X of the steered wheels.

    Both sides pass the same low-pass after the law: filtering the angle before it would blunt the reversals. The filter
    makes one scalar update per sample while the gate is open; otherwise nothing is learnt or forgotten.

    Args:
        parameters: parameters of the vehicle; their `sample_time` is that of the samples
        tuning: noises and priors
        conditioning: conditioning of the signals
        gate: eq (14) for both ends of the torsion bar, with an upper limit on the rate that no driver reaches (the law
            is valid at any rate, and the printed limit biases by -0.2 to -0.7 N*m, simulated), and a lower limit on
            speed because of tyre scrub
        regressor_cutoff: cutoff frequency of the low-pass on both sides [Hz]; 5 passes steering and removes noise

    Validity: both torques calibrated together; a common factor scales everything learnt and is not observable.
    The driver's torque is that in the bar, so that inertia and damping exclude the steering wheel.
    Source: docs/explanation/friction.md; developed from the "single-law estimator" there, with the low-pass after the
    law, three laws in place of one, friction that depends on load, a trail that drops, no play, bounded influence of
    outliers, elastic bar, weight, turn slip, and drive force of steered wheels. Each contribution is measured there.
    """

    parameters: FrictionParameters
    tuning: PreslidingTuning = field(default_factory=PreslidingTuning)
    conditioning: SteeringConditioning = field(default_factory=SteeringConditioning)
    gate: FrictionGate = field(default_factory=lambda: _gate(FrictionGate().minimum_driver_torque))
    regressor_cutoff: Annotated[float, "Hz"] = 5.0
    low_pass: Butterworth = field(init=False, repr=False)

    Sample = SteeringSample
    learnt: ClassVar[Mapping[str, str]] = {
        "dahl_angle_rad": "dahl_angle",
        "aligning_gain": "aligning_gain",
        "torque_offset_Nm": "offset",
        "damping_Nms_per_rad": "damping",
        "inertia_kgm2": "inertia",
        "load_share": "load_share",
        "reference_load_Nm": "reference_load",
    }
    """Evidence of the estimator: name with unit -> field of the estimate."""

    class State(NamedTuple):
        """State of conditioning, build-up and low-pass, and the learnt coefficients."""

        conditioning: Any
        finite: BuildUp
        exponential: BuildUp
        long: BuildUp
        low_pass: Any
        mean: Coefficients
        covariance: tuple[Scalar, ...]
        innovation_power: Scalar
        excitation: Scalar

    def __post_init__(self) -> None:
        sample_time = self.conditioning.sample_time
        if self.parameters.sample_time != sample_time:
            raise ParameterError(
                f"the vehicle's parameters are for samples every {self.parameters.sample_time} s, the conditioning for "
                f"every {sample_time} s; give both the same sample_time"
            )
        low_pass = Butterworth(Regressors, sample_time, 0.0, self.regressor_cutoff)
        object.__setattr__(self, "low_pass", low_pass)

    @classmethod
    def of_vehicle(cls, vehicle: Vehicle, sample_time: float = SAMPLE_TIME) -> PreslidingFrictionFilter:
        """The filter for a vehicle, with every tuning as measured in docs/explanation/friction.md.

        Args:
            vehicle: parameters of the vehicle
            sample_time: time between two samples [s]

        Raises:
            ParameterError: the vehicle file lacks a parameter; the message names it
        """
        parameters = replace(vehicle.parameters_for(FrictionParameters), sample_time=sample_time)
        if not vehicle.calibrated:
            parameters = replace(parameters, torsion_bar_stiffness=math.inf)
        driver_torque = FrictionGate().minimum_driver_torque if vehicle.calibrated else COUNTS_OF_HANDS_ON
        return cls(parameters, conditioning=SteeringConditioning(sample_time), gate=_gate(driver_torque))

    def init(self) -> State:
        """State before the first sample: the priors."""
        tuning = self.tuning
        mean = Coefficients(
            finite=0.0,
            exponential=tuning.initial_friction,
            long=0.0,
            log_dahl_angle=log(tuning.initial_dahl_angle),
            aligning_gain=1.0,
            trail_drop=0.0,
            weight_lever=tuning.initial_weight_lever,
            turn_slip=tuning.initial_turn_slip,
            drive_share=tuning.initial_drive_share,
            load_share=0.0,
            offset=0.0,
            damping=self.parameters.below_bar.damping,
            inertia=self.parameters.below_bar.inertia,
        )
        variances = from_diagonal([deviation * deviation for deviation in tuning.deviations])
        return self.State(
            self.conditioning.init(), RELAXED, RELAXED, RELAXED, self.low_pass.init(), mean, variances, 0.0, 0.0
        )

    def step(self, state: State, sample: SteeringSample) -> tuple[State, FrictionTorque]:
        """Process one sample."""
        conditioning, clean = self.conditioning.step(state.conditioning, sample)
        column = column_motion(clean, self.parameters.torsion_bar_stiffness, self.conditioning.sample_time)
        angle = exp(state.mean.log_dahl_angle)
        laws = build_ups((state.finite, state.exponential, state.long), column.increment, angle)
        load = reference_load(self.parameters, self.tuning.reference_lever)
        both_sides = regressors(clean, column, laws, state.mean, self.parameters, load)
        low_pass, passed = self.low_pass.step(state.low_pass, both_sides)
        # Friction has a direction only where the bar moves at both ends, so the gate takes the slower one.
        slower = minimum(absolute(passed.rate), absolute(passed.steering_wheel_rate))
        conditions = self.gate.conditions(
            passed.driver_torque, passed.motor_torque, slower, clean.signals.vehicle_speed
        )
        enabled = all_of(*conditions, clean.settled, clean.present)
        row = row_of(state.mean, passed)
        innovation = passed.torque - expected_torque(state.mean, row)
        spread = dot(row, product(unpack(state.covariance), row))
        mean, covariance = self._update(state, row, innovation, enabled)
        noise = self.tuning.error_density / self.conditioning.sample_time
        share = self.conditioning.sample_time / self.tuning.excitation_memory
        power = _followed(state.innovation_power, innovation * innovation, share, enabled)
        excitation = _followed(state.excitation, absolute(passed.exponential), share, enabled)
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
            weight_lever=mean.weight_lever,
            turn_slip=mean.turn_slip,
            drive_share=mean.drive_share,
            load_share=mean.load_share,
            reference_load=load,
            offset=mean.offset,
            damping=mean.damping,
            inertia=mean.inertia,
            build_up=passed.exponential,
            excitation=excitation,
            innovation=innovation,
            innovation_variance=spread + noise,
            nis=innovation * innovation / (spread + noise),
        )

    @property
    def vehicle_parameters(self) -> FrictionParameters:
        """Parameters of the vehicle file, as the estimator assumes them."""
        return self.parameters

    def seen(self, sample: SteeringSample, estimate: FrictionTorque) -> VerdictSample:
        """Input of the verdict from a sample and its estimate."""
        return VerdictSample(*(getattr(estimate, name) for name in VerdictSample._fields))

    def _update(
        self, state: State, row: Coefficients, innovation: Scalar, enabled: Any
    ) -> tuple[Coefficients, tuple[Scalar, ...]]:
        """One scalar update where enabled; elsewhere neither mean nor covariance changes."""
        tuning, sample_time = self.tuning, self.conditioning.sample_time
        # Huber weight as a noise that grows with the innovation; an infinite innovation is a missing measurement.
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

    def _misfit(self, innovation_power: Scalar) -> Scalar:
        """Factor on the standard deviation where the balance fits worse than the tuning expects."""
        expected = self.tuning.error_density / self.tuning.error_time
        return sqrt(maximum(1.0, innovation_power / expected))


def _gate(minimum_driver_torque: float) -> FrictionGate:
    """Eq (14) with the limits of this estimator on rate and speed."""
    return FrictionGate(minimum_driver_torque, maximum_rate=FASTEST_STEERING, minimum_speed=ROLLING_SPEED)


def _deviation(covariance: tuple[Scalar, ...]) -> Scalar:
    """Standard deviation of the friction torque, the sum of its three shares."""
    full = unpack(covariance)
    return sqrt(maximum(sum(full[i][j] for i in range(3) for j in range(3)), 0.0))


def _followed(average: Scalar, value: Scalar, share: Scalar, enabled: Scalar) -> Scalar:
    """Low-pass over the enabled samples; held elsewhere."""
    return where(enabled, average + share * (value - average), average)
