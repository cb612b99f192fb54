"""Defects of input signals that show over a whole drive: a delay, a wrong scale, clipping."""

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
"""Samples that are aligned at once, ten minutes, so that a pause of many hours need not fit into memory."""


@dataclass(frozen=True)
class Relation:
    """Two quantities of which the second follows the first, with their fault-free limits.

    Args:
        first, second: signals from which each quantity is computed; a delay is attributed to the first one of them, or
            the others are wrong, as a speed that is another signal shifts its product with the yaw rate
        smallest: least root mean square of the first quantity's change in 0.4 s [unit of the quantity]
        earliest, latest: bounds of the second quantity's delay in fault-free cars with slow messages [s]
        gain: factor by which the ratio of second to first may differ from 1; infinite if cars differ too much
        words: second and first quantity in words, for messages
        quantities: function that computes both from the signals by name, (n,) each
        slowest: least vehicle_speed of the samples that are compared [m/s]
    """

    first: tuple[str, ...]
    second: tuple[str, ...]
    smallest: float
    earliest: Annotated[float, "s"]
    latest: Annotated[float, "s"]
    gain: float
    words: tuple[str, str]
    quantities: Callable[[Mapping[str, np.ndarray]], tuple[np.ndarray, np.ndarray]]
    slowest: Annotated[float, "m/s"] = 0.0

    @property
    def usual(self) -> float:
        """Delay of a usual fault-free car [s]: the middle of the bounds."""
        return 0.5 * (self.earliest + self.latest)

    @property
    def usual_deviation(self) -> float:
        """Standard deviation of that delay between cars [s]: the bounds are taken as two of them away."""
        return 0.25 * (self.latest - self.earliest)


CHARACTERISTIC_SPEED = 22.0
"""Characteristic speed of a usual car [m/s], at which understeer halves the yaw rate of the neutral-steer car."""


def _turned(block: Mapping[str, np.ndarray], angle: str) -> np.ndarray:
    """Steering angle times speed over the understeer factor: proportional to the steady yaw rate of a usual car."""
    speed = block["vehicle_speed"]
    turned: np.ndarray = block[angle] * speed / (1.0 + (speed / CHARACTERISTIC_SPEED) ** 2)
    return turned


def _averaged(values: np.ndarray) -> np.ndarray:
    """Mean over 0.2 s: an angle that is held at 20 Hz changes in steps, which would make the ratio to it too small."""
    return np.convolve(values, np.full(round(0.2 * RATE) + 1, 1.0 / (round(0.2 * RATE) + 1)), mode="same")


