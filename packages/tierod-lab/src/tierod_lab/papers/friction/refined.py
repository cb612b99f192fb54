"""The refined friction monitor: an enabled Kalman filter of motion, self-aligning torque and friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from tierod.core.block import Scalar, skeleton, values_of
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import absolute, all_of, both, present, select, sign, sqrt, tanh, where
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.shapes import Belief
from tierod.models.steering_column import FrictionParameters
from tierod.monitors.friction.signals import FrictionGate
from tierod.monitors.friction.verdict import VerdictSample
from tierod.physics.steering import column_torque_of_motor, torque_at_steering_wheel
from tierod_lab.ground.laws import variable_ratio
from tierod_lab.papers.friction.joint_model import FrictionEstimation, SmoothFrictionParameters, state_after

OperatingPoint = Literal["measurement", "estimate"]


class FrictionSample(NamedTuple):
    """Six signals of one sample, as printed, without the vehicle speed; NaN where one is missing."""

    steering_wheel_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    driver_torque: Annotated[float, "N*m"]
    motor_torque: Annotated[float, "N*m"]
    yaw_rate: Annotated[float, "rad/s"]
    lateral_acceleration: Annotated[float, "m/s**2"]


class Innovation(NamedTuple):
    steering_wheel_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    yaw_rate: Annotated[float, "rad/s"]


class InnovationVariance(NamedTuple):
    steering_wheel_angle: Annotated[float, "rad**2"]
    steering_wheel_rate: Annotated[float, "rad**2/s**2"]
    yaw_rate: Annotated[float, "rad**2/s**2"]


class FrictionEstimate(NamedTuple):
    """Output of the refined monitor after a sample."""

    friction_torque: Annotated[float, "N*m"]  # at the steering wheel axis
    friction_deviation: Annotated[float, "N*m"]  # the true error is 5 to 20 times larger in the printed tuning
    enabled: Annotated[float, ""]  # 1 where the sample corrected the friction torque
    self_aligning_torque: Annotated[float, "N*m"]  # about the kingpins
    innovation: Innovation
    innovation_variance: InnovationVariance
    nis: Annotated[float, ""]  # normalised innovation squared over the measurements that were present
    present: Annotated[float, ""]  # number of present measurements


@dataclass(frozen=True)
class Sticking:
    """Treatment of a sticking steering: friction leaves the balance, and the noise of the torque input is raised.

    Without it the last friction estimate acts on a standing wheel, and its error enters the self-aligning torque.
    Source: an addition to Table 3 of Mohtat et al., see docs/explanation/papers/friction.md.
    """

    rate: Annotated[float, "rad/s"] = 0.05  # the steering counts as standing below the lower limit of the gate
    torque_deviation: Annotated[float, "N*m"] = 4.0  # of static friction: the fault-free friction of the paper's car


@dataclass(frozen=True)
class RefinedFrictionMonitor:
    """Estimate steering friction jointly with the self-aligning torque, and only while it is observable.

    A sample is predicted with the inputs of the previous sample, as in Table 3. A missing input is held; a sample with
    any missing signal does not change the friction torque.

    Args:
        operating_point: where sgn of the rate is taken, appendix B: the latest "measurement" (printed choice: the
            smaller error) or the a posteriori "estimate" (the tighter distribution)
        sticking: treatment of the standing wheel; None as printed
        longest_gap: gap beyond which motion and self-aligning torque restart from the measurement and only friction is
            kept [s]. Without it a gap of 10 s in a turn costs 1 to 2 N m, one of 300 s up to 10 N m
        settling_time: time after such a restart in which the gate stays closed [s]

    Validity: vehicle_speed above 3 m/s, dry friction. With pre-sliding (Dahl) friction the estimate is 4 to 25 %
    low for Dahl angles of 0.3 to 3 degrees, whatever the tuning.
    Source: Mohtat et al., eqs (5) to (14) and Table 3; `tierod_lab.papers.friction.presets` states the corrections.
    """

    filter: KalmanFilter
    gate: FrictionGate = field(default_factory=FrictionGate)
    operating_point: OperatingPoint = "measurement"
    sticking: Sticking | None = None
    longest_gap: Annotated[float, "s"] = 0.2
    settling_time: Annotated[float, "s"] = 0.5
    learnt: ClassVar[Mapping[str, str]] = {}

    Sample = FrictionSample

    class State(NamedTuple):
        belief: Belief
        before: Any
        missing_time: Any
        running_time: Any

    def __post_init__(self) -> None:
        if self.filter.maskable != ("friction_torque",):
            masked = self.filter.maskable or "no state"
            raise ParameterError(f"the filter masks {masked}; build it with maskable=('friction_torque',)")

    @property
    def vehicle_parameters(self) -> FrictionParameters:
        """Parameters of the vehicle file, as the estimator assumes them."""
        parameters: FrictionParameters = self.filter.parameters
        return parameters

    def seen(self, sample: Any, estimate: FrictionEstimate) -> VerdictSample:
        """Input of the verdict from a sample and its estimate.

        This estimator models no build-up of friction and learns neither balance nor damping: the verdict gets the
        direction of motion and neutral values instead.
        """
        conditions = self.gate.conditions(sample.driver_torque, sample.motor_torque, sample.steering_wheel_rate)
        return VerdictSample(
            friction_torque=estimate.friction_torque,
            friction_deviation=estimate.friction_deviation,
            misfit=1.0,
            enabled=estimate.enabled,
            hands_on=conditions.hands_on,
            same_direction=conditions.same_direction,
            moving=conditions.moving,
            rolling=conditions.rolling,
            settled=where(all_of(*(present(value) for value in sample)), 1.0, 0.0),
            build_up=where(sample.steering_wheel_rate > 0.0, 1.0, -1.0),
            excitation=1.0,
            residual=0.0,
            damping=0.0,
            aligning_gain=1.0,
        )

    def init(self) -> State:
        # An infinite running time: there is no gap yet to settle from.
        return self.State(self.filter.init(), skeleton(self.Sample), 0.0, inf)

    def step(self, state: State, sample: FrictionSample) -> tuple[State, FrictionEstimate]:
        whole = all_of(*(present(value) for value in values_of(sample)))
        belief, before, running_time = self._restarted(state, sample, whole)
        opened = self.gate.opened(sample.driver_torque, sample.motor_torque, sample.steering_wheel_rate)
        enabled = all_of(opened, whole, running_time >= self.settling_time)
        rate = before.steering_wheel_rate if self.operating_point == "measurement" else belief.mean.steering_wheel_rate
        direction, noise = self._operate(rate)
        belief, estimate = self.filter.step(
            belief,
            self.filter.Sample(
                self.inputs(before, belief, direction),
                FrictionEstimation.Output(sample.steering_wheel_angle, sample.steering_wheel_rate, sample.yaw_rate),
                (enabled,),
            ),
            input_noise=noise,
        )
        after = self.State(
            belief,
            type(sample)(*(where(present(a), a, b) for a, b in zip(sample, before, strict=True))),
            where(whole, 0.0, state.missing_time + self.filter.parameters.sample_time),
            running_time + self.filter.parameters.sample_time,
        )
        return after, FrictionEstimate(
            estimate.mean.friction_torque,
            sqrt(estimate.variance.friction_torque),
            enabled,
            estimate.mean.self_aligning_torque,
            Innovation(*estimate.innovation),
            InnovationVariance(*estimate.innovation_variance),
            estimate.nis,
            estimate.present,
        )

    def inputs(self, before: Any, belief: Belief, direction: Any) -> Any:
        """Inputs of the filter's model: the torques and the acceleration, and the direction of friction."""
        return FrictionEstimation.Input(
            before.driver_torque, before.motor_torque, before.lateral_acceleration, direction
        )

    def _restarted(self, state: State, sample: Any, whole: Any) -> tuple[Belief, Any, Any]:
        """Belief, previous sample and running time; after a long gap those of a restart that keeps friction."""
        anew = both(whole, state.missing_time > self.longest_gap)
        start, known = self.filter.init(), state.belief
        mean = FrictionEstimation.State(
            sample.steering_wheel_angle,
            sample.steering_wheel_rate,
            sample.yaw_rate,
            start.mean.self_aligning_torque,
            known.mean.friction_torque,
        )
        # The last element of the packed covariance is the variance of the friction torque.
        covariance = (*start.covariance[:-1], known.covariance[-1])
        belief = Belief(select(anew, mean, known.mean), select(anew, covariance, known.covariance))
        return belief, select(anew, sample, state.before), where(anew, 0.0, state.running_time)

    def _operate(self, rate: Any) -> tuple[Any, Any]:
        if self.sticking is None:
            return sign(rate), None
        stands = absolute(rate) < self.sticking.rate
        driver, *others = self.filter.input_noise
        extra = self.sticking.torque_deviation * self.sticking.torque_deviation
        return where(stands, 0.0, sign(rate)), (where(stands, driver + extra, driver), *others)


