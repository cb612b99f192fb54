"""Sessions for vehicles with all parameters moved together along a few directions, through the rest of a recording."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from tierod.core.recording import Aligned
from tierod.monitors.harness.session import Conclusion
from tierod.monitors.harness.spread.directions import Direction
from tierod.monitors.harness.spread.points import Concluded, Points
from tierod.monitors.harness.spread.shown import moved

REACH = 2.0
"""Standard deviations by which parameters are moved together along a direction: the ends of a 95 % band."""


def moves_along(directions: Sequence[Direction], fresh: bool) -> list[dict[str, float]]:
    """Standard deviations by parameter, of every vehicle: each direction both ways.

    Args:
        directions: that are followed
        fresh: whether they begin within the recording: the last vehicle is then the one of the file
    """
    ways = [
        {name: side * REACH * part for name, part in each.by.items()} for each in directions for side in (1.0, -1.0)
    ]
    return [*ways, *([{}] if fresh else [])]


class Carried:
    """Follows the sessions of some directions.

    Args:
        points: as of `moves_along`
        directions: at least one
        fresh: whether they began within the recording: moves are then held against the session that began with them
    """

    def __init__(self, points: Points, directions: Sequence[Direction], fresh: bool):
        self.points, self.directions, self.fresh = points, tuple(directions), fresh
        self._reference = 2 * len(directions)
        self._places = list(range(len(directions)))

    def catch_up(self, buffer: Iterable[Aligned]) -> None:
        """Take in the samples of the stretch on which the directions were found."""
        for part in buffer:
            self.points.absorb(part)

    def absorb(self, aligned: Aligned, shown: Mapping[str, np.ndarray], variances: Mapping[str, np.ndarray]) -> None:
        """Take in the next samples.

        Args:
            aligned: the samples
            shown: traces for the vehicle as it is
            variances: by name of a result, to which those of the parameters are added
        """
        others = self.points.absorb(aligned)
        reference = others.get(self._reference) if self.fresh else shown
        if reference is None:
            return
        captured = sum(each.share for each in self.followed.values())
        for name, variance in variances.items():
            for place in self._places:
                sides = [others[at] for at in (2 * place, 2 * place + 1) if at in others]
                squares = [(moved(reference, other, name) / REACH) ** 2 for other in sides]
                if squares:
                    variance += np.mean(squares, axis=0) / captured

    def fit(self, shares: Mapping[int, float], most: int) -> None:
        """Follow the directions that hold the most now, and no others.

        Args:
            shares: of the variance of the moved result, by place of the direction
            most: directions that are followed
        """
        self.directions = tuple(
            each._replace(share=shares.get(place, each.share)) for place, each in enumerate(self.directions)
        )
        self._places = sorted(sorted(self._places, key=lambda place: -shares[place])[:most])
        kept = {at for place in self._places for at in (2 * place, 2 * place + 1)} | {self._reference}
        self.points.running = {at: each for at, each in self.points.running.items() if at in kept}

    @property
    def followed(self) -> dict[int, Direction]:
        """The directions that are followed, by place."""
        return {place: self.directions[place] for place in self._places}

    def conclude(self) -> tuple[list[tuple[Direction, list[Concluded]]], Conclusion | None]:
        """Conclusions of the moved vehicles by direction, and of the session that began with them."""
        found = self.points.conclude()
        along = [
            (each, [found[at] for at in (2 * place, 2 * place + 1) if at in found])
            for place, each in self.followed.items()
        ]
        reference = found.get(self._reference) if self.fresh else None
        return along, reference.conclusion if reference is not None else None
