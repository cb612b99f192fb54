"""The refined friction monitor: an enabled Kalman filter of motion, self-aligning torque and friction."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, NamedTuple

from tierod.block import leaves
from tierod.errors import ParameterError
from tierod.estimators.gaussian import GaussianFilter
from tierod.estimators.kalman import KalmanFilter
from tierod.filters.butterworth import Butterworth
from tierod.filters.each import EachSignal
from tierod.graph.maths import absolute, all_of, present, sign, sqrt, where
from tierod.models.friction_estimation import FrictionEstimation, FrictionParameters
from tierod.monitors.friction.gate import FrictionGate

OperatingPoint = Literal["measurement", "estimate"]
VirtualNoise = Literal["scaled by sample time", "per sample"]
CovarianceUpdate = Literal["printed", "schmidt"]


@dataclass(frozen=True)
class Sticking:
    """What the filter does while the steering stands: friction leaves the balance, the torque balance is distrusted.

    Without it the frozen friction acts on a standing wheel and its error goes into the self-aligning torque.

    Args:
        rate: below this the steering counts as standing [rad/s]; the lower limit of the gate
        torque_deviation: standard deviation of the static friction that takes the place of the dynamic one [N m]; the
            healthy friction of the paper's car

    Source: errata of Mohtat et al., remedy after Table 3.
    """

    rate: float = 0.05
    torque_deviation: float = 4.0


class FrictionSample(NamedTuple):
    """Signals of one sample; NaN where one is missing."""

    steering_wheel_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    driver_torque: Annotated[float, "N*m"]
    motor_torque: Annotated[float, "N*m"]
    yaw_rate: Annotated[float, "rad/s"]
    lateral_acceleration: Annotated[float, "m/s**2"]


class FrictionSampleWithSpeed(NamedTuple):
    """Signals of one sample with the speed that the gate looks at."""

    steering_wheel_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    driver_torque: Annotated[float, "N*m"]
    motor_torque: Annotated[float, "N*m"]
    yaw_rate: Annotated[float, "rad/s"]
    lateral_acceleration: Annotated[float, "m/s**2"]
    vehicle_speed: Annotated[float, "m/s"]


class Innovation(NamedTuple):
    """Measured less expected, NaN where not measured."""

    steering_wheel_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    yaw_rate: Annotated[float, "rad/s"]


class InnovationVariance(NamedTuple):
    """Variance that the filter expects of each innovation."""

    steering_wheel_angle: Annotated[float, "rad**2"]
    steering_wheel_rate: Annotated[float, "rad**2/s**2"]
    yaw_rate: Annotated[float, "rad**2/s**2"]


class FrictionEstimate(NamedTuple):
    """What the refined monitor knows after a sample.

    Args:
        friction_torque: at the steering wheel axis
        friction_deviation: standard deviation the filter gives itself; the true error is 5 to 20 times larger in the
            printed tuning, since Q holds nothing for errors of the friction model (errata)
        enabled: 1 where the sample corrected the friction torque
        self_aligning_torque: about the kingpins
        innovation, innovation_variance: of the three measurements
        nis: normalised innovation squared over the measurements that were present
        present: how many measurements were present
    """

    friction_torque: Annotated[float, "N*m"]
    friction_deviation: Annotated[float, "N*m"]
    enabled: Annotated[float, ""]
    self_aligning_torque: Annotated[float, "N*m"]
    innovation: Innovation
    innovation_variance: InnovationVariance
    nis: Annotated[float, ""]
    present: Annotated[float, ""]


@dataclass(frozen=True)
class RefinedFrictionMonitor:
    """Estimate steering friction jointly with the self-aligning torque, and only while it can be seen.

    A sample is predicted with the inputs of the sample before, as in Table 3. A missing input is held; a sample with
    any signal missing does not change the friction torque.

    Args:
        filter: of the joint model (`FrictionEstimation`, or the smooth one with an unscented filter), with
            `friction_torque` maskable
        gate: when the friction torque is corrected
        operating_point: where sgn of the rate is taken, appendix B: the latest "measurement" (printed choice: the
            smaller error) or the a posteriori "estimate" (the tighter distribution)
        sticking: treatment of the standing wheel; None as printed
        low_pass: one filter for all signals alike, the gate's included, so that none is delayed against another; None
            as printed. Needed where the rate's noise comes near the lower limit of the gate (`equal_low_pass`)

    Validity: vehicle_speed above 3 m/s, dry friction. With pre-sliding (Dahl) friction the estimate is 4 to 25 %
    low for Dahl angles of 0.3 to 3 degrees, whatever the tuning.
    Source: Mohtat et al., eqs (5) to (14) and Table 3; the presets below say what each corrects.
    """

    filter: GaussianFilter
    gate: FrictionGate = field(default_factory=FrictionGate)
    operating_point: OperatingPoint = "measurement"
    sticking: Sticking | None = None
    low_pass: EachSignal | None = None

    class State(NamedTuple):
        """Belief of the filter, inputs and rate of the sample before, and memory of the low-pass."""

        belief: Any
        driver_torque: Any
        motor_torque: Any
        lateral_acceleration: Any
        rate: Any
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
    def Sample(self) -> type:
        """Six signals, and the speed where the gate looks at it."""
        return FrictionSample if self.gate.minimum_speed is None else FrictionSampleWithSpeed

    def init(self) -> State:
        """At rest, with the filter's initial belief."""
        return self.State(self.filter.init(), 0.0, 0.0, 0.0, 0.0, self.low_pass.init() if self.low_pass else ())

    def step(self, state: State, sample: Any) -> tuple[State, FrictionEstimate]:
        """One sample on (Table 3)."""
        memory, sample = self._filtered(state.low_pass, sample)
        enabled = all_of(
            self.gate.opened(
                sample.driver_torque,
                sample.motor_torque,
                sample.steering_wheel_rate,
                getattr(sample, "vehicle_speed", None),
            ),
            *(present(value) for _, value in leaves(sample)),
        )
        rate = state.rate if self.operating_point == "measurement" else state.belief.mean.steering_wheel_rate
        direction, noise = self._operate(rate)
        belief, estimate = self.filter.step(
            state.belief,
            self.filter.Sample(
                FrictionEstimation.Input(
                    state.driver_torque, state.motor_torque, state.lateral_acceleration, direction
                ),
                FrictionEstimation.Output(sample.steering_wheel_angle, sample.steering_wheel_rate, sample.yaw_rate),
                (enabled,),
            ),
            input_noise=noise,
        )
        after = self.State(
            belief,
            _held(sample.driver_torque, state.driver_torque),
            _held(sample.motor_torque, state.motor_torque),
            _held(sample.lateral_acceleration, state.lateral_acceleration),
            _held(sample.steering_wheel_rate, state.rate),
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

    def _filtered(self, memory: Any, sample: Any) -> tuple[Any, Any]:
        """The signals after the low-pass; what is missing stays missing."""
        if self.low_pass is None:
            return memory, sample
        memory, smooth = self.low_pass.step(memory, sample)
        return memory, type(sample)(*(where(present(a), b, a) for a, b in zip(sample, smooth, strict=True)))

    def _operate(self, rate: Any) -> tuple[Any, Any]:
        """Direction of friction and the noise of the inputs at the operating point."""
        if self.sticking is None:
            return sign(rate), None
        stands = absolute(rate) < self.sticking.rate
        driver, *others = self.filter.input_noise
        extra = self.sticking.torque_deviation * self.sticking.torque_deviation
        return where(stands, 0.0, sign(rate)), (where(stands, driver + extra, driver), *others)


def _held(value: Any, before: Any) -> Any:
    return where(present(value), value, before)


def equal_low_pass(cutoff: float, sample_time: float = 0.01) -> Butterworth:
    """The low-pass that the monitors of six signals take where the rate is noisy.

    Args:
        cutoff: 5 Hz restores the estimate at a rate noise of 0.05 rad/s (errata) [Hz]
        sample_time: dt [s]
    """
    return Butterworth(FrictionSample, sample_time, maximum_gap=0.1, cutoff=cutoff)


def joint_filter(
    parameters: FrictionParameters,
    *,
    input_variance: tuple[float, float, float],
    virtual_variance: tuple[float, float],
    virtual_noise: VirtualNoise,
    covariance_update: CovarianceUpdate,
    initial_friction_variance: float,
    initial_friction: float = 3.0,
    measurement_variance: float = 1e-4,
    estimator: type[GaussianFilter] = KalmanFilter,
    model: Any = FrictionEstimation,
) -> GaussianFilter:
    """The filter of the joint model with Q and R named as in eqs (11) and (12).

    Args:
        parameters: of the joint model
        input_variance: Q of driver torque [(N m)^2], motor torque [(N m)^2], lateral acceleration [(m/s^2)^2]
        virtual_variance: Q of self-aligning torque and friction torque [(N m)^2]
        virtual_noise: reading of the last two rows of G: "scaled by sample time" (printed, eq 8: dt) or "per sample"
            (1 in place of dt)
        covariance_update: "printed" (Table 3) or "schmidt" (consistent with the enabled gain)
        initial_friction_variance: P_T [(N m)^2], not printed; it decides how fast the estimate leaves its start.
            With the printed covariance it is forgotten before the gate first opens, whatever it was
        initial_friction: [N m]; 3 as printed
        measurement_variance: of angle [rad^2], rate and yaw rate [rad^2/s^2]; 1e-4 as printed
        estimator: kind of filter
        model: the joint model, linear in its direction or smooth

    The rest of P0 is not printed either: 1e-2 for the motions, 100 (N m)^2 for the self-aligning torque [assumed].
    """
    if virtual_noise not in ("scaled by sample time", "per sample"):
        raise ParameterError(
            f"virtual_noise is '{virtual_noise}'; "
            "expected 'scaled by sample time' (dt in G, as printed) or 'per sample' (1)"
        )
    scale = parameters.sample_time**2 if virtual_noise == "scaled by sample time" else 1.0
    return estimator(
        model=model,
        parameters=parameters,
        initial_mean=(0.0, 0.0, 0.0, 0.0, initial_friction),
        initial_variance=(1e-2, 1e-2, 1e-2, 100.0, initial_friction_variance),
        process_noise=(None, None, None, scale * virtual_variance[0], scale * virtual_variance[1]),
        measurement_noise=(measurement_variance,) * 3,
        input_noise=(*input_variance, None),
        maskable=("friction_torque",),
        covariance_update=covariance_update,
        hold_missing_input=False,
    )


def printed(
    parameters: FrictionParameters,
    *,
    initial_friction_variance: float = 1.0,
    operating_point: OperatingPoint = "measurement",
    virtual_noise: VirtualNoise = "scaled by sample time",
) -> RefinedFrictionMonitor:
    """The monitor as printed: literal Q of eq (11), dt in the virtual rows of G, covariance update of Table 3.

    The self-aligning torque is hardly tracked with it (41 N m root mean square) and friction reads 0.4 to 0.9 N m high.

    Args:
        parameters: of the joint model
        initial_friction_variance: P_T [(N m)^2]; from 3 N m, 12.5 N m reads about 11 N m after the printed 50 s of
            enabled time with 1, and 8.6 N m with the steady value of 6e-4
        operating_point: appendix B
        virtual_noise: reading of G; "per sample" tracks the self-aligning torque at the price of more scatter
    """
    return RefinedFrictionMonitor(
        joint_filter(
            parameters,
            input_variance=(0.01, 0.01, 0.1),
            virtual_variance=(1.0, 0.001),
            virtual_noise=virtual_noise,
            covariance_update="printed",
            initial_friction_variance=initial_friction_variance,
        ),
        operating_point=operating_point,
    )


def printed_open(
    parameters: FrictionParameters,
    *,
    initial_friction_variance: float = 1.0,
    operating_point: OperatingPoint = "measurement",
) -> RefinedFrictionMonitor:
    """The printed monitor with a self-aligning torque that is free to move: Q of it 1e4 (errata, variant B).

    Args:
        parameters: of the joint model
        initial_friction_variance: P_T [(N m)^2], as in `printed`
        operating_point: appendix B
    """
    return RefinedFrictionMonitor(
        joint_filter(
            parameters,
            input_variance=(0.01, 0.01, 0.1),
            virtual_variance=(1e4, 0.001),
            virtual_noise="scaled by sample time",
            covariance_update="printed",
            initial_friction_variance=initial_friction_variance,
        ),
        operating_point=operating_point,
    )


def consistent(
    parameters: FrictionParameters,
    *,
    initial_friction_variance: float = 25.0,
    operating_point: OperatingPoint = "measurement",
) -> RefinedFrictionMonitor:
    """The corrected monitor: Schmidt-Joseph covariance, Q = diag(1, 1, 0.1, 1e4, 0.1), sticking (errata, variant C).

    Q of the torques is 1 (N m)^2 instead of 0.01, which covers the error of the model; the self-aligning torque is
    then known to 6.5 N m and the variance of friction means something.

    Args:
        parameters: of the joint model
        initial_friction_variance: P_T [(N m)^2]; (5 N m)^2 covers every level of the paper, and the estimate is there
            after 10 s of enabled time
        operating_point: appendix B
    """
    return RefinedFrictionMonitor(
        joint_filter(
            parameters,
            input_variance=(1.0, 1.0, 0.1),
            virtual_variance=(1e4, 0.1),
            virtual_noise="scaled by sample time",
            covariance_update="schmidt",
            initial_friction_variance=initial_friction_variance,
        ),
        operating_point=operating_point,
        sticking=Sticking(),
    )