@dataclass(frozen=True)
class VariableRatioParameters(SmoothFrictionParameters):
    """Parameters of the joint model with variable ratio, named as in a vehicle file."""

    # relative growth of the ratio with the squared angle [1/rad^2]; zero is a constant ratio
    steering_ratio_growth: Annotated[float, "1/rad**2"] = 0.0
    with_ratio_slope: Annotated[float, ""] = 1.0  # 1 with the term of rho' in eq (19), 0 without
    with_sign_slope: Annotated[float, ""] = 1.0  # 1 with the term of delta in eq (19), 0 without


class LinearisedFrictionEstimation:
    """The joint model of `FrictionEstimation` with all terms of its linearisation.

    The torques rho(theta) M_z and T_f sgn(theta') are products, whose linearisation has the terms
    rho'(theta*) M_z* (theta - theta*) and 2 delta(theta'*) T_f* (theta' - theta'*). The paper omits both and prints the
    second without the factor 2, although d sgn(x)/dx = 2 delta(x). Delta is that of a sign smoothed by tanh over
    `smoothing_rate`: a damping of T_f / smoothing_rate near standstill, and none at several times that rate.

    Source: Mohtat et al., eq (19).
    """

    State = FrictionEstimation.State
    Output = FrictionEstimation.Output
    Parameters = VariableRatioParameters

    class Input(NamedTuple):
        driver_torque: Annotated[float, "N*m"]
        motor_torque: Annotated[float, "N*m"]
        lateral_acceleration: Annotated[float, "m/s**2"]
        direction: Annotated[float, ""]
        angle_there: Annotated[float, "rad"]
        rate_there: Annotated[float, "rad/s"]
        aligning_there: Annotated[float, "N*m"]
        friction_there: Annotated[float, "N*m"]

    @staticmethod
    def transition(x: FrictionEstimation.State, u: Input, p: VariableRatioParameters) -> FrictionEstimation.State:
        ratio = variable_ratio(u.angle_there, p.steering_ratio, p.steering_ratio_growth)
        slope = 2.0 * p.steering_ratio * p.steering_ratio_growth * u.angle_there
        turned = x.steering_wheel_angle - u.angle_there
        aligning = torque_at_steering_wheel(x.self_aligning_torque, ratio)
        aligning = aligning + p.with_ratio_slope * torque_at_steering_wheel(u.aligning_there, slope * turned)
        net = u.driver_torque + column_torque_of_motor(u.motor_torque, p.motor_ratio) - aligning - _friction(x, u, p)
        return state_after(x, net, u.lateral_acceleration, p)

    @staticmethod
    def output(x: FrictionEstimation.State, u: Input, p: VariableRatioParameters) -> FrictionEstimation.Output:
        return FrictionEstimation.Output(x.steering_wheel_angle, x.steering_wheel_rate, x.yaw_rate)


