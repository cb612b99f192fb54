"""Defects of input signals over a drive by the relations between them: delay, scale, clipping."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from tierod.core.facts import Fact, defect
from tierod.core.recording import Recording
from tierod.core.shown import in_words
from tierod.core.signals import residue_of
from tierod.methods.relations import CERTAIN, CORRELATION, FOLLOWS, RELATIONS
from tierod.methods.running import (
    BLOCK,
    RATE,
    Blocks,
    Lag,
    LaggedCorrelation,
    OuterLevels,
    piles_up,
)
from tierod.monitors.stuck import Stuck

MAXIMUM_AGE = 0.1  # Age from which a sample counts as missing [s], as in most monitors
AT_ONCE = 30 * BLOCK  # samples that are aligned at once, 10 min: a pause of many hours need not fit into memory
CHECKED = ("steering", "turn", "fast turn", "car", "road", "assist")  # relations that are checked over a drive

# Signals that are checked for clipping: their free motion has no preferred extreme, unlike an angle with stops or a
# speed that rests at zero
CLIPPED = ("driver_torque", "motor_torque", "lateral_acceleration", "yaw_rate", "steering_wheel_rate")

SHORTEST_CLIPPED = 1.0  # Total time at the extreme value from which a signal counts as clipped [s]

# Least share of that time in the drive [-], so that a motor at its limit in a single manoeuvre does not count
SHARE_CLIPPED = 0.005


class InputDefects:
    """Compares input signals over a drive; the result does not depend on how the recording is cut into pieces."""

    def __init__(self, names: Sequence[str]):
        pairs = {key: RELATIONS[key] for key in CHECKED if RELATIONS[key].signals <= set(names)}
        self._lags = {key: LaggedCorrelation(each.smallest) for key, each in pairs.items()}
        self._ends = {name: OuterLevels() for name in CLIPPED if name in names}
        used = [name for each in pairs.values() for name in (*each.first, *each.second)]
        self.names = tuple(dict.fromkeys((*used, *self._ends)))
        self._samples = 0
        self._blocks = Blocks(BLOCK, len(self.names))

    def add(self, recording: Recording, start: float, until: float, stuck: Iterable[Stuck] = ()) -> None:
        """Add the next piece."""
        if not self.names:
            return
        spans = tuple(each for each in stuck if each.name in self.names)
        while (first := start + self._samples / RATE) <= until:
            stop = min(until + 1e-6, first + (AT_ONCE - 0.5) / RATE)
            aligned = recording.align(self.names, RATE, maximum_age=MAXIMUM_AGE, start=first, stop=stop)
            self._samples += len(aligned.time)
            for each in spans:
                end = np.inf if each.end is None else each.end
                without = (aligned.time >= each.found) & (aligned.time < end)
                aligned.values[without, self.names.index(each.name)] = np.nan
            for block in self._blocks.add(aligned.values):
                self._take(dict(zip(self.names, block.T, strict=True)))

    def _take(self, block: Mapping[str, np.ndarray]) -> None:
        for key, lag in self._lags.items():
            slowest = RELATIONS[key].slowest
            lag.add(*RELATIONS[key].quantities(block, RATE), block["vehicle_speed"] >= slowest if slowest else None)
        for name, ends in self._ends.items():
            step = residue_of(name)
            ends.add(np.round(block[name][np.isfinite(block[name])] / step) * step)

    def found(self, units: Mapping[str, str] | None = None) -> tuple[Fact, ...]:
        """Defects of the input signals."""
        lags = {key: lag for key, each in self._lags.items() if (lag := each.found()) and lag.correlation > FOLLOWS}
        known = {key: lag for key, lag in lags.items() if lag.gain_correlation > CORRELATION}
        found: dict[str, Fact] = {}
        # Clipping looks like a wrong scale, and so may a delay: each signal is named for its most likely defect only.
        for each in (*self._clipped(units or {}), *self._late(lags), *self._scaled(known)):
            if not any(name in found for name in each.rests_on):
                found |= dict.fromkeys(each.rests_on, each)
        return tuple(dict.fromkeys(found.values()))

    def _late(self, lags: Mapping[str, Lag]) -> list[Fact]:
        """Delayed signals; where one seems early, the other one is late, since no sensor is early."""
        sides = {}
        for key, lag in lags.items():
            relation, margin = RELATIONS[key], CERTAIN * lag.deviation
            if lag.delay > relation.latest + margin:
                sides[key] = relation.second, relation.first
            elif lag.delay < relation.earliest - margin:
                sides[key] = relation.first, relation.second
        times_late = Counter(late for (late, *_), _ in sides.values())
        found: dict[str, Fact] = {}
        for key, ((late, *others), (beside, *_)) in sides.items():
            delay = abs(lags[key].delay - RELATIONS[key].usual)
            deviation = math.hypot(lags[key].deviation, RELATIONS[key].usual_deviation)
            sentence = f"{late} is late relative to {beside}, by {delay:.2f} ± {deviation:.2f} s"
            if others and times_late[late] == 1:
                sentence += f", or {' or '.join(others)} is wrong"
            else:
                others = []
            found.setdefault(late, defect((late, *others), sentence, f"{late} is late"))
        return list(found.values())

    def _scaled(self, lags: Mapping[str, Lag]) -> list[Fact]:
        found = []
        for key, lag in lags.items():
            relation = RELATIONS[key]
            if lag.gain > 0.0 and not 1.0 / relation.gain < lag.gain < relation.gain:
                names = (*relation.second, *relation.first)
                second, first = relation.words
                sentence = f"{' or '.join(names)} has a wrong scale: {second} is {lag.gain:.2f} times {first}"
                found.append(defect(names, sentence))
        return found

    def _clipped(self, units: Mapping[str, str]) -> list[Fact]:
        found = []
        least = max(SHORTEST_CLIPPED * RATE, SHARE_CLIPPED * self._samples)
        for name, ends in self._ends.items():
            for side, extreme, count, others in ends.ends():
                if extreme != 0.0 and count > least and piles_up(count, others):
                    value = in_words(extreme, units.get(name, ""), 4)
                    sentence = f"{name} is clipped at its {side} limit {value} for {count / RATE:.0f} s in total"
                    found.append(defect((name,), sentence, f"{name} is clipped"))
        return found
