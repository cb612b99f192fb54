"""Noise of sensor readings that exceeds the noise of usual sensors."""

from __future__ import annotations

import numpy as np

from tierod.core.recording import Recording
from tierod.core.shown import in_words
from tierod.core.signals import SIGNALS
from tierod.io.quality import LIMITS, median_rate, too_slow
from tierod.methods.analysis.noise import DEVIATION_OF_MEDIAN, differences, fresh
from tierod.methods.running import Sizes

# Noise of the sensors of usual cars, resolution included [unit of the signal]: no less than that of the virtual cars;
# real logs have 0.005 rad/s and 0.05 m/s. Accelerations vibrate with the car: their noise is none of the sensor.
USUAL = {
    "steering_wheel_angle": 0.002,
    "steering_wheel_rate": 0.05,
    "driver_torque": 0.05,
    "motor_torque": 0.01,
    "yaw_rate": 0.005,
    "vehicle_speed": 0.1,
}

LOUD = 5.0  # Multiple of the usual noise that is named [-]; worn sensors of virtual cars have 2
LEAST_READINGS = 500  # Least number of readings; the noise is then known to 5 %
STEP_SHARE = 0.01  # of the changes that may be smaller than a step of a sensor with coarse readings [-]


class Noise:
    """Noise of the readings of one signal over the pieces of a recording.

    Third differences contain the noise and hardly the motion. Their sizes are counted, so that the median, which no
    jump moves, does not depend on the cuts. Held samples count once.
    """

    def __init__(self) -> None:
        self._thirds, self._firsts = Sizes(), Sizes()
        self._last = np.empty(0)
        self._fresh = self._seen = 0

    def add(self, values: np.ndarray) -> None:
        """Add the next readings, (n,); NaN where missing."""
        values = values[np.abs(values) < 1e300]  # the third differences of larger ones are no numbers
        readings = np.concatenate([self._last, values])
        readings = readings[fresh(readings)]
        self._seen += len(values)
        self._fresh += len(readings) - len(self._last)
        self._thirds.add(differences(readings))
        self._firsts.add(np.diff(readings)[2:])
        self._last = readings[-3:]

    def deviation(self, rate: float) -> float:
        """Standard deviation of a reading [its unit]; 0 where motion, held samples or coarse steps may explain it.

        Args:
            rate: sampling rate [Hz]
        """
        if self._thirds.counts.sum() < LEAST_READINGS or too_slow(rate * self._fresh / self._seen, LIMITS.slow):
            return 0.0
        found = DEVIATION_OF_MEDIAN * self._thirds.quantile(0.5)
        return found if found > self._firsts.quantile(STEP_SHARE) else 0.0

    def warning(self, name: str, rate: float) -> str:
        """Sentence on a noise that is far above that of usual sensors; "" for none.

        Args:
            rate: sampling rate [Hz]
        """
        usual, unit = USUAL[name], SIGNALS[name].unit
        found = self.deviation(rate)
        if found <= LOUD * usual:
            return ""
        return (
            f"{scatter(name, found)}, those of usual sensors by {in_words(usual, unit)}: check the sensor and its line"
        )


def scatter(name: str, deviation: float) -> str:
    """Noise of a signal in words.

    Args:
        deviation: standard deviation of a reading [unit of the signal]
    """
    return f"the readings of {name} scatter by {in_words(deviation, SIGNALS[name].unit)}"


def noise_warnings(recording: Recording) -> tuple[str, ...]:
    """Sentences on the noisy signals of a whole recording."""
    found = []
    for name in USUAL:
        if name in recording and recording[name].unit == SIGNALS[name].unit:
            noise = Noise()
            noise.add(recording[name].values)
            found.append(noise.warning(name, median_rate(recording[name].time)))
    return tuple(filter(None, found))
