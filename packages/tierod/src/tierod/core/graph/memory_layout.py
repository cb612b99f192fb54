"""Layout of a block's state in one flat array."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tierod.core.block import Ring, Tree, values_of

GROUP = 8
"""Number of lanes of a bank that are stepped together: the number of doubles in the widest vector register."""


class BankState(NamedTuple):
    """State of a bank of blocks.

    Args:
        feedback: feedback of the judge at the previous sample, for all lanes
    """

    lanes: tuple[Tree, ...]
    judge: Tree
    feedback: Tree


def flat_memory(state: Tree) -> np.ndarray:
    """A state tree as one flat array, delay lines (filled with their initial value) at the end.

    The lanes of a bank come first, as `[group][number][lane of the group]`; the last group is padded with the first
    lane.
    """
    if not isinstance(state, BankState):
        plain, delayed = _plain_and_delayed(state)
        return np.array([*plain, *delayed], dtype=float)
    lanes = grouped(np.array([_plain_and_delayed(lane)[0] for lane in state.lanes], dtype=float))
    plain, delayed = _plain_and_delayed((state.judge, state.feedback))
    return np.concatenate([lanes, np.array([*plain, *delayed], dtype=float)])


def grouped(rows: np.ndarray) -> np.ndarray:
    """Rows, one per lane, in the layout of the memory: `[group][number][lane of the group]`, flat."""
    missing = -len(rows) % GROUP
    filled = np.concatenate([rows, np.repeat(rows[:1], missing, axis=0)])
    return filled.reshape(-1, GROUP, rows.shape[1]).transpose(0, 2, 1).ravel()


def ungrouped(flat: np.ndarray, count: int) -> np.ndarray:
    """The inverse of `grouped`: rows, one per lane."""
    groups = -(-count // GROUP)
    rows = flat.reshape(groups, -1, GROUP).transpose(0, 2, 1)
    return rows.reshape(groups * GROUP, -1)[:count]


def _plain_and_delayed(state: Tree) -> tuple[list[Any], list[Any]]:
    flat = values_of(state)
    plain = [leaf for leaf in flat if not isinstance(leaf, Ring)]
    return plain, [leaf.initial for leaf in flat if isinstance(leaf, Ring) for _ in range(leaf.size)]
