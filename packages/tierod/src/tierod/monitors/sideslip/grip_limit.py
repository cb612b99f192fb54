"""Evidence beside the slip of its tyres that the front axle nears its largest force."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, TypeVar

import numpy as np

from tierod.core.block import Scalar
from tierod.core.fields import POSITIVE
from tierod.core.graph.maths import absolute, all_of, limit, maximum

BAND = 1.96
"""Standard deviations that contain 95 % of a Gaussian error."""

Share = TypeVar("Share", Scalar, np.ndarray)


@dataclass(frozen=True)
class GripLimit:
    """Least speed, turn and force of a car whose front axle nears its largest force.

    Slip alone shows no limit. Over a rolling speed near zero it says nothing of the force, and in a tight turn it is
    the small difference of two large angles. Beside a wrong steering angle, whatever its fault, it is wrong as well.

    Args:
        slowest: speed from which the slip of a tyre says something of its force; at 3 m/s it builds up within 0.1 s
        acceleration: least lateral acceleration by speed and yaw rate; polished ice has a friction of 0.1
        force: share of its largest force that the axle uses at the lower end of the 95 % band; with less an
            announcement counts as false
        agreeing: largest factor of the yaw rate's noise by which its innovations are explained; with more the steering
            angle predicts another yaw rate than the measured one. Virtual cars that slide reach 150, also where they
            are known by class only; an angle held at 10 Hz, or wrong by a third or by 15 degrees, makes more than 1000
        tight: road-wheel angle from which that share must show in the lateral acceleration, on a road as in the vehicle
            file; steering ratio and Ackermann's difference are wrong by some % of the angle, a degree and more there
    """

    slowest: Annotated[float, "m/s", POSITIVE] = 3.0
    acceleration: Annotated[float, "m/s**2", POSITIVE] = 1.0
    force: Annotated[float, "", POSITIVE] = 0.6
    agreeing: Annotated[float, "", POSITIVE] = 200.0
    tight: Annotated[float, "rad", POSITIVE] = 0.35

    def shown(
        self, estimate: Mapping[str, Scalar], speed: Scalar, road_wheel_angle: Scalar, usual: Scalar, yaw_noise: Scalar
    ) -> Scalar:
        """Whether force and turn of the car are near the limit, and the steering angle fits the yaw rate.

        Args:
            estimate: fields of the combined estimator's output
            speed: vehicle speed [m/s]
            road_wheel_angle: steering angle [rad]
            usual: lateral acceleration at the limit on a dry road [m/s**2]
            yaw_noise: factor by which the noise of the yaw rate is raised [-]
        """
        across = absolute(speed * estimate["corrected_yaw_rate"])
        tight = limit(absolute(road_wheel_angle) / self.tight, 0.0, 1.0)
        needed = self.acceleration + tight * maximum(self.force * usual - self.acceleration, 0.0)
        forced = self.forced(estimate["front_friction_used"], estimate["front_friction_used_deviation"])
        shown: Scalar = all_of(speed > self.slowest, across > needed, forced, yaw_noise < self.agreeing)
        return shown

    def forced(self, used: Share, deviation: Share) -> Share:
        """Whether the axle uses enough of its largest force; never where the deviation is NaN.

        Args:
            used: share of the largest force that is in use [-]
            deviation: its standard deviation [-]
        """
        return used - BAND * deviation > self.force
