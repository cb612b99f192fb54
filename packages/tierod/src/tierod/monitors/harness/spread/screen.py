"""Stretch of a recording over which each uncertain parameter is perturbed alone."""

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
    """Perturbations of the vehicles of a stretch: each parameter by one standard deviation.

    Args:
        names: names of the parameters
        fresh: whether the stretch begins within the recording; the last vehicle is then the unperturbed one
    """
    return [*({name: 1.0} for name in names), *([{}] if fresh else [])]


class Screen:
    """Runs the sessions of one stretch; sums are taken over whole blocks, so that they do not depend on the pieces.

    Args:
        points: sessions of the perturbed vehicles, see `moves_alone`
        names: names of the parameters
        main: main result of the monitor; None without one
        length: samples with a valid result after which the stretch ends
        block: samples per block
        fresh: whether the stretch begins within the recording; the perturbed sessions are then compared with an
            unperturbed one that begins with it
    """

    def __init__(self, points: Points, names: Sequence[str], main: Main | None, length: int, block: int, fresh: bool):
        self.points, self.length, self.fresh, self._block = points, length, fresh, block
        self.sensitivities = Sensitivities(names)
        self.buffer: list[Aligned] = []
        self.seen = self.known = 0
        self._main, self._count = main, len(names)
        self._parts: list[np.ndarray] = []

    def absorb(self, aligned: Aligned, shown: Mapping[str, np.ndarray]) -> dict[int, Mapping[str, np.ndarray]]:
        """Process the next samples and return the traces by index of the parameter.

        Args:
            aligned: next samples
            shown: traces for the unperturbed vehicle
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
        self.buffer.append(replace(aligned))  # a copy without the cached columns, which the buffer does not need
        scale = scale_of(shown, self._main)[known]
        moves = np.zeros((self._count, len(scale)))
        for place, other in others.items():
            moves[place] = moved(reference, other, name)[known] / scale
        self._add(moves, known, before)
        return others

    def _add(self, moves: np.ndarray, known: np.ndarray, before: int) -> None:
        """Add changes at valid results to the blocks to which their samples belong."""
        counts, begin = np.concatenate([[0], np.cumsum(known)]), 0
        for end in [*range(self._block - before % self._block, len(known), self._block), len(known)]:
            self._parts.append(moves[:, counts[begin] : counts[end]])
            if (before + end) % self._block == 0:
                self.close_block()
            begin = end

    def close_block(self) -> None:
        """Add the collected changes to the sensitivities, at the end of a block or of the recording."""
        if self._parts:
            self.sensitivities.add(np.ascontiguousarray(np.concatenate(self._parts, axis=1)))
            self._parts = []

    def conclude(self) -> dict[str, Concluded]:
        """Conclusions of the perturbed vehicles, by parameter."""
        found = self.points.conclude()
        return {name: found[place] for place, name in enumerate(self.sensitivities.names) if place in found}
