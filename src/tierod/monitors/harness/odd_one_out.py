"""Which of several signals that should go together does not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

Pair = tuple[str, str]


def odd_ones_out(names: Sequence[str], agreement: Mapping[Pair, bool]) -> tuple[str, ...]:
    """The signal that contradicts the others; several where it cannot be told which.

    Args:
        names: of all signals
        agreement: whether a pair agrees; pairs of which nothing is known are left out
    """
    against = [pair for pair, agrees in agreement.items() if not agrees]
    with_ = [pair for pair, agrees in agreement.items() if agrees]
    if not against:
        return ()
    suspects = [name for name in names if all(name in pair for pair in against)]
    cleared = [name for name in suspects if not any(name in pair for pair in with_)]
    return tuple(cleared or suspects or names)
