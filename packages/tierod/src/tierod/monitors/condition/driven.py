"""Figures of a drive beside the statements about sensors and actuators: judged time, losses, sources of substitutes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from tierod.core.findings import Status
from tierod.core.graph import Result
from tierod.core.series import LastRead, runs
from tierod.diagnosis.switchover import SubstitutionGraph
from tierod.monitors.condition.coverage import ALL, LOST, UNASKED, Absence, Covered, Loss
from tierod.monitors.condition.rolling_filter import SLIPPERIEST
from tierod.monitors.condition.signals import ACTUATORS, ALL_WHEELS, ELEMENTS, SENSORS, TARGETS, ConditionSample

STANDING = 0.5  # speed below which the vehicle counts as standing [m/s]
HARD, AFTER = 2.5, 1.0
"""Longitudinal acceleration from which a wheel with half its load in a bend may spin or skid alone [m/s**2], a quarter
of the most on a dry road, and time in which the filters recover from it [s]."""
NO_READING = "no sensor gives a reading"
ALL_ZERO = "all sensors read exactly zero"
ALL_HELD = "all sensors repeat their previous readings"
SLID = "the tyres slid, or the vehicle cornered harder than in calibration drives"
SLIPPED = "both wheels of an axle spun or skidded, or had done so in the second before"
REVERSED = "the car reversed"
TOO_FEW = f"fewer than {ALL} sensors give a reading"

MAP_FIRST = (
    "name wheel speeds, yaw rate and steering wheel angle in the channel map if the recording has them under other "
    "names ('tierod inspect' shows its columns), else record them"
)

_ALONG = ConditionSample._fields.index("longitudinal_acceleration")
_YAW = ConditionSample._fields.index("yaw_rate")
WHEEL_PLACES = [ConditionSample._fields.index(name) for name in ALL_WHEELS]
"""Column indices of the wheel speeds in a sample."""

ALL_GONE = (ALL_ZERO, ALL_HELD, NO_READING)
_JUDGED, _ENOUGH = "judged", "enough sensors"


@dataclass
class Driven:
    """Figures of a recording, accumulated piece by piece.

    Args:
        period: sampling interval [s]
        end: end of the last sample [s]
        samples: number of samples
        judged, forward, backward: number of samples that were judged, and with motion forward and backward
        unjudged: number of samples that were not judged, by cause
        sources: number of samples for which each source supplied the signal, by sensor
        absences: presence of every element's reading or target, of a possible judgement, and of enough sensors
        now: cause why the last sample was not judged; "" if it was
        asked: whether the judgement needs the targets
        pushed: bounds of the times of hard acceleration and braking, with `AFTER` behind them [s], and their sign
    """

    period: float
    end: float = math.nan
    samples: int = 0
    judged: int = 0
    forward: int = 0
    backward: int = 0
    unjudged: dict[str, int] = field(default_factory=dict)
    sources: dict[str, dict[str, int]] = field(default_factory=dict)
    absences: dict[str, Absence] = field(default_factory=dict)
    now: str = ""
    asked: bool = True
    pushed: list[tuple[float, float, float]] = field(default_factory=list)
    _slides: list[tuple[float, float]] = field(default_factory=list)
    _forward: tuple[np.ndarray, np.ndarray] = (np.zeros(0), np.zeros(0, bool))
    _read: LastRead = field(default_factory=lambda: LastRead(len(ALL_WHEELS), LOST))

    @property
    def seconds(self) -> float:
        return self.samples * self.period

    @property
    def not_judged(self) -> str:
        """Most frequent cause of unjudged samples; "" if all were judged."""
        return max(self.unjudged, key=lambda cause: self.unjudged[cause]) if self.unjudged else ""

    def add(self, time: np.ndarray, values: np.ndarray, covered: Covered) -> None:
        """Add the next piece: time [s], columns of `ConditionSample`, and their coverage."""
        self.end = float(time[-1]) + self.period
        self.samples += len(time)
        self.judged += int(np.count_nonzero(covered.judged))
        speed = self._read.held(time, values[:, WHEEL_PLACES])
        with np.errstate(invalid="ignore"):
            forward = np.asarray((speed > STANDING).any(axis=1))
            self.forward += int(np.count_nonzero(forward))
            self._forward = time, forward
            self.backward += int(np.count_nonzero((speed < -STANDING).any(axis=1)))
            for sign in (1.0, -1.0):
                pushes, ends = (each.tolist() for each in runs(sign * values[:, _ALONG] > HARD))
                self.pushed += [
                    (float(time[k]), float(time[end - 1]) + AFTER, sign) for k, end in zip(pushes, ends, strict=True)
                ]
        reading = covered.available[:, : len(SENSORS)]
        read = reading.any(axis=1)
        causes = {
            ALL_ZERO: ~read & covered.zero,
            ALL_HELD: ~read & covered.held,
            NO_READING: ~read & ~covered.zero & ~covered.held,
        }
        for place, actuator in enumerate(ACTUATORS if self.asked else (), len(SENSORS)):
            cause = (
                f"the target torque of {actuator.replace('_', ' ')} is not recorded ({TARGETS[place - len(SENSORS)]})"
            )
            causes[cause] = read & ~covered.available[:, place]
        self.now = next((cause for cause, there in causes.items() if there[-1]), "")
        for cause, there in causes.items():
            self._count(cause, there)
        for place, name in enumerate(ELEMENTS):
            self._follow(name, time, covered.available[:, place], covered.parked, covered.judged)
        self._follow(_JUDGED, time, covered.judged, covered.parked)
        # The tolerated gap is that of the missing signals: sensors may be slower than targets.
        self.absences[_JUDGED].borne = LOST if self.now in ALL_GONE else UNASKED
        self._follow(_ENOUGH, time, reading.sum(axis=1) >= ALL, covered.parked)

    def leave_out(self, cause: str, there: np.ndarray) -> None:
        """Add samples of the next piece that are not judged although all sensors give readings."""
        self._count(cause, there)
        self.judged -= int(np.count_nonzero(there))

    @property
    def slid(self) -> float:
        """Time of driving forward in which the tyres slid, so that no fault was declared [s]."""
        return (self.unjudged.get(SLID, 0) + self.unjudged.get(SLIPPED, 0)) * self.period

    def add_low_grip(self, time: np.ndarray, slid: np.ndarray, values: np.ndarray) -> None:
        """Add the slides within the last piece; standstill and reversing are judged in no case, and do not count."""
        times, forward = self._forward
        slid = slid & forward[np.searchsorted(times, time)]
        self._count(SLID, slid)
        # A faulty acceleration looks like a slide, but the car does not turn.
        turning = np.abs(values[:, _YAW]) * np.abs(np.nan_to_num(values[:, WHEEL_PLACES])).max(axis=1)
        begins, ends = runs(slid & (turning > SLIPPERIEST))
        for first, last in zip(begins, ends - 1, strict=True):
            if self._slides and time[first] - self._slides[-1][1] < 2.0 * self.period:
                self._slides[-1] = self._slides[-1][0], float(time[last])
            else:
                self._slides.append((float(time[first]), float(time[last])))

    def slid_within(self, start: float, end: float) -> bool:
        """Whether the tyres slid in a turn at any time between two times [s]."""
        return any(first <= end and last >= start for first, last in self._slides)

    def _count(self, cause: str, there: np.ndarray) -> None:
        found = int(np.count_nonzero(there))
        if found:
            self.unjudged[cause] = self.unjudged.get(cause, 0) + found

    def _follow(
        self, name: str, time: np.ndarray, there: np.ndarray, parked: np.ndarray, others: np.ndarray | None = None
    ) -> None:
        borne = UNASKED if name in ACTUATORS else LOST
        self.absences.setdefault(name, Absence(self.period, borne)).add(time, there, parked, others)

    def loss(self, element: str, observed: float) -> Loss | None:
        """Loss of a signal without which an element cannot be judged: its own, or else others."""
        sensor = element in SENSORS
        gone = self.now if sensor and self.now in ALL_GONE else "no reading" if sensor else "no target"
        own = self.absences[element].loss(Status.NOT_AVAILABLE, gone, "read" if sensor else "its target was known")
        if own is not None:
            return own
        judged = self.absences[_JUDGED].loss(Status.NOT_TESTABLE, self.now, "it could be judged")
        enough = self.absences[_ENOUGH]
        if judged is None and enough.since is not None and observed <= enough.since + LOST:
            return enough.loss(Status.NOT_TESTABLE, TOO_FEW, "")
        return judged

    @property
    def enough(self) -> bool:
        return self.absences[_ENOUGH].came

    def add_sources(self, result: Result, graph: SubstitutionGraph) -> None:
        for sensor, ways in graph.substitutes.items():
            source = result[f"supplied.{sensor}.source"]
            counts = self.sources.setdefault(sensor, {})
            for number, way in enumerate(ways, 1):
                counts[way.name] = counts.get(way.name, 0) + int(np.count_nonzero(source == number))


def mean_speed(values: np.ndarray) -> np.ndarray:
    """Mean of the wheel speeds that are read [m/s], (n,), NaN without any, from columns of `ConditionSample`."""
    wheels = values[:, WHEEL_PLACES]
    there = np.isfinite(wheels)
    count = np.where(there.any(axis=1), there.sum(axis=1), np.nan)
    return np.asarray(np.where(there, wheels, 0.0).sum(axis=1) / count)


def is_moving(values: np.ndarray) -> np.ndarray:
    """Whether any wheel reads more than `STANDING`, (n,), from columns of `ConditionSample`."""
    with np.errstate(invalid="ignore"):
        return np.asarray((np.abs(values[:, WHEEL_PLACES]) >= STANDING).any(axis=1))
