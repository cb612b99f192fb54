"""Statistics of many judged drives: bounds of rates and probabilities, errors, quantiles, and paired tests."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

CONFIDENCE = 0.95  # Confidence level of all bounds and intervals of a campaign

BOOTSTRAPS = 4000  # Resamples of a bootstrap interval: its ends then vary by about 1 % of its width


def rate_bound(events: int, hours: float) -> float:
    """Upper confidence bound of the rate of a Poisson process [1/h]; infinite without observation time.

    Source: Garwood, Biometrika 28 (1936): half the chi-square quantile with 2 (n + 1) degrees of freedom. Without an
    event it is -ln(1 - CONFIDENCE), 3.0 events.
    """
    from scipy.stats import chi2

    return float(0.5 * chi2.ppf(CONFIDENCE, 2 * (events + 1)) / hours) if hours > 0.0 else math.inf


def share_bound(events: int, trials: int) -> float:
    """Upper confidence bound of a probability from a number of events in a number of trials; 1 without trials.

    Source: Clopper and Pearson, Biometrika 26 (1934). Without an event it is 1 - (1 - CONFIDENCE)**(1 / trials).
    """
    from scipy.stats import beta

    return 1.0 if events >= trials else float(beta.ppf(CONFIDENCE, events + 1, trials - events))


@dataclass(frozen=True)
class Moments:
    """Count, mean and sum of squared deviations, which can be pooled exactly over any division of the samples."""

    count: int = 0
    mean: float = math.nan
    squares: float = 0.0

    @classmethod
    def of(cls, values: np.ndarray) -> Moments:
        values = np.asarray(values, float)
        values = values[np.isfinite(values)]
        if not len(values):
            return cls()
        mean = float(values.mean())
        return cls(len(values), mean, float(np.sum((values - mean) ** 2)))

    @property
    def deviation(self) -> float:
        """Standard deviation of the samples themselves, not an estimate for a population: divided by n, not n - 1."""
        return math.sqrt(self.squares / self.count) if self.count else math.nan


def pooled(parts: Iterable[Moments]) -> Moments:
    """Moments of all samples together.

    Source: Chan, Golub and LeVeque, The American Statistician 37 (1983), eq (2.1).
    """
    total = Moments()
    for part in parts:
        if not part.count:
            continue
        if not total.count:
            total = part
            continue
        count, step = total.count + part.count, part.mean - total.mean
        mean = total.mean + step * part.count / count
        squares = total.squares + part.squares + step * step * total.count * part.count / count
        total = Moments(count, mean, squares)
    return total


def area_under_curve(lower: Sequence[float] | np.ndarray, higher: Sequence[float] | np.ndarray) -> float:
    """Probability that a value of one group lies above one of the other, ties counting half; NaN without values.

    Source: Hanley and McNeil, Radiology 143 (1982): the area under the ROC curve is Wilcoxon's rank statistic.
    """
    low, high = (np.asarray(values, float) for values in (lower, higher))
    low, high = low[~np.isnan(low)], high[~np.isnan(high)]
    if not (len(low) and len(high)):
        return math.nan
    ordered = np.sort(low)
    below = np.searchsorted(ordered, high, side="left")
    up_to = np.searchsorted(ordered, high, side="right")
    return float(np.mean(0.5 * (below + up_to)) / len(low))


def quantile(values: Sequence[float] | np.ndarray, share: float) -> float:
    """The smallest value that is not exceeded by the given share; infinite values (never detected) are included.

    No neighbouring values are averaged, since the mean with an infinite value is meaningless. NaN without values.
    """
    ordered = np.sort(np.asarray(values, float))
    # The tolerance keeps rounding of the product from raising the rank by one.
    return float(ordered[max(math.ceil(share * len(ordered) - 1e-9) - 1, 0)]) if len(ordered) else math.nan


@dataclass(frozen=True)
class Paired:
    """Statistics of paired differences."""

    count: int  # number of pairs in which both values exist
    mean: float
    median: float
    interval: tuple[float, float]  # 95 % bootstrap interval of the mean
    positive: int  # positive, negative: numbers of pairs with a difference above and below zero
    negative: int
    sign_p: float  # p-value of the two-sided sign test, without equal pairs
    rank_p: float  # p-value of Wilcoxon's signed-rank test; NaN if all pairs are equal


def paired(differences: Sequence[float] | np.ndarray) -> Paired:
    """Test paired differences; differences that are not finite are left out."""
    values = np.asarray(differences, float)
    values = values[np.isfinite(values)]
    if not len(values):
        return Paired(0, math.nan, math.nan, (math.nan, math.nan), 0, 0, math.nan, math.nan)
    positive, negative = int(np.sum(values > 0.0)), int(np.sum(values < 0.0))
    return Paired(
        len(values),
        float(values.mean()),
        float(np.median(values)),
        _bootstrap(values),
        positive,
        negative,
        _sign_test(positive, negative),
        _signed_ranks(values),
    )


def _bootstrap(values: np.ndarray) -> tuple[float, float]:
    generator = np.random.default_rng(len(values))
    # Eight parts need an eighth of the memory.
    means = np.concatenate(
        [values[generator.integers(0, len(values), (BOOTSTRAPS // 8, len(values)))].mean(axis=1) for _ in range(8)]
    )
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = np.quantile(means, (tail, 1.0 - tail))
    return float(low), float(high)


def _sign_test(positive: int, negative: int) -> float:
    from scipy.stats import binomtest

    count = positive + negative
    return float(binomtest(positive, count).pvalue) if count else math.nan


def _signed_ranks(values: np.ndarray) -> float:
    from scipy.stats import wilcoxon

    return float(wilcoxon(values).pvalue) if np.any(values != 0.0) else math.nan
