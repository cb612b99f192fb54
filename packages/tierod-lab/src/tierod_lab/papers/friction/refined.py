"""The refined friction monitor: an enabled Kalman filter of motion, self-aligning torque and friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from tierod.core.block import skeleton, values_of
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import absolute, all_of, both, present, select, sign, sqrt, where
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.shapes import Belief
from tierod.methods.filters import EachSignal
from tierod.models.steering_column import FrictionParameters
from tierod.monitors.friction.signals import FrictionGate, SteeringSample
from tierod.monitors.friction.verdict import VerdictSample
from tierod_lab.papers.friction.joint_model import FrictionEstimation

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
    """Measured less predicted value, NaN where not measured."""

    steering_wheel_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    yaw_rate: Annotated[float, "rad/s"]


class InnovationVariance(NamedTuple):
    """Variance of each innovation, as predicted by the filter."""

    steering_wheel_angle: Annotated[float, "rad**2"]
    steering_wheel_rate: Annotated[float, "rad**2/s**2"]
    yaw_rate: Annotated[float, "rad**2/s**2"]


class FrictionEstimate(NamedTuple):
    """Output of the refined monitor after a sample."""

    friction_torque: Annotated[float, "N*m"]  # friction torque at the steering wheel axis
    # standard deviation computed by the filter; the true error is 5 to 20 times larger in the printed tuning, since Q
    # contains no errors of the friction model
    friction_deviation: Annotated[float, "N*m"]
    enabled: Annotated[float, ""]  # 1 where the sample corrected the friction torque
    self_aligning_torque: Annotated[float, "N*m"]  # self-aligning torque about the kingpins
    # innovation, innovation_variance: innovations of the three measurements, and their variances
    innovation: Innovation
    innovation_variance: InnovationVariance
    nis: Annotated[float, ""]  # normalised innovation squared over the measurements that were present
    present: Annotated[float, ""]  # number of present measurements


@dataclass(frozen=True)
class Sticking:
    """Treatment of a sticking steering: friction leaves the balance, and the noise of the torque input is raised.

    Without it the last friction estimate acts on a standing wheel, and its error enters the self-aligning torque.

    Args:
        rate: rate below which the steering counts as standing [rad/s]; the lower limit of the gate
        torque_deviation: standard deviation of the static friction that replaces the dynamic one [N m]; the
            fault-free friction of the paper's car

    Source: an addition to Table 3 of Mohtat et al., see docs/explanation/papers/friction.md.
    """

    rate: Annotated[float, "rad/s"] = 0.05
    torque_deviation: Annotated[float, "N*m"] = 4.0


@dataclass(frozen=True)
class RefinedFrictionMonitor:
    """Estimate steering friction jointly with the self-aligning torque, and only while it is observable.

    A sample is predicted with the inputs of the previous sample, as in Table 3. A missing input is held; a sample with
    any missing signal does not change the friction torque.

    Args:
        filter: filter of the joint model (`FrictionEstimation`, or the smooth one if unscented), with
            `friction_torque` maskable
        gate: condition under which the friction torque is corrected
        operating_point: where sgn of the rate is taken, appendix B: the latest "measurement" (printed choice: the
            smaller error) or the a posteriori "estimate" (the tighter distribution)
        sticking: treatment of the standing wheel; None as printed
        low_pass: equal low-pass on all signals, those of the gate included, so that none is delayed against another;
            None as printed. Needed where the noise of the rate nears the lower limit of the gate (`equal_low_pass`)
        longest_gap: gap in the signals beyond which motion and self-aligning torque restart from the measurement and
            only the friction torque is kept [s]; inf never restarts. Without it the held inputs drive the prediction
            away, and a gap of 10 s in a turn costs 1 to 2 N m, one of 300 s up to 10 N m
        settling_time: time after such a restart in which the gate stays closed [s]

    Validity: vehicle_speed above 3 m/s, dry friction. With pre-sliding (Dahl) friction the estimate is 4 to 25 %
    low for Dahl angles of 0.3 to 3 degrees, whatever the tuning.
    Source: Mohtat et al., eqs (5) to (14) and Table 3; `tierod_lab.papers.friction.presets` states the corrections.
    """

    filter: KalmanFilter
    gate: FrictionGate = field(default_factory=FrictionGate)
    operating_point: OperatingPoint = "measurement"
    sticking: Sticking | None = None
    low_pass: EachSignal | None = None
    longest_gap: Annotated[float, "s"] = 0.2
    settling_time: Annotated[float, "s"] = 0.5
    learnt: ClassVar[Mapping[str, str]] = {}

    class State(NamedTuple):
        belief: Belief
        before: Any
        missing_time: Any
        running_time: Any
        low_pass: Any

    def __post_init__(self) -> None:
        if self.filter.maskable != ("friction_torque",):
            raise ParameterError(
                f"the filter masks {self.filter.maskable or 'no state'}; build it with maskable=('friction_torque',)"
            )
        if self.operating_point not in ("measurement", "estimate"):
            raise ParameterError(
                f"operating_point is '{self.operating_point}'; expected 'measurement' or 'estimate' (appendix B)"
            )
        if self.low_pass is not None and self.low_pass.signals is not self.Sample:
            raise ParameterError(
                f"the low-pass filters {self.low_pass.signals.__name__}; build it with signals={self.Sample.__name__}"
            )

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
        speed = getattr(sample, "vehicle_speed", 0.0)
        conditions = self.gate.conditions(sample.driver_torque, sample.motor_torque, sample.steering_wheel_rate, speed)
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

    @property
    def Sample(self) -> type:
        """Type of the input sample: six signals, and the speed where the gate has a minimum speed."""
        return FrictionSample if self.gate.minimum_speed is None else SteeringSample

    def init(self) -> State:
        before = skeleton(self.Sample)
        # An infinite running time: there is no gap yet to settle from.
        return self.State(self.filter.init(), before, 0.0, inf, self.low_pass.init() if self.low_pass else ())

    def step(self, state: State, sample: FrictionSample | SteeringSample) -> tuple[State, FrictionEstimate]:
        memory, sample = self._filtered(state.low_pass, sample)
        whole = all_of(*(present(value) for value in values_of(sample)))
        belief, before, running_time = self._restarted(state, sample, whole)
        enabled = all_of(self._gated(sample), whole, running_time >= self.settling_time)
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
            memory,
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

    def _gated(self, sample: Any) -> Any:
        speed = getattr(sample, "vehicle_speed", 0.0)
        return self.gate.opened(sample.driver_torque, sample.motor_torque, sample.steering_wheel_rate, speed)

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

    def _filtered(self, memory: Any, sample: Any) -> tuple[Any, Any]:
        if self.low_pass is None:
            return memory, sample
        memory, smooth = self.low_pass.step(memory, sample)
        return memory, type(sample)(*(where(present(a), b, a) for a, b in zip(sample, smooth, strict=True)))

    def _operate(self, rate: Any) -> tuple[Any, Any]:
        if self.sticking is None:
            return sign(rate), None
        stands = absolute(rate) < self.sticking.rate
        driver, *others = self.filter.input_noise
        extra = self.sticking.torque_deviation * self.sticking.torque_deviation
        return where(stands, 0.0, sign(rate)), (where(stands, driver + extra, driver), *others)