def smooth_sign_slope(rate: Scalar, width: Scalar) -> Scalar:
    """Derivative [s/rad] of a sign smoothed by tanh, which reaches 76 % at the rate `width`: twice a Dirac delta."""
    level = tanh(rate / width)
    return (1.0 - level * level) / width


def _friction(x: FrictionEstimation.State, u: LinearisedFrictionEstimation.Input, p: VariableRatioParameters) -> Scalar:
    turn = smooth_sign_slope(u.rate_there, p.smoothing_rate) * (x.steering_wheel_rate - u.rate_there)
    return x.friction_torque * u.direction + p.with_sign_slope * u.friction_there * turn


@dataclass(frozen=True)
class LinearisedFrictionMonitor(RefinedFrictionMonitor):
    """The refined monitor on `LinearisedFrictionEstimation`, which takes the operating point as inputs.

    `operating_point` decides whether its angle and rate are measured or estimated; torque and friction are estimates.
    Source: Mohtat et al., appendix B.
    """

    def inputs(self, before: Any, belief: Belief, direction: Any) -> Any:
        there = before if self.operating_point == "measurement" else belief.mean
        return LinearisedFrictionEstimation.Input(
            before.driver_torque,
            before.motor_torque,
            before.lateral_acceleration,
            direction,
            there.steering_wheel_angle,
            there.steering_wheel_rate,
            belief.mean.self_aligning_torque,
            belief.mean.friction_torque,
        )
