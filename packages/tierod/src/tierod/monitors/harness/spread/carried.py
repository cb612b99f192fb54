"""Sessions with all parameters perturbed together along a few directions, over the rest of a recording."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from tierod.core.recording import Aligned
from tierod.monitors.harness.session import Conclusion
from tierod.monitors.harness.spread.directions import Direction
from tierod.monitors.harness.spread.points import Concluded, Points
from tierod.monitors.harness.spread.shown import moved

REACH = 2.0
"""Perturbation along a direction, in standard deviations [-]: the ends of a 95 % band."""


def moves_along(directions: Sequence[Direction], fresh: bool) -> list[dict[str, float]]:
    """Perturbations of the vehicles: each direction with both signs.

    Args:
        directions: principal directions
        fresh: whether the sessions begin within the recording; the last vehicle is then the unperturbed one

    Returns:
        standard deviations by name of the parameter, one entry per vehicle
    """
    ways = [
        {name: side * REACH * part for name, part in each.by.items()} for each in directions for side in (1.0, -1.0)
    ]
    return [*ways, *([{}] if fresh else [])]


class Carried:
    """Runs the sessions along some directions and adds up the variance that they cause.

    Args:
        points: sessions of the perturbed vehicles, see `moves_along`
        directions: principal directions, at least one
        fresh: whether the sessions began within the recording; they are then compared with an unperturbed session that
            began with them
    """

    def __init__(self, points: Points, directions: Sequence[Direction], fresh: bool):
        self.points, self.directions, self.fresh = points, tuple(directions), fresh
        self._reference = 2 * len(directions)
        self._places = list(range(len(directions)))

    def catch_up(self, buffer: Iterable[Aligned]) -> None:
        """Process the samples of the stretch on which the directions were found."""
        for part in buffer:
            self.points.absorb(part)

    def absorb(self, aligned: Aligned, shown: Mapping[str, np.ndarray], variances: Mapping[str, np.ndarray]) -> None:
        """Process the next samples and add the variances that the parameters cause.

        Args:
            aligned: next samples
            shown: traces for the unperturbed vehicle
            variances: variances by name of the result, updated in place
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
                    # The directions hold only a share of the variance: the division makes up for the rest.
                    variance += np.mean(squares, axis=0) / captured

    def fit(self, shares: Mapping[int, float], most: int) -> None:
        """Keep only the directions with the largest shares of the variance now.

        Args:
            shares: shares of the variance of the perturbed result, by index of the direction
            most: largest number of directions
        """
        self.directions = tuple(
            each._replace(share=shares.get(place, each.share)) for place, each in enumerate(self.directions)
        )
        self._places = sorted(sorted(self._places, key=lambda place: -shares[place])[:most])
        kept = {at for place in self._places for at in (2 * place, 2 * place + 1)} | {self._reference}
        self.points.running = {at: each for at, each in self.points.running.items() if at in kept}

    @property
    def followed(self) -> dict[int, Direction]:
        """Directions that are still followed, by index."""
        return {place: self.directions[place] for place in self._places}

    def conclude(self) -> tuple[list[tuple[Direction, list[Concluded]]], Conclusion | None]:
        """Conclusions of the perturbed vehicles by direction, and of the unperturbed session that began with them."""
        found = self.points.conclude()
        along = [
            (each, [found[at] for at in (2 * place, 2 * place + 1) if at in found])
            for place, each in self.followed.items()
        ]
        reference = found.get(self._reference) if self.fresh else None
        return along, reference.conclusion if reference is not None else None
