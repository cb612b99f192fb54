"""Every k-th sample of a recording, wherever its pieces are cut."""

from __future__ import annotations


class Stride:
    """Takes the first sample of all, then every `step`-th one.

    Args:
        step: samples from one that is taken to the next
    """

    def __init__(self, step: int):
        self.step = step
        self._seen = 0

    def over(self, count: int) -> slice:
        """Which of the samples of the next piece are taken.

        Args:
            count: samples of the piece
        """
        first = -self._seen % self.step
        self._seen += count
        return slice(first, None, self.step)
