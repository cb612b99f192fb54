"""Rack, tie rods and steering arms: from the pinion to the road wheels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.physics.ackermann import ackermann_angle, ackermann_slope
from tierod.physics.steering_ratio import road_wheel_angle, torque_at_steering_wheel, variable_ratio
from tierod.proving_ground.parts import Steer
from tierod.ranges import ANY, NOT_NEGATIVE, POSITIVE


class Ratios(NamedTuple):
    """Turn of the road wheels per turn of the pinion.

    Args:
        mean: of both wheels [-]
        left, right: of each wheel [-]
    """

    mean: Any
    left: Any
    right: Any

    def torque(self, kingpin_left: Any, kingpin_right: Any) -> Any:
        """Torque at the pinion [N*m] of torques about the kingpins, by virtual work."""
        return torque_at_steering_wheel(kingpin_left, self.left) + torque_at_steering_wheel(kingpin_right, self.right)


@dataclass(frozen=True)
class Linkage:
    """Kinematics of rack, tie rods and arms; typical of a mid-size car.

    Args:
        ratio: mean turn of the road wheels per turn of the pinion, straight ahead
        ratio_growth: relative growth of the ratio with the squared angle of the pinion
        ackermann_gain: see `tierod.physics.ackermann`; the default is about 60 % of full Ackermann
        rack_ratio: travel of the rack per turn of the pinion; the default is 55 mm per revolution
    """

    ratio: Annotated[float, "", POSITIVE] = 1.0 / 15.5
    ratio_growth: Annotated[float, "1/rad**2", ANY] = 0.0
    ackermann_gain: Annotated[float, "1/rad", NOT_NEGATIVE] = 0.16
    rack_ratio: Annotated[float, "m/rad", POSITIVE] = 8.75e-3

    def ratios(self, pinion_angle: Any) -> Ratios:
        """Turn of the road wheels per turn of the pinion at an angle of it [rad]."""
        mean = variable_ratio(pinion_angle, self.ratio, self.ratio_growth)
        angle = road_wheel_angle(pinion_angle, self.ratio, self.ratio_growth)
        gain = self.ackermann_gain
        return Ratios(mean, mean * ackermann_slope(angle, gain), mean * ackermann_slope(angle, -gain))

    def steer(self, pinion_angle: Any, pinion_rate: Any) -> Steer:
        """Of the road wheels at an angle [rad] and rate [rad/s] of the pinion."""
        ratios = self.ratios(pinion_angle)
        angle = road_wheel_angle(pinion_angle, self.ratio, self.ratio_growth)
        return Steer(
            ackermann_angle(angle, self.ackermann_gain),
            ackermann_angle(angle, -self.ackermann_gain),
            ratios.left * pinion_rate,
            ratios.right * pinion_rate,
        )
