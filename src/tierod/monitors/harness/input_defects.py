"""Defects of the signals that show over a whole drive: late against others, of another scale, clipped."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tierod.core.findings import Defect, Finding, Status
from tierod.core.recording import Aligned, Recording
from tierod.core.residues import residue_of
from tierod.core.shown import in_words
from tierod.io.quality import LEVELS, piles_up
from tierod.monitors.harness.delays import BLOCK, RATE, Lag, LagOverDrive
from tierod.monitors.harness.stuck_over_drive import MAXIMUM_AGE, Stuck

if TYPE_CHECKING:
    from tierod.monitors.harness.session import Monitor


AT_ONCE = 30 * BLOCK
"""Samples that are compared at once, ten minutes: a pause of many hours need not fit into memory."""


@dataclass(frozen=True)
class Relation:
    """Two quantities that follow each other, and by how much they may part.

    Args:
        first, second: signals that make them; the first of each is blamed for a delay
        smallest: root mean square of the first quantity's change in 0.4 s that is needed [its unit]
        earliest, latest: delay of the second that fault-free cars and slow messages explain [s]
        gain: factor by which second over first may be off 1; infinite where cars differ too much for a limit
        words: the second quantity and the first, for messages
        quantities: both, from the signals by name, (n,) each
    """

    first: tuple[str, ...]
    second: tuple[str, ...]
    smallest: float
    earliest: Annotated[float, "s"]
    latest: Annotated[float, "s"]
    gain: float
    words: tuple[str, str]
    quantities: Callable[[Mapping[str, np.ndarray]], tuple[np.ndarray, np.ndarray]]

    @property
    def usual(self) -> float:
        """Delay of a fault-free car [s]: the middle of what is explained."""
        return 0.5 * (self.earliest + self.latest)

    @property
    def usual_deviation(self) -> float:
        """Its standard deviation from car to car [s]; the limits are two of them away."""
        return 0.25 * (self.latest - self.earliest)


CHARACTERISTIC_SPEED = 22.0
"""At which a usual car turns half as much as its steering says [m/s]; makes yaw rate of angle and speed."""


def _turned(block: Mapping[str, np.ndarray], angle: str) -> np.ndarray:
    """Quantity that the yaw rate of a usual car is proportional to, by the name of a steering angle."""
    speed = block["vehicle_speed"]
    turned: np.ndarray = block[angle] * speed / (1.0 + (speed / CHARACTERISTIC_SPEED) ** 2)
    return turned


RELATIONS = {
    # A derived rate is 25 ms late, a held one of 20 Hz as much again.
    "steering": Relation(
        ("steering_wheel_angle",),
        ("steering_wheel_rate",),
        0.05,
        -0.06,
        0.06,
        1.35,
        ("steering_wheel_rate", "the change of steering_wheel_angle"),
        lambda block: (np.gradient(block["steering_wheel_angle"]) * RATE, block["steering_wheel_rate"]),
    ),
    # Virtual cars -79 to 92 ms, a real racing car 119 ms; gain 0.91 to 0.99 with roll and bank.
    "turn": Relation(
        ("yaw_rate", "vehicle_speed"),
        ("lateral_acceleration",),
        0.15,
        -0.15,
        0.2,
        1.5,
        ("lateral_acceleration", "yaw_rate times vehicle_speed"),
        lambda block: (block["vehicle_speed"] * block["yaw_rate"], block["lateral_acceleration"]),
    ),
    # 6 to 115 ms on 21 virtual cars and a racing car; a soft car on the motorway may need half as much again.
    "car": Relation(
        ("steering_wheel_angle", "vehicle_speed"),
        ("yaw_rate",),
        0.3,
        -0.05,
        0.18,
        np.inf,
        ("yaw_rate", "steering_wheel_angle"),
        lambda block: (_turned(block, "steering_wheel_angle"), block["yaw_rate"]),
    ),
    "road": Relation(
        ("road_wheel_angle", "vehicle_speed"),
        ("yaw_rate",),
        0.02,
        -0.05,
        0.18,
        np.inf,
        ("yaw_rate", "road_wheel_angle"),
        lambda block: (_turned(block, "road_wheel_angle"), block["yaw_rate"]),
    ),
    # -30 to 0 ms, as active return and damping act on the motor alone; messages come within a period of 20 ms.
    "assist": Relation(
        ("driver_torque",),
        ("motor_torque",),
        0.3,
        -0.06,
        0.06,
        np.inf,
        ("motor_torque", "driver_torque"),
        lambda block: (block["driver_torque"], block["motor_torque"]),
    ),
}
"""By what they are about. Limits are about twice what 18 fault-free virtual drives and the real recordings show."""

CORRELATION = 0.8
"""From which two quantities follow each other well enough for a scale [-]; fault-free drives 0.93 and more."""

FOLLOWS = 0.5
"""From which their changes follow each other well enough for a delay [-]; fault-free drives 0.66 and more."""

CERTAIN = 3.0
"""Standard deviations by which a delay must be beyond its limit [-]."""

CLIPPED = ("driver_torque", "motor_torque", "lateral_acceleration", "yaw_rate", "steering_wheel_rate")
"""Signals of which a free motion has no preferred extreme; an angle has stops, a speed rests at zero."""

SHORTEST_CLIPPED = 1.0
"""Time at the extreme value, together, from which a signal is clipped [s] ..."""

SHARE_CLIPPED = 0.005
"""... and as a share of the drive: a motor that gives all it has in one manoeuvre is not counted."""


REPAIR = "repair the signal, or its entry in channel map or vehicle file, and record again"
"""What to do about a signal that is not what it says."""


class InputDefects:
    """Compares signals over a drive; the result does not depend on how the recording is cut.

    Args:
        names: that the monitor takes
    """

    def __init__(self, names: Sequence[str]):
        pairs = {key: each for key, each in RELATIONS.items() if {*each.first, *each.second} <= set(names)}
        self._lags = {key: LagOverDrive(each.smallest) for key, each in pairs.items()}
        self._ends = {name: (Counter[float](), Counter[float]()) for name in CLIPPED if name in names}
        used = [name for each in pairs.values() for name in (*each.first, *each.second)]
        self.names = tuple(dict.fromkeys((*used, *self._ends)))
        self._samples = 0
        self._pending = np.empty((0, len(self.names)))

    def add(self, recording: Recording, start: float, until: float, stuck: Iterable[Stuck] = ()) -> None:
        """The next piece.

        Args:
            recording: that holds the signals
            start: of the whole recording [s]
            until: time up to which the piece reaches [s]
            stuck: signals that do not count meanwhile, from when that was known
        """
        if not self.names:
            return
        spans = tuple(stuck)
        while (first := start + self._samples / RATE) <= until:
            stop = min(until + 1e-6, first + (AT_ONCE - 0.5) / RATE)
            self._compare(recording.align(self.names, RATE, maximum_age=MAXIMUM_AGE, start=first, stop=stop), spans)

    def _compare(self, aligned: Aligned, stuck: Sequence[Stuck]) -> None:
        """The next samples, without those of stuck signals."""
        self._samples += len(aligned.time)
        for each in stuck:
            if each.name in self.names:
                end = np.inf if each.end is None else each.end
                without = (aligned.time >= each.found) & (aligned.time < end)
                aligned.values[without, self.names.index(each.name)] = np.nan
        self._pending = np.vstack([self._pending, aligned.values])
        while len(self._pending) >= BLOCK:
            self._take(dict(zip(self.names, self._pending[:BLOCK].T, strict=True)))
            self._pending = self._pending[BLOCK:]

    def _take(self, block: Mapping[str, np.ndarray]) -> None:
        for key, lag in self._lags.items():
            lag.add(*RELATIONS[key].quantities(block))
        for name, (low, high) in self._ends.items():
            step = residue_of(name)
            seen = np.round(block[name][np.isfinite(block[name])] / step) * step
            _count(low, seen, min, slice(None, LEVELS))
            _count(high, seen, max, slice(-LEVELS, None))

    def found(self, units: Mapping[str, str] | None = None) -> tuple[Defect, ...]:
        """Defects of the inputs.

        Args:
            units: of the signals in the recording, for the sentences
        """
        lags = {key: lag for key, each in self._lags.items() if (lag := each.found()) and lag.correlation > FOLLOWS}
        known = {key: lag for key, lag in lags.items() if lag.gain_correlation > CORRELATION}
        found: dict[str, Defect] = {}
        # Clipping looks like a wrong scale, and a delay may; each signal is named for its most likely defect only.
        for defect in (*self._clipped(units or {}), *self._late(lags), *self._scaled(known)):
            if not any(name in found for name in defect.names):
                found |= dict.fromkeys(defect.names, defect)
        return tuple(dict.fromkeys(found.values()))

    def _late(self, lags: Mapping[str, Lag]) -> list[Defect]:
        """A signal ahead of another makes the other late: no sensor is early."""
        found: dict[str, Defect] = {}
        for key, lag in lags.items():
            relation, margin = RELATIONS[key], CERTAIN * lag.deviation
            if lag.delay > relation.latest + margin:
                late, beside = relation.second[0], relation.first[0]
            elif lag.delay < relation.earliest - margin:
                late, beside = relation.first[0], relation.second[0]
            else:
                continue
            delay = abs(lag.delay - relation.usual)
            deviation = math.hypot(lag.deviation, relation.usual_deviation)
            sentence = f"{late} is late against {beside}, by {delay:.2f} ± {deviation:.2f} s"
            found.setdefault(late, Defect((late,), sentence))
        return list(found.values())

    def _scaled(self, lags: Mapping[str, Lag]) -> list[Defect]:
        found = []
        for key, lag in lags.items():
            relation = RELATIONS[key]
            if lag.gain > 0.0 and not 1.0 / relation.gain < lag.gain < relation.gain:
                names = (*relation.second, *relation.first)
                second, first = relation.words
                sentence = f"{' or '.join(names)} has a wrong scale: {second} is {lag.gain:.2f} times {first}"
                found.append(Defect(names, sentence))
        return found

    def _clipped(self, units: Mapping[str, str]) -> list[Defect]:
        found = []
        least = max(SHORTEST_CLIPPED * RATE, SHARE_CLIPPED * self._samples)
        for name, (low, high) in self._ends.items():
            for end, side, outermost in ((low, "lower", min), (high, "upper", max)):
                extreme = outermost(end, default=0.0)
                others = [count for level, count in end.items() if level != extreme]
                if extreme != 0.0 and end[extreme] > least and piles_up(end[extreme], others):
                    seconds = end[extreme] / RATE
                    value = in_words(extreme, units.get(name, ""), 4)
                    sentence = f"{name} is clipped at its {side} end {value} for {seconds:.0f} s in all"
                    found.append(Defect((name,), sentence))
        return found


def _count(end: Counter[float], seen: np.ndarray, outermost: Callable[..., float], kept: slice) -> None:
    """Count the samples on the outermost levels; only these need be sorted once there are enough.

    Args:
        end: samples by level, brought up to date
        seen: samples (n,)
        outermost: min where low levels are counted, else max
        kept: which of the levels in order
    """
    if len(end) == LEVELS:
        inner = (max if outermost is min else min)(end)
        seen = seen[seen <= inner] if outermost is min else seen[seen >= inner]
    if not len(seen):
        return
    levels, counts = np.unique(seen, return_counts=True)
    end.update(dict(zip(levels[kept].tolist(), counts[kept].tolist(), strict=True)))
    outer = sorted(end)[kept]
    for level in [each for each in end if each not in outer]:
        del end[level]


def with_defects(finding: Finding, defects: Sequence[Defect], monitor: Monitor) -> Finding:
    """The finding with the defects of its signals; suspect where one of a signal that is needed may have made it.

    Where one withholds the estimate, none is left in the finding.

    Args:
        finding: of a monitor
        defects: of its signals
        monitor: that judges nothing without its required signals
    """
    named: set[str] = set()
    kept = []
    for defect in sorted(defects, key=lambda each: not each.withholds):
        if not named & set(defect.names):
            kept.append(defect)
            named |= set(defect.names)
    kept.sort(key=list(defects).index)
    needed = {*monitor.required, *monitor.rests_on}
    decisive = [defect.sentence for defect in kept if any(name in needed for name in defect.names)]
    warned = replace(finding, warnings=(*(defect.sentence for defect in kept), *finding.warnings))
    if finding.estimate is not None and any(defect.withholds for defect in kept):
        return _withheld(
            warned, [each.sentence for each in kept if each.withholds or each.sentence in decisive], monitor
        )
    if decisive and finding.status is Status.NOT_IDENTIFIABLE:
        return _named_first(warned, decisive, monitor)
    if not decisive or finding.status not in (Status.HEALTHY, Status.RISING, Status.FAULT, Status.SUSPECT):
        return warned
    why = "; ".join(decisive)
    suspect = replace(warned, status=Status.SUSPECT)
    headline = f"{monitor.title}: {suspect.shown_status}, since {why}. Without regard to that: {finding.headline}"
    return replace(suspect, headline=headline).after(why, REPAIR)


def _withheld(finding: Finding, why: Sequence[str], monitor: Monitor) -> Finding:
    """The finding without its estimate, which may be wrong by more than any band."""
    status = replace(finding, status=Status.SUSPECT)
    return replace(
        status,
        headline=f"{monitor.title}: {status.shown_status}, since {'; '.join(why)}. No value is stated.",
        estimate=None,
        cause="; ".join(why),
        action="correct scale, unit or time of the signal in the channel map, or give the vehicle file of this car "
        "(tierod identify vehicle), and judge anew",
    )


def contradicted(finding: Finding, contradictions: Sequence[str], monitor: Monitor) -> Finding:
    """The finding; where nothing could be identified, signs and units of needed signals that contradict others first.

    Args:
        finding: of a monitor
        contradictions: of the signals over the drive, as sentences
        monitor: that judges nothing without its required signals
    """
    needed = [each for each in contradictions if any(name in each for name in monitor.required)]
    return _named_first(finding, needed, monitor) if finding.status is Status.NOT_IDENTIFIABLE else finding


def _named_first(finding: Finding, why: Sequence[str], monitor: Monitor) -> Finding:
    """The finding that identified nothing, with the defects of its signals before those that followed from them."""
    new = [each for each in why if each not in finding.cause]
    if not new:
        return finding
    start = f"{monitor.title}: {finding.status.value}; "
    brief = "; ".join(re.split(r" \(|: ", each)[0] for each in new)
    named = replace(
        finding.after("; ".join(new), REPAIR), headline=f"{start}{brief}; {finding.headline.removeprefix(start)}"
    )
    return replace(named, action=finding.action) if finding.action.startswith(REPAIR) else named
