"""Find the closed lock-to-lock loops in a recording of the steering wheel."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tierod.core.errors import InputError


@dataclass(frozen=True)
class Loop:
    """A stretch of samples over which the steering wheel returns to where it began.

    Args:
        first: index of its first sample
        last: index of its last sample (inclusive)
        turning_points: indices where the direction changes, between first and last, both left out
        gap: angle at the last sample less angle at the first one [rad]
    """

    first: int
    last: int
    turning_points: tuple[int, ...]
    gap: float

    @property
    def corners(self) -> tuple[int, ...]:
        """First sample, turning points, last sample: the ends of the strokes."""
        return (self.first, *self.turning_points, self.last)

    def shifted(self, by: int) -> Loop:
        """The same loop where every index is moved by `by`."""
        return Loop(self.first + by, self.last + by, tuple(turn + by for turn in self.turning_points), self.gap)


def turning_points(angle: np.ndarray, least_return: float) -> list[int]:
    """Indices of the extremes of an angle that is followed by a return of at least `least_return` [rad].

    Args:
        angle: shape (n,), without NaN [rad]
        least_return: smaller returns are noise [rad]
    """
    found: list[int] = []
    lowest = highest = 0
    direction = 0
    for index, value in enumerate(angle):
        if value > angle[highest]:
            highest = index
        if value < angle[lowest]:
            lowest = index
        if direction >= 0 and value < angle[highest] - least_return:
            found += [highest] * (direction > 0)
            direction, lowest = -1, index
        elif direction <= 0 and value > angle[lowest] + least_return:
            found += [lowest] * (direction < 0)
            direction, highest = 1, index
    return found


def closed_loops(angle: np.ndarray, minimum_stroke: float, tolerance: float, least_return: float) -> list[Loop]:
    """All successive loops that visit both locks and close within a tolerance.

    A loop begins where the wheel begins to move (or where the last loop ended), visits both locks and ends where it
    comes nearest to its own start. What follows the last closed loop is left out.

    Args:
        angle: steering wheel angle, shape (n,), without NaN [rad]
        minimum_stroke: least distance between the locks [rad]
        tolerance: largest difference of the angles at both ends, and between lock visits [rad]
        least_return: motion below this is noise [rad]

    Raises:
        InputError: the stroke is too small for a lock-to-lock test, or no loop closes
    """
    lowest, highest = float(np.min(angle)), float(np.max(angle))
    if highest - lowest < minimum_stroke:
        raise InputError(
            f"the steering wheel moves over {math.degrees(highest - lowest):.0f} deg, but a lock-to-lock loop needs at "
            f"least {math.degrees(minimum_stroke):.0f} deg; record a turn to one lock, to the other and back"
        )
    turns = np.array(turning_points(angle, least_return), dtype=int)
    loops: list[Loop] = []
    first = _motion_begins(angle, least_return)
    while True:
        last = _where_it_closes(angle, first, lowest + tolerance, highest - tolerance, tolerance)
        if last is None:
            break
        within = tuple(int(turn) for turn in turns if first < turn < last)
        loops.append(Loop(first, last, within, float(angle[last] - angle[first])))
        first = last
    if not loops:
        raise InputError(
            f"the loop does not close: it begins at {math.degrees(angle[first]):.1f} deg and ends at "
            f"{math.degrees(angle[-1]):.1f} deg (locks at {math.degrees(lowest):.0f} and "
            f"{math.degrees(highest):.0f} deg, tolerance {math.degrees(tolerance):.1f} deg); "
            "turn to both locks and back to where the turn began"
        )
    return loops


def _motion_begins(angle: np.ndarray, least_return: float) -> int:
    """The last sample at rest before the wheel has moved by half of the noise limit."""
    moved = np.flatnonzero(np.abs(angle - angle[0]) > 0.5 * least_return)
    return max(int(moved[0]) - 1, 0)


def _where_it_closes(angle: np.ndarray, first: int, low: float, high: float, tolerance: float) -> int | None:
    """Index of the first return to angle[first] after both locks were visited, None where there is none."""
    rest = angle[first:]
    at_low, at_high = np.flatnonzero(rest <= low), np.flatnonzero(rest >= high)
    if not len(at_low) or not len(at_high):
        return None
    both_visited = max(int(at_low[0]), int(at_high[0]))
    distance = np.abs(rest[both_visited:] - rest[0])
    near = distance <= tolerance
    if not near.any():
        return None
    begin = int(np.argmax(near))
    leaves = np.flatnonzero(~near[begin:])
    end = begin + int(leaves[0]) if len(leaves) else len(distance)
    return first + both_visited + begin + int(np.argmin(distance[begin:end]))
