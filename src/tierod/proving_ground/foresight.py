"""Where on its path a car will be until the next look at the course."""

from __future__ import annotations

from typing import Any

import numpy as np


class Foresight:
    """Distance and speed foreseen from look to look, without a jump where a look corrects them.

    A driver reads the curvature of the path there: a jump of a few centimetres would be one of the steering's target.

    Args:
        distance: along the path at the beginning [m]
        speed: at the beginning [m/s]
    """

    def __init__(self, distance: float, speed: float):
        self._distance, self._speed, self._acceleration = distance, speed, 0.0
        self._foreseen = distance, speed

    def look(self, distance: float, speed: float, after: float) -> None:
        """Where the car really is now.

        Args:
            distance: along the path [m]
            speed: [m/s]
            after: time since the last look [s]
        """
        self._acceleration = (speed - self._speed) / after
        self._distance, self._speed = distance, speed

    def over(self, time: np.ndarray, until: float) -> tuple[np.ndarray, np.ndarray]:
        """Distance [m] and speed [m/s] at instants after the last look; what was foreseen wrongly fades until the next.

        Args:
            time: since the last look [s], (n,)
            until: time of the next look [s]
        """
        wrong = [seen - now for seen, now in zip(self._foreseen, (self._distance, self._speed), strict=True)]
        left = 1.0 - time / until
        self._foreseen = self._at(until)
        distance, speed = self._at(time)
        return distance + wrong[0] * left, speed + wrong[1] * left

    def _at(self, time: Any) -> tuple[Any, Any]:
        distance = self._distance + (self._speed + 0.5 * self._acceleration * time) * time
        return distance, self._speed + self._acceleration * time
