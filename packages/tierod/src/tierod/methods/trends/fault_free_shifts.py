"""Shifts of the levels of fault-free cars, for example by a change of tyres: errors that last for weeks.

The level of a fault-free car shifts with a small probability before each drive, up or down by a normally distributed
size. The density of the next drive is the mean over all possible shifts, each weighted with its probability given the
drives so far. Shifts before the stored beginnings are neglected, since the filter has followed them.

Source: R. P. Adams, D. J. C. MacKay, 2007, arXiv:0710.3742 (probabilities of the last shift, drive by drive).
"""

from __future__ import annotations

import numpy as np

EVERY = 182.6
"""Mean time between shifts of one car [d]: tyres are changed twice a year."""


class FaultFreeShifts:
    """Probability that the last shift was at each stored beginning, and the likelihood ratio of levels with shifts.

    Args:
        deviation: standard deviation of the sizes [unit]
    """

    def __init__(self, cars: int, beginnings: int, deviation: float):
        self.deviation = deviation
        self.none = np.ones(cars)
        self.share = np.zeros((cars, beginnings))
        self.single = np.zeros((cars, beginnings))
        # Log-likelihood ratio of a level that may shift against one that does not, accumulated since each beginning.
        self.ratio = np.zeros((cars, beginnings))

    def begin(self, slot: int, gap: np.ndarray) -> None:
        """Let shifts begin at a drive, in place of the oldest beginning.

        Args:
            slot: index of the beginning that is replaced
            gap: time since the drive before [d], (cars,)
        """
        # The filter has followed the shifts of the replaced beginning, so their probability goes to "no shift".
        self.none += self.share[:, slot]
        new = -np.expm1(-gap / EVERY)
        self.none *= 1.0 - new
        self.share *= (1.0 - new)[:, None]
        self.share[:, slot], self.single[:, slot], self.ratio[:, slot] = new, 0.0, 0.0

    def step(
        self, score: np.ndarray, information: np.ndarray, counts: np.ndarray, right: np.ndarray, wrong: np.ndarray
    ) -> None:
        """Update with one drive.

        Args:
            score, information: of steps from each beginning on, with this drive, (cars, beginnings)
            counts: whether the drive enters the sums of each beginning, (cars, beginnings)
            right, wrong: logarithms of the probabilities that it is right and wrong without any shift, (cars,)
        """
        single = normal_ratio(score, information, self.deviation)
        self.share *= np.exp(wrong)[:, None] + np.exp(right[:, None] + single - self.single)
        whole = self.none + self.share.sum(axis=1)
        self.none /= whole
        self.share /= whole[:, None]
        self.ratio += np.log(whole)[:, None]
        np.copyto(self.single, single, where=counts)


def normal_ratio(score: np.ndarray, information: np.ndarray, deviation: float) -> np.ndarray:
    """Logarithm of the mean of exp(a d - a^2 c / 2) over a normal size a of mean zero."""
    more = 1.0 + information * deviation**2
    return np.asarray(0.5 * ((score * deviation) ** 2 / more - np.log(more)))
