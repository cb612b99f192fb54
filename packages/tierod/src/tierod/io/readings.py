"""Readings of a sensor: their noise, and the rows that a file repeats each in, where rows are faster than readings."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from tierod.core.recording import Recording
from tierod.core.shown import in_words
from tierod.core.signals import SIGNALS
from tierod.methods.analysis.consistency import DEVIATION_OF_MEDIAN, differences
from tierod.methods.running import Sizes

LEAST_RATE = 20.0  # of readings that steering monitors can use [Hz]: movements reach 3 Hz, six samples each


def median_rate(time: np.ndarray) -> float:
    """Sampling rate from the median interval between different stamps [Hz]; NaN with fewer than two."""
    steps = np.diff(time)
    steps = steps[steps > 0.0]
    return float(1.0 / np.median(steps)) if len(steps) else float("nan")


def too_slow(rate: float, needed: float) -> bool:
    """Whether a rate [Hz] is below the one needed [Hz] by more than 5 %, which allows for jitter and clock drift."""
    return rate < 0.95 * needed


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


# Numbers of changes of a signal from which held readings are looked for, and after which further ones are not kept
FEWEST, MOST = 30, 2000
LEAST_ROWS = 4  # least rows per reading: below it an interpolated or resampled signal looks the same
REGULAR = 0.95  # least share of the changes whole periods apart, to one row: a signal that rests changes at any time
# Least share of changes larger than one and a half steps: a signal with coarse steps that moves slowly and evenly
# changes regularly too, but by one step each
LARGE = 0.5


class Readings:
    """Readings of one signal over the pieces of a recording: rows that repeat the one before are no new reading.

    Third differences of the readings contain their noise and hardly the motion. Their sizes are counted, so that the
    median, which no jump moves, does not depend on the cuts.
    """

    def __init__(self) -> None:
        self._thirds, self._firsts = Sizes(), Sizes()
        self._last = np.empty(0)
        self._fresh = self._seen = 0
        self._rows: list[int] = []  # between changes
        self._sizes: list[float] = []  # of the changes
        self._since: int | None = None  # rows since the last change

    def add(self, values: np.ndarray) -> None:
        """Add the next rows, (n,); NaN where missing."""
        values = values[np.abs(values) < 1e300]  # the third differences of larger ones are no numbers
        steps = np.abs(np.diff(values, prepend=self._last[-1] if len(self._last) else np.nan))
        at = np.flatnonzero(steps != 0.0)
        readings = np.concatenate([self._last, values[at]])
        self._seen, self._fresh = self._seen + len(values), self._fresh + len(at)
        self._thirds.add(differences(readings))
        self._firsts.add(np.diff(readings)[2:])
        self._last = readings[-3:]
        if len(self._rows) < MOST:
            at = at[steps[at] > 0.0]
            # The time before the first change is no whole period.
            starts = at if self._since is None else np.concatenate([[-self._since], at])
            self._rows += np.diff(starts).tolist()
            self._sizes += steps[at if self._since is not None else at[1:]].tolist()
            if len(starts):
                self._since = len(values) - int(starts[-1])

    def deviation(self, rate: Annotated[float, "Hz"]) -> float:
        """Standard deviation of a reading [its unit]; 0 where motion, held samples or coarse steps may explain it."""
        if self._thirds.counts.sum() < LEAST_READINGS or too_slow(rate * self._fresh / self._seen, LEAST_RATE):
            return 0.0
        found = DEVIATION_OF_MEDIAN * self._thirds.quantile(0.5)
        return found if found > self._firsts.quantile(STEP_SHARE) else 0.0

    def noise(self, name: str, unit: str, rate: Annotated[float, "Hz"]) -> str:
        """Sentence on a noise that is far above that of usual sensors; "" for none."""
        if name not in USUAL or unit != SIGNALS[name].unit:
            return ""
        found, usual = self.deviation(rate), USUAL[name]
        if found <= LOUD * usual:
            return ""
        return (
            f"{scatter(name, found)}, those of usual sensors by {in_words(usual, unit)}: check the sensor and its line"
        )

    def rows(self) -> float:
        """Rows that repeat one reading; 1 where readings are not held."""
        if len(self._rows) < FEWEST:
            return 1.0
        apart, sizes = np.array(self._rows, float), np.array(self._sizes)
        period = float(np.quantile(apart, 0.1))
        if period < LEAST_ROWS:
            return 1.0
        period = float(np.mean(apart[apart < 1.5 * period]))
        times = np.maximum(np.round(apart / period), 1.0)
        regular = np.abs(apart - times * period) <= np.maximum(1.0, 0.02 * apart)
        if np.mean(regular) < REGULAR or np.mean(sizes > 1.5 * sizes.min()) < LARGE:
            return 1.0
        return period


def readings_of(values: np.ndarray) -> Readings:
    """Readings of a whole signal, (n,)."""
    found = Readings()
    found.add(values)
    return found


def scatter(name: str, deviation: float) -> str:
    """Noise of a signal in words, from the standard deviation of a reading [unit of the signal]."""
    return f"the readings of {name} scatter by {in_words(deviation, SIGNALS[name].unit)}"


def noise_warnings(recording: Recording) -> tuple[str, ...]:
    """Sentences on the noisy signals of a whole recording."""
    there = [recording[name] for name in USUAL if name in recording]
    noises = (readings_of(each.values).noise(each.name, each.unit, median_rate(each.time)) for each in there)
    return tuple(filter(None, noises))


def held_remark(rate: float, rows: float) -> str:
    """Remark on held readings, from the rate of the rows [Hz]."""
    return f"readings come at {rate / rows:.3g} Hz only: each is repeated in {rows:.0f} rows"
