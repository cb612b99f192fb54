"""The truth of a drive that a diagnosis is held against: what fails when, by how much, and whether it would show."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tierod.core.recording import Recording
from tierod.papers.condition.drives import Drive
from tierod.papers.condition.faults import GAIN, LOSS, OUTLIER, STUCK, TARGETS, TORQUES, Injected
from tierod.papers.condition.recorded import deviations, sound
from tierod.papers.condition.shown import KNOWN, where_shown


def truths(drive: Drive, time: np.ndarray) -> dict[str, np.ndarray]:
    """Whether each element is at fault at each sample, for those that ever are."""
    found: dict[str, np.ndarray] = {}
    for each in drive.injected:
        during = (time >= each.start - 1e-9) & (time < each.end - 1e-9)
        found[each.element] = found.get(each.element, np.zeros(len(time), bool)) | during
    return found


class Truth(NamedTuple):
    """What a diagnosis of a drive is held against, on the samples of its recording.

    Args:
        off: by element that fails, how far it is from what it would be without fault, see `recorded.deviations`
        sound: by sensor that fails, what it would read without fault
        asked: by actuator that fails, the torque asked of it [N*m]
        known: how exactly everything else tells each true value, see `where_shown`
    """

    off: Mapping[str, np.ndarray]
    sound: Mapping[str, np.ndarray]
    asked: Mapping[str, np.ndarray]
    known: Mapping[str, float] = KNOWN

    def shows(self, element: str, there: np.ndarray) -> np.ndarray:
        """Whether the fault of an element shows at each sample.

        Args:
            element: sensor or actuator
            there: whether the fault is
        """
        return where_shown(element, self.off[element], there, known=self.known)

    def would_show(self, each: Injected, time: np.ndarray) -> np.ndarray:
        """Whether a fault would show at each sample, were it there all the time."""
        return where_shown(each.element, self._would_be_off(each, time), np.ones(len(time), bool), known=self.known)

    def _would_be_off(self, each: Injected, time: np.ndarray) -> np.ndarray:
        if each.element in TORQUES:
            return each.size * self.asked[each.element]
        sound = self.sound[each.element]
        if each.kind == LOSS:
            return sound
        if each.kind == STUCK:
            return sound - sound[min(int(np.searchsorted(time, each.start)), len(sound) - 1)]
        if each.kind in (GAIN, OUTLIER):
            return (each.size - 1.0) * sound
        return np.full(len(time), math.inf)


def truth_of(drive: Drive, recording: Recording) -> Truth:
    """The truth of a drive of the demonstrator."""
    sensors = drive.driven.sensors
    failing = {each.element for each in drive.injected}
    return Truth(
        deviations(drive, recording),
        {name: sound(name, recording, sensors) for name in failing.difference(TORQUES)},
        {name: recording[TARGETS[name]].values for name in failing.intersection(TORQUES)},
    )
