"""Kalman filter with Dahl's law for the friction at the motor of a steering column: its torque and its level."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Annotated, NamedTuple, get_type_hints

from tierod.core.block import Model, Scalar, Tree, model_like, named_tuple
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import sqrt, where
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.linear_algebra import congruence
from tierod.methods.estimators.shapes import Belief
from tierod.models.column_observation import MotorTorque
from tierod.models.linear import Matrices
from tierod.models.steering_column import ColumnParameters, TwoInertiaParameters, without_gear
from tierod.monitors.driver_torque.design import ColumnTuning, column_of_vehicle, design, process_noises, usual_tuning
from tierod.monitors.driver_torque.observer import ColumnSample, Phase, Starting, StartState, resting_state
from tierod.physics.friction import dahl_update
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class FrictionObservationParameters:
    """A sampled column and the law of its friction."""

    linear: Matrices  # matrices of the sampled column with its torques as states
    dahl_angle: Annotated[float, "rad"]  # angle of the motor over which friction builds up, level over stiffness [rad]
    sample_time: Annotated[float, "s"]  # sampling interval [s]


@lru_cache(maxsize=64)
def with_dahl_friction(observed: Model) -> Model:
    """Model of an observed column whose disturbance torque is Dahl friction at the motor plus a remainder.

    Args:
        observed: discrete model with the states `motor_angle` and `disturbance_torque`, from `observed_column`

    Returns:
        a discrete model with two more states, `normalised_friction` (torque over level) and `friction_level`; its
        `disturbance_torque` is the remainder that the friction does not explain

    Source: Raffone, eq (4), for the exponent 1, with the level as a state; the update over a sample is exact, and the
        friction at half the sample acts during it.
    """
    hints = get_type_hints(observed.State, include_extras=True)
    fields = [(name, hints[name]) for name in observed.State._fields]
    fields += [("normalised_friction", Annotated[float, ""]), ("friction_level", Annotated[float, "N*m"])]
    state = named_tuple("FrictionObservationState", fields)

    def transition(x: Tree, u: MotorTorque, p: FrictionObservationParameters) -> Tree:
        # The friction at half the sample, predicted from the speed, acts over the whole sample; the state then follows
        # the exact travel.
        halfway = dahl_update(x.normalised_friction, 0.5 * p.sample_time * x.motor_speed, p.dahl_angle)
        friction = halfway * x.friction_level
        column = observed.State(*x[:-2])
        moved = observed.transition(column._replace(disturbance_torque=x.disturbance_torque + friction), u, p.linear)
        travel = moved.motor_angle - x.motor_angle
        built_up = dahl_update(x.normalised_friction, travel, p.dahl_angle)
        return state(*moved._replace(disturbance_torque=x.disturbance_torque), built_up, x.friction_level)

    def output(x: Tree, u: MotorTorque, p: FrictionObservationParameters) -> Tree:
        return observed.output(observed.State(*x[:-2]), u, p.linear)

    return model_like(
        observed,
        "FrictionObservation",
        "Observed column with Dahl's friction at the motor.",
        State=state,
        Parameters=FrictionObservationParameters,
        transition=transition,
        output=output,
    )


@dataclass(frozen=True)
class FrictionTuning:
    """Process noise of the friction; a random walk is given per square root of a second.

    Tuned on the same simulated runs as `ColumnTuning`.
    """

    level: Annotated[float, "N*m"] = 0.1  # initial level; that of the vehicle where there is one [N m]
    level_deviation: Annotated[float, ""] = 0.5  # standard deviation of the initial level, relative
    level_walk: Annotated[float, "N*m/s**0.5"] = 1e-4  # random walk of the level; 1e-4 N·m gives 0.006 N·m in an hour
    # random walk of friction over level, for errors of the law; 1 tolerates a Dahl angle wrong by a factor of two
    normalised_walk: Annotated[float, "1/s**0.5"] = 1.0
    remaining_walk: Annotated[float, "N*m/s**0.5"] = 0.01  # random walk of the disturbance torque besides friction
    # random walk of the hand torque, for smooth and for stepwise hands
    hand_torque_walk: Annotated[float, "N*m/s**0.5"] = 1.0


class FrictionEstimate(NamedTuple):
    """Estimate of the friction at the motor shaft."""

    disturbance_torque: Annotated[float, "N*m"]  # friction plus the remainder
    disturbance_torque_deviation: Annotated[float, "N*m"]  # its standard deviation
    friction_torque: Annotated[float, "N*m"]  # friction by Dahl's law; positive values oppose motion to the left
    friction_level: Annotated[float, "N*m"]  # level of friction while sliding
    friction_level_deviation: Annotated[float, "N*m"]  # its standard deviation
    hand_torque: Annotated[float, "N*m"]  # torque of the driver's hands, by one filter for smooth and stepwise hands
    nis: Annotated[float, ""]  # normalised innovation squared
    present: Annotated[float, ""]  # number of available outputs
    ready: Annotated[float, ""]  # 1 while the estimate is valid


class FrictionMemory(NamedTuple):
    """State of the filter, and of the treatment of gaps."""

    belief: Belief
    start: StartState


@dataclass(frozen=True)
class ColumnFrictionObserver:
    """Observer of the friction at the motor with an estimated level, for a bench or a car whose rack is free.

    Where the friction follows Dahl's law with the given angle, the disturbance torque is ten times as exact as with a
    random walk, and still twice as exact where the angle is wrong by a factor of two. The gear of the column is
    neglected, and one filter covers smooth and stepwise hands: `ColumnObserver` estimates their torque better.

    Args:
        filter: extended Kalman filter of the column, both torques, friction and level
        starting: start of the filter and treatment of gaps

    Source: Raffone, eq (4), as an observer's state; the level is not the paper's.
    """

    filter: KalmanFilter
    starting: Starting

    Sample = ColumnSample

    @classmethod
    def of_vehicle(cls, vehicle: Vehicle, sample_time: float = 1e-3) -> ColumnFrictionObserver:
        """Observer of a vehicle that gives `motor_friction` and `motor_friction_stiffness`.

        Args:
            vehicle: vehicle, with or without gear
            sample_time: sampling interval [s]

        Raises:
            ParameterError: parameters are missing, or as in `require_fit`
        """
        level = vehicle["motor_friction"]
        angle = level / vehicle["motor_friction_stiffness"]
        friction = FrictionTuning(level=level)
        return cls.of_parameters(column_of_vehicle(vehicle), angle, sample_time, usual_tuning(vehicle), friction)

    @classmethod
    def of_parameters(
        cls,
        parameters: ColumnParameters | TwoInertiaParameters,
        dahl_angle: float,
        sample_time: float = 1e-3,
        tuning: ColumnTuning | None = None,
        friction: FrictionTuning | None = None,
    ) -> ColumnFrictionObserver:
        """Observer of a column.

        Args:
            parameters: `ColumnParameters` or `TwoInertiaParameters`
            dahl_angle: angle of the motor over which friction builds up, level over stiffness [rad]
            sample_time: sampling interval [s]
            tuning: noise of column and sensors; that of a bench where None
            friction: process noise of the friction; the defaults where None

        Raises:
            ParameterError: as in `require_fit`, or an angle that is not positive
        """
        if not dahl_angle > 0.0:
            raise ParameterError(f"dahl_angle is {dahl_angle}; expected an angle of the motor above zero [rad]")
        own = friction or FrictionTuning()
        smooth = replace(
            tuning or ColumnTuning(),
            hand_torque_walk=own.hand_torque_walk,
            reversal_walk=0.0,
            disturbance_torque_walk=own.remaining_walk,
        )
        column = without_gear(parameters) if isinstance(parameters, ColumnParameters) else parameters
        made = design(column, sample_time, smooth, hand_torque_order=1)
        model = with_dahl_friction(made.observation.model)
        (noise,) = process_noises(made.observation.discrete.states, column, sample_time, smooth)
        more = (own.normalised_walk**2 * sample_time, own.level_walk**2 * sample_time)
        filter_ = KalmanFilter(
            model,
            FrictionObservationParameters(made.observation.parameters, float(dahl_angle), float(sample_time)),
            (0.0,) * len(noise) + (0.0, own.level),
            _initial_variance(model, made.layout.motor_ratio, own),
            tuple(float(value) if value > 0.0 else None for value in (*noise, *more)),
            smooth.variances(),
            hold_missing_input=False,
        )
        return cls(filter_, Starting(made.layout))

    def init(self) -> FrictionMemory:
        return FrictionMemory(self.filter.init(), self.starting.init())

    def step(self, state: FrictionMemory, sample: ColumnSample) -> tuple[FrictionMemory, FrictionEstimate]:
        start, phase = self.starting.step(state.start, sample)
        model = self.filter.model
        given = self.filter.Sample(MotorTorque(phase.motor_torque), model.Output(*phase.measured))
        moved, estimate = self.filter.step(state.belief, given)
        # A restart after a gap begins at rest, but keeps the level of friction that was found before.
        fresh = self.filter.init()
        level = state.belief.mean.friction_level
        resting = resting_state(model, self.starting.layout, sample)._replace(
            disturbance_torque=0.0, friction_level=level
        )
        belief = phase.chosen(fresh._replace(mean=resting), moved, state.belief)
        return FrictionMemory(belief, start), self._estimate(start, belief, estimate, phase)

    def _estimate(self, start: StartState, belief: Belief, estimate: Tree, phase: Phase) -> FrictionEstimate:
        mean = belief.mean
        friction = mean.normalised_friction * mean.friction_level
        spread, level_spread = self._spreads(belief)
        unknown = start.unknown
        return FrictionEstimate(
            mean.disturbance_torque + friction,
            sqrt(spread + unknown + self.starting.layout.disturbance_torque_growth * start.missing),
            friction,
            mean.friction_level,
            sqrt(level_spread + unknown),
            mean.hand_torque,
            where(phase.following, estimate.nis, 0.0),
            where(phase.following, estimate.present, 0.0),
            phase.ready,
        )

    def _spreads(self, belief: Belief) -> tuple[Scalar, Scalar]:
        mean = belief.mean
        total = {
            "disturbance_torque": 1.0,
            "normalised_friction": mean.friction_level,
            "friction_level": mean.normalised_friction,
        }
        rows = (total, {"friction_level": 1.0})
        matrix = [[row.get(name, 0.0) for name in type(mean)._fields] for row in rows]
        both_spread, _, level_spread = congruence(matrix, belief.covariance)
        return both_spread, level_spread


def _initial_variance(model: Model, ratio: float, friction: FrictionTuning) -> tuple[float, ...]:
    known = {
        "steering_wheel_angle": 0.01,
        "motor_angle": 0.01 * ratio**2,
        "motor_speed": ratio**2,
        "hand_torque": 4.0,
        "disturbance_torque": 1e-4,
        "motor_angle_offset": 1e-4 * ratio**2,
        "driver_torque_offset": 0.01,
        "normalised_friction": 1.0,
        "friction_level": (friction.level_deviation * friction.level) ** 2,
    }
    return tuple(known.get(name, 1.0) for name in model.State._fields)