def _turning(block: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    return block["vehicle_speed"] * block["yaw_rate"], block["lateral_acceleration"]


EARLY = 0.15
"""Lead of the lateral acceleration over yaw rate times speed in fault-free cars [s]; virtual cars show up to 0.08."""

REAR_DISTANCE = 1.5
"""Distance of the accelerometer from the rear axle in a usual car [m].

With v_y = rear_distance * yaw_rate at the accelerometer, a = v r + dv_y/dt leads v r by rear_distance / v.
"""

RELATIONS = {
    # A derived rate lags by 25 ms, and one that is held at 20 Hz by another 25 ms.
    "steering": Relation(
        ("steering_wheel_angle",),
        ("steering_wheel_rate",),
        0.05,
        -0.06,
        0.06,
        1.35,
        ("steering_wheel_rate", "the change of steering_wheel_angle"),
        lambda block: (
            _averaged(np.gradient(block["steering_wheel_angle"]) * RATE),
            _averaged(block["steering_wheel_rate"]),
        ),
    ),
    # Gains are 0.91 to 0.99 with roll and bank.
    "turn": Relation(
        ("yaw_rate", "vehicle_speed"),
        ("lateral_acceleration",),
        0.15,
        -np.inf,
        np.inf,
        1.5,
        ("lateral_acceleration", "yaw_rate times vehicle_speed"),
        _turning,
    ),
    # Delays are -79 to 92 ms in virtual cars and 119 ms in a real racing car.
    "fast turn": Relation(
        ("yaw_rate", "vehicle_speed"),
        ("lateral_acceleration",),
        0.15,
        -EARLY,
        0.2,
        np.inf,
        ("lateral_acceleration", "yaw_rate times vehicle_speed"),
        _turning,
        REAR_DISTANCE / EARLY,
    ),
    # Delays are 6 to 115 ms in 21 virtual cars and a racing car; a soft car on the motorway may need half as much
    # again.
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
    # Delays are -30 to 0 ms, as active return and damping act on the motor alone; messages add up to 20 ms, a period.
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
"""Relations by name. Limits are about twice what 18 fault-free virtual drives and the real recordings show."""

CORRELATION = 0.8
"""Correlation from which a gain is compared with its limit [-]; fault-free drives show 0.93 and more."""

FOLLOWS = 0.5
"""Correlation of the changes from which a delay is compared with its limits [-]; fault-free drives show 0.66 and
more."""

CERTAIN = 3.0
"""Standard deviations by which a delay must exceed its limit to count [-]."""

CLIPPED = ("driver_torque", "motor_torque", "lateral_acceleration", "yaw_rate", "steering_wheel_rate")
"""Signals that are checked for clipping: their free motion has no preferred extreme, unlike an angle with stops or a
speed that rests at zero."""

SHORTEST_CLIPPED = 1.0
"""Total time at the extreme value from which a signal counts as clipped [s]."""

SHARE_CLIPPED = 0.005
"""Least share of that time in the drive [-], so that a motor at its limit in a single manoeuvre does not count."""


REPAIR = "repair the sensor and record again, or correct the entry in channel map or vehicle file and judge again"
"""Remedy for a defective signal."""


class InputDefects:
    """Compares input signals over a drive; the result does not depend on how the recording is cut into pieces.

    Args:
        names: input signals of the monitor
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
        """Add the next piece.

        Args:
            recording: piece with the signals
            start: start of the whole recording [s]
            until: end of the piece [s]
            stuck: spans of stuck signals, which are ignored from their detection on
        """
        if not self.names:
            return
        spans = tuple(stuck)
        while (first := start + self._samples / RATE) <= until:
            stop = min(until + 1e-6, first + (AT_ONCE - 0.5) / RATE)
            self._compare(recording.align(self.names, RATE, maximum_age=MAXIMUM_AGE, start=first, stop=stop), spans)

    def _compare(self, aligned: Aligned, stuck: Sequence[Stuck]) -> None:
        """Add aligned samples, without those of stuck signals."""
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
            relation = RELATIONS[key]
            lag.add(
                *relation.quantities(block), block["vehicle_speed"] >= relation.slowest if relation.slowest else None
            )
        for name, (low, high) in self._ends.items():
            step = residue_of(name)
            seen = np.round(block[name][np.isfinite(block[name])] / step) * step
            _count(low, seen, min, slice(None, LEVELS))
            _count(high, seen, max, slice(-LEVELS, None))

    def found(self, units: Mapping[str, str] | None = None) -> tuple[Defect, ...]:
        """Defects of the input signals.

        Args:
            units: units of the signals in the recording, for the sentences
        """
        lags = {key: lag for key, each in self._lags.items() if (lag := each.found()) and lag.correlation > FOLLOWS}
        known = {key: lag for key, lag in lags.items() if lag.gain_correlation > CORRELATION}
        found: dict[str, Defect] = {}
        # Clipping looks like a wrong scale, and so may a delay: each signal is named for its most likely defect only.
        for defect in (*self._clipped(units or {}), *self._late(lags), *self._scaled(known)):
            if not any(name in found for name in defect.names):
                found |= dict.fromkeys(defect.names, defect)
        return tuple(dict.fromkeys(found.values()))

    def _late(self, lags: Mapping[str, Lag]) -> list[Defect]:
        """Delayed signals; where one seems early, the other one is late, since no sensor is early."""
        sides = {}
        for key, lag in lags.items():
            relation, margin = RELATIONS[key], CERTAIN * lag.deviation
            if lag.delay > relation.latest + margin:
                sides[key] = relation.second, relation.first
            elif lag.delay < relation.earliest - margin:
                sides[key] = relation.first, relation.second
        times_late = Counter(late for (late, *_), _ in sides.values())
        found: dict[str, Defect] = {}
        for key, ((late, *others), (beside, *_)) in sides.items():
            delay = abs(lags[key].delay - RELATIONS[key].usual)
            deviation = math.hypot(lags[key].deviation, RELATIONS[key].usual_deviation)
            sentence = f"{late} is late relative to {beside}, by {delay:.2f} ± {deviation:.2f} s"
            if others and times_late[late] == 1:
                sentence += f", or {' or '.join(others)} is wrong"
            else:
                others = []
            found.setdefault(late, Defect((late, *others), sentence))
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
                    sentence = f"{name} is clipped at its {side} limit {value} for {seconds:.0f} s in total"
                    found.append(Defect((name,), sentence))
        return found


def _count(end: Counter[float], seen: np.ndarray, outermost: Callable[..., float], kept: slice) -> None:
    """Count the samples on the outermost levels of a signal.

    Args:
        end: number of samples by level, updated in place
        seen: samples (n,)
        outermost: min for the lowest levels, max for the highest
        kept: slice of the ordered levels that are kept
    """
    # Once all levels are occupied, samples inside them cannot matter: this leaves few to be sorted.
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
    """Finding with the defects of its input signals; suspect if a needed signal is defective.

    A defect that withholds the estimate removes it from the finding.

    Args:
        finding: finding of a monitor
        defects: defects of its input signals
        monitor: monitor, with the signals that it requires and that its result rests on
    """
    named: set[str] = set()
    kept = []
    # Defects that withhold the estimate come first, so that they are kept where a signal has two defects.
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
    if not decisive or not finding.status.judged:
        return warned
    why, status = "; ".join(decisive), finding.status.doubted
    headline = f"{monitor.title}: {status}, because {why}. Ignoring this: {finding.headline}"
    return replace(warned, status=status, headline=headline).after(why, REPAIR)


def _withheld(finding: Finding, why: Sequence[str], monitor: Monitor) -> Finding:
    """Finding without its estimate, whose error may exceed any band."""
    status = Status.INCONSISTENT if monitor.estimates else Status.SUSPECT
    return replace(
        finding,
        status=status,
        headline=f"{monitor.title}: {status}, because {'; '.join(why)}. No value is given.",
        estimate=None,
        cause="; ".join(why),
        action="correct scale or unit of the signal in the channel map, or its time stamps, or give the vehicle file "
        "of this car (tierod identify vehicle), and judge again",
    )


def contradicted(finding: Finding, contradictions: Sequence[str], monitor: Monitor) -> Finding:
    """Finding; if it identified nothing, contradictions of required signals become its first cause.

    Args:
        finding: finding of a monitor
        contradictions: contradictions between signals over the drive, as sentences
        monitor: monitor with its required signals
    """
    needed = [each for each in contradictions if any(name in each for name in monitor.required)]
    return _named_first(finding, needed, monitor) if finding.status is Status.NOT_IDENTIFIABLE else finding


def _named_first(finding: Finding, why: Sequence[str], monitor: Monitor) -> Finding:
    """Finding that identified nothing, with the defects of its signals before the causes that follow from them."""
    new = [each for each in why if each not in finding.cause]
    if not new:
        return finding
    start = f"{monitor.title}: {finding.status.value}; "
    brief = "; ".join(re.split(r" \(|: ", each)[0] for each in new)
    named = replace(
        finding.after("; ".join(new), REPAIR), headline=f"{start}{brief}; {finding.headline.removeprefix(start)}"
    )
    return replace(named, action=finding.action) if finding.action.startswith(REPAIR) else named
