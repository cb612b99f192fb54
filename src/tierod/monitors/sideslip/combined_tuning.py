"""What the combined sideslip estimator assumes: which unknowns it follows, how far and how fast they wander, noises."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Annotated

from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.models.lateral_parameters import OF_STEERING, UNKNOWNS
from tierod.physics.lag import gauss_markov_noise


@dataclass(frozen=True)
class Wandering:
    """An unknown that wanders about its usual value: first-order Gauss-Markov.

    Args:
        deviation: standard deviation in the long run, which is also the prior, in the unit of the unknown
        time: correlation time, in which it returns to its usual value where nothing is seen of it
        usual: value about which it wanders, in the unit of the unknown
    """

    deviation: Annotated[float, "", POSITIVE]
    time: Annotated[float, "s", POSITIVE]
    usual: Annotated[float, ""] = 0.0

    def fading(self, sample_time: float) -> float:
        """Share that is left after a sample."""
        return math.exp(-sample_time / self.time)

    def noise(self, sample_time: float) -> float:
        """Variance that it gains in a sample, which keeps the long-run deviation."""
        return float(gauss_markov_noise(self.deviation, self.time, sample_time))


@dataclass(frozen=True)
class Noises:
    """Noise of the equations (after one second) and of the sensors (of one reading).

    Args:
        lateral_speed, yaw_rate: of the forces that the model lacks. Small, since inflated noise biases the stiffness
        roll_rate: of the body's roll
        road_wheel_rate: of the torques at the road wheels that the model lacks
        free_road_wheel_rate: where the torque of the actuator is not known
        yaw_rate_reading, lateral_acceleration_reading, road_wheel_angle_reading: standard deviations
        held_lateral_speed, held_yaw_rate, held_road_wheel_angle: growth while nothing can be estimated
    """

    lateral_speed: Annotated[float, "m/s**1.5", NOT_NEGATIVE] = 0.02
    yaw_rate: Annotated[float, "rad/s**1.5", NOT_NEGATIVE] = 0.005
    roll_rate: Annotated[float, "rad/s**1.5", NOT_NEGATIVE] = 0.002
    road_wheel_rate: Annotated[float, "rad/s**1.5", NOT_NEGATIVE] = 1.4
    free_road_wheel_rate: Annotated[float, "rad/s**1.5", NOT_NEGATIVE] = 2.0
    yaw_rate_reading: Annotated[float, "rad/s", POSITIVE] = 0.003
    lateral_acceleration_reading: Annotated[float, "m/s**2", POSITIVE] = 0.15
    road_wheel_angle_reading: Annotated[float, "rad", POSITIVE] = 3e-4
    held_lateral_speed: Annotated[float, "m/s**1.5", NOT_NEGATIVE] = 0.3
    held_yaw_rate: Annotated[float, "rad/s**1.5", NOT_NEGATIVE] = 0.1
    held_road_wheel_angle: Annotated[float, "rad/s**0.5", NOT_NEGATIVE] = 0.1


@dataclass(frozen=True)
class CombinedTuning:
    """What the estimator follows beside the motion (None: not at all), and its noises.

    Args:
        log_front_stiffness, log_rear_stiffness: a fifth wrong at first, and changing over an hour
        log_friction: of both axles. Returns to the usual value: as a random walk it runs away where tyres are not used,
            and with a return within 30 s, which takes eight times the noise, gentle bends on a dry road look like ice
        bank_angle: of the road
        side_force, side_moment: of wind, at the centre of gravity and about it
        lateral_acceleration_bias, yaw_rate_bias, road_wheel_angle_offset: of the sensors
        log_steering_friction, log_trail: of the steering, where its torque is known
        roll: whether the body rolls with a motion of its own
        noises: of equations and sensors
        slowest: speed below which the last estimate is held
        limit_share: of the greatest front force, from which the peak is announced
        limit_certainty: standard deviations by which the share has to be above it
        most_misfit: mean squared innovation over its variance, per reading, from which the filter starts anew; a right
            model has 1, one as wrong as real cars' 2
    """

    log_front_stiffness: Wandering | None = field(default_factory=lambda: Wandering(0.2, 3600.0))
    log_rear_stiffness: Wandering | None = field(default_factory=lambda: Wandering(0.2, 3600.0))
    log_friction: Wandering | None = field(default_factory=lambda: Wandering(0.6, 240.0))
    bank_angle: Wandering | None = field(default_factory=lambda: Wandering(0.03, 10.0))
    side_force: Wandering | None = field(default_factory=lambda: Wandering(100.0, 60.0))
    side_moment: Wandering | None = field(default_factory=lambda: Wandering(50.0, 60.0))
    lateral_acceleration_bias: Wandering | None = None
    yaw_rate_bias: Wandering | None = None
    road_wheel_angle_offset: Wandering | None = None
    log_steering_friction: Wandering | None = field(default_factory=lambda: Wandering(0.4, 3600.0))
    log_trail: Wandering | None = field(default_factory=lambda: Wandering(0.25, 3600.0))
    roll: bool = True
    noises: Noises = field(default_factory=Noises)
    slowest: Annotated[float, "m/s", POSITIVE] = 0.5
    limit_share: Annotated[float, "", POSITIVE] = 0.7
    limit_certainty: Annotated[float, "", POSITIVE] = 1.0
    most_misfit: Annotated[float, "", POSITIVE] = 4.0

    def followed(self, steering: bool) -> dict[str, Wandering]:
        """The unknowns that are states, in the order of `UNKNOWNS`; those of the steering only where it is a state."""
        given = {each.name: getattr(self, each.name) for each in fields(self)}
        wanted = {name: given[name] for name in UNKNOWNS if steering or name not in OF_STEERING}
        return {name: each for name, each in wanted.items() if each is not None}


def per_sample(growth: float, sample_time: float) -> float:
    """Variance per sample of a growth after one second."""
    return growth * growth * sample_time
