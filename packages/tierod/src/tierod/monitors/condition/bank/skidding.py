"""Cars at the limit of grip: deviation of their motion from that with gripping tyres, and steering wheel rate."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, both, either, maximum, minimum, present, where
from tierod.models.rolling_car import LEAST_SPEED, RollingCar
from tierod.physics.lag import share_reached
from tierod.physics.single_track import understeer_gradient

SLIPPERIEST = 2.0
"""Lateral acceleration that every road permits [m/s**2], even packed snow; a motion that needs less does not slide."""

GUESSED_SHARE = 0.25
"""Error of the needed lateral acceleration by guessed steering ratio and understeer, as a share of it [-]."""
ACROSS_SHARE, YAW_SHARE = 0.5, 0.3
"""Shares of the rear axle's deviation that count [-]; the rest may come from banked roads, and from the turn-in of slow
cars."""
LAG, FOLLOWS = 0.1, 12.0
"""Lag of a car behind its steering wheel [s], and speed up to which it applies [m/s]; at higher speed, a slide that
changes sides passes through small accelerations for longer."""
QUICK = 2.5
"""Steering wheel rate from which a car lags behind its steering wheel [rad/s]."""
FASTEST = 25.0
"""Steering wheel rate that no driver reaches [rad/s]; a reading that jumps faster is wrong."""
SMOOTHING = 0.05
"""Time constant of the low-pass filter of that rate [s]."""


FORGOTTEN = 5.0
"""Time constant with which a jump of the reading is forgotten [s]; a persistent fault is declared by then."""


class Hands(NamedTuple):
    """Steering angle and rate as the driver's hands produce them, without jumps of the reading.

    Args:
        angle: last reading; infinite before the first
        rate: low-pass filtered rate
        jumped: sum of recent jumps of the reading, faster than a driver can steer
        waited: time since the last reading
    """

    angle: Annotated[Scalar, "rad"]
    rate: Annotated[Scalar, "rad/s"]
    jumped: Annotated[Scalar, "rad"]
    waited: Annotated[Scalar, "s"]

    def after(self, reading: Scalar, sample_time: float) -> Hands:
        """State after one sample; a missing reading leaves angle and rate as they are.

        Args:
            reading: reading of the angle [rad]; NaN if missing
            sample_time: sampling interval [s]
        """
        # Before the first reading the angle is infinite, so that the change is not finite and no jump.
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
    """Lateral acceleration by which the motion deviates from that with gripping tyres [m/s**2]; 0 if none slides.

    The front axle slides if the car turns less than it is steered, or in the opposite direction. The rear axle slides
    if the lateral acceleration is not that of the turn, or if the yaw rate changes fast. A car that steadily turns more
    than it is steered has a wrong steering angle instead, and so has one whose angle has jumped.

    Args:
        state: state of a filter of sliding tyres after a sample
        p: parameters of the car
        hands: steering wheel angle and rate
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
    # Sliding tyres still give what every road permits; with less the car lags its steering, or the angle is wrong.
    late = minimum(front, absolute(per_angle * hands.rate) * LAG)
    front = where(either(absolute(has) > 0.5 * SLIPPERIEST, speed > FOLLOWS), front, late)
    yaw = wheelbase * absolute(state.yaw_acceleration)
    rear = maximum(ACROSS_SHARE * absolute(state.bank_acceleration), YAW_SHARE * yaw)
    quick = absolute(hands.rate) > QUICK
    return where(either(needs > SLIPPERIEST, quick), maximum(front, rear), 0.0)
