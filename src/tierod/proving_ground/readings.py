"""What a run leaves in a recording: measured channels, and the truth beside them."""

from __future__ import annotations

import zlib
from collections.abc import Collection, Mapping

import numpy as np

from tierod.core.recording import Channel
from tierod.proving_ground.faults import Schedule
from tierod.proving_ground.recorder import TRUTH_RATE, channel
from tierod.proving_ground.sensors import Sensor

_STREAM = 2
"""The stream of chance of sensors."""


def generator(seed: int, stream: int, part: int = 0) -> np.random.Generator:
    """A source of chance of its own for every purpose, so that one does not move the other."""
    return np.random.default_rng([seed, stream, part])


class Readings:
    """The sensors of a run: when each takes the truth, what stamps it writes, and what it makes of the truth.

    Args:
        sensors: by channel
        seconds: duration of the run [s]
        seed: of the run; every sensor draws from a stream of its own

    Attributes:
        instants: by channel, when the truth is taken [s]
    """

    def __init__(self, sensors: Mapping[str, Sensor], seconds: float, seed: int):
        self.sensors = sensors
        self._chance = {name: generator(seed, _STREAM, zlib.crc32(name.encode())) for name in sensors}
        both = {name: sensor.instants(seconds, self._chance[name]) for name, sensor in sensors.items()}
        self.instants = {name: taken for name, (taken, _) in both.items()}
        self._stamps = {name: stamps for name, (_, stamps) in both.items()}

    def channels(
        self, truths: Mapping[str, np.ndarray], schedule: Schedule, described: Mapping[str, str]
    ) -> dict[str, Channel]:
        """The measured channels, with the faults of recorded signals.

        Args:
            truths: what every sensor saw at its instants
            schedule: of the faults
            described: units that the plant says
        """
        result = {}
        for name, sensor in self.sensors.items():
            values = sensor.read(truths[name], self._chance[name])
            stamps, values = schedule.on_channel(name, self._stamps[name][: len(values)], values)
            result[name] = channel(name, stamps, values, described)
        return result


def true_channels(
    truths: Mapping[str, np.ndarray], measured: Collection[str], described: Mapping[str, str]
) -> dict[str, Channel]:
    """The truth of every channel, from zero on at its own rate.

    Args:
        truths: by channel, those of the measured ones left aside
        measured: names of the measured channels
        described: units that the plant says
    """
    grids: dict[int, np.ndarray] = {}
    return {
        name: channel(name, grids.setdefault(len(v), np.arange(len(v)) / TRUTH_RATE), v, described)
        for name, v in truths.items()
        if name not in measured
    }
