"""Cars at the limit of grip: how far their motion is from that of tyres that hold, and how fast hands turn."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, both, either, maximum, minimum, present, where
from tierod.models.rolling_car import LEAST_SPEED, RollingCar
from tierod.physics.lag import share_reached
from tierod.physics.single_track import understeer_gradient

SLIPPERIEST = 2.0
"""Acceleration across the vehicle that every road gives [m/s**2]: packed snow; what needs less does not slide."""

GUESSED_SHARE = 0.25
"""Of what is needed: a guessed ratio and understeer are wrong by so much."""
ACROSS_SHARE, YAW_SHARE = 0.5, 0.3
"""Of what the rear axle shows: banked roads, and the turn-in of slow cars."""
LAG, FOLLOWS = 0.1, 12.0
"""Time by which a car follows its steering wheel later [s], and speed up to which it is so short [m/s]: above, a slide
that changes sides passes through little acceleration for longer."""
QUICK = 2.5
"""Rate of the steering wheel [rad/s] from which a car has not followed it yet."""
FASTEST = 25.0
"""Rate that no hands reach [rad/s]: a reading that jumps so is wrong."""
SMOOTHING = 0.05
"""Time over which that rate is smoothed [s]."""


FORGOTTEN = 5.0
"""Time after which a jump of the reading is forgotten [s]: a sensor that went on so would be declared by then."""


class Hands(NamedTuple):
    """Last reading of the steering angle, and its rate, smoothed.

    Args:
        angle: last that was there; infinite before the first
        rate: over `SMOOTHING`
        jumped: by how much readings have jumped, faster than hands turn
        waited: since the last reading
    """

    angle: Annotated[Scalar, "rad"]
    rate: Annotated[Scalar, "rad/s"]
    jumped: Annotated[Scalar, "rad"]
    waited: Annotated[Scalar, "s"]

    def after(self, reading: Scalar, sample_time: float) -> Hands:
        """One sample on; a missing reading changes nothing.

        Args:
            reading: of the angle [rad]; NaN where missing
            sample_time: [s]
        """
        change = reading - self.angle
        waited = self.waited + sample_time
        rate = where(present(change), change / waited, self.rate)
        smooth = self.rate + share_reached(sample_time / SMOOTHING) * (rate - self.rate)
        jumps = both(present(change), absolute(rate) > FASTEST)
        kept = self.jumped * (1.0 - share_reached(sample_time / FORGOTTEN))
        return Hands(
            where(present(reading), reading, self.angle),
            where(jumps, 0.0, smooth),
            kept + where(jumps, change, 0.0),
            where(present(reading), 0.0, waited),
        )


def lacking(state: RollingCar.State, p: RollingCar.Parameters, hands: Hands) -> Scalar:
    """Acceleration across the vehicle by which the motion is off that of tyres that hold [m/s**2]; 0 where none slide.

    The front axle slides where the car turns less than it is steered, or against it. The rear axle slides where the
    acceleration is not that of the turn, and where the car begins to turn or ceases to fast enough; a car that turns
    more than it is steered, and steadily so, has a wrong steering angle; so has one whose angle has jumped.

    Args:
        state: of a filter of sliding tyres, after a sample
        p: the car
        hands: their action on the wheel
    """
    wheelbase = p.front_distance + p.rear_distance
    gradient = understeer_gradient(
        p.mass, p.front_distance, p.rear_distance, p.front_cornering_stiffness, p.rear_cornering_stiffness
    )
    speed = maximum(state.speed, LEAST_SPEED)
    per_angle = p.steering_ratio * speed * speed / (wheelbase + maximum(gradient, 0.0) * speed * speed)
    has = speed * state.yaw_rate
    more = per_angle * (state.steering_error - hands.jumped)
    asked = has + more
    needs = maximum(absolute(asked), absolute(has))
    front = where(asked * more > 0.0, absolute(more) - GUESSED_SHARE * needs, 0.0)
    # Sliding tyres give what every road gives; with less the car has not followed yet, or the angle is wrong.
    late = minimum(front, absolute(per_angle * hands.rate) * LAG)
    front = where(either(absolute(has) > 0.5 * SLIPPERIEST, speed > FOLLOWS), front, late)
    yaw = wheelbase * absolute(state.yaw_acceleration)
    rear = maximum(ACROSS_SHARE * absolute(state.bank_acceleration), YAW_SHARE * yaw)
    quick = absolute(hands.rate) > QUICK
    return where(either(needs > SLIPPERIEST, quick), maximum(front, rear), 0.0)
