"""A stretch of a recording over which every uncertain parameter is moved alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tierod.core.recording import Aligned
from tierod.monitors.harness.spread.directions import Sensitivities
from tierod.monitors.harness.spread.main_result import Main, scale_of, where_known
from tierod.monitors.harness.spread.points import Concluded, Points
from tierod.monitors.harness.spread.shown import moved


def moves_alone(names: Sequence[str], fresh: bool) -> list[dict[str, float]]:
    """Standard deviations by parameter, of every vehicle of a stretch.

    Args:
        names: of the parameters
        fresh: whether the stretch begins within the recording: the last vehicle is then the one of the file
    """
    return [*({name: 1.0} for name in names), *([{}] if fresh else [])]


class Screen:
    """Follows the sessions of one stretch; sums are taken over whole blocks, so that no cut has an effect on them.

    Args:
        points: as of `moves_alone`
        names: of the parameters
        main: the result by which it is judged; None where there is none
        length: samples with a known result after which the stretch ends
        block: samples whose sums are taken together
        fresh: whether it begins within the recording: moves are then held against the session that begins with it
    """

    def __init__(self, points: Points, names: Sequence[str], main: Main | None, length: int, block: int, fresh: bool):
        self.points, self.length, self.fresh, self._block = points, length, fresh, block
        self.sensitivities = Sensitivities(names)
        self.buffer: list[Aligned] = []
        self.seen = self.known = 0
        self._main, self._count = main, len(names)
        self._parts: list[np.ndarray] = []

    def absorb(self, aligned: Aligned, shown: Mapping[str, np.ndarray]) -> dict[int, Mapping[str, np.ndarray]]:
        """Take in the next samples: traces by place of the parameter.

        Args:
            aligned: the samples
            shown: traces for the vehicle as it is
        """
        others = self.points.absorb(aligned)
        reference = others.pop(self._count, None) if self.fresh else shown
        if self._main is None:
            return others
        known, name = where_known(shown, self._main), self._main.pair.value
        before, self.seen = self.seen, self.seen + len(known)
        self.known += int(known.sum())
        if reference is None:
            return others
        self.buffer.append(replace(aligned))  # without the columns that were worked out of it
        scale = scale_of(shown, self._main)[known]
        moves = np.zeros((self._count, len(scale)))
        for place, other in others.items():
            moves[place] = moved(reference, other, name)[known] / scale
        self._add(moves, known, before)
        return others

    def _add(self, moves: np.ndarray, known: np.ndarray, before: int) -> None:
        """Add moves at valid results to the blocks of samples that they belong to."""
        counts, begin = np.concatenate([[0], np.cumsum(known)]), 0
        for end in [*range(self._block - before % self._block, len(known), self._block), len(known)]:
            self._parts.append(moves[:, counts[begin] : counts[end]])
            if (before + end) % self._block == 0:
                self.close_block()
            begin = end

    def close_block(self) -> None:
        """A block is whole, or the recording has ended."""
        if self._parts:
            self.sensitivities.add(np.ascontiguousarray(np.concatenate(self._parts, axis=1)))
            self._parts = []

    def conclude(self) -> dict[str, Concluded]:
        """Conclusions of the moved vehicles, by parameter."""
        found = self.points.conclude()
        return {name: found[place] for place, name in enumerate(self.sensitivities.names) if place in found}
