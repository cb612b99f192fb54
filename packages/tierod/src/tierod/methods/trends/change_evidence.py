"""Sequential evidence for a change in each car's level, drive by drive, valid however often it is evaluated.

A change that begins before drive j adds a times a signature to the drives from j on: 1 for a step, the time since the
middle between j and the drive before for a ramp. The response of the filter of an unchanged car to the signature is
known, so that the likelihood ratio of a change of size a against none is exp(a d - a^2 c / 2), with d and c summed over
the drives. Its mean over a half-normal size has a closed form. A drive is wrong (an outlier) with a small probability
and then does not depend on the change: it multiplies the ratio by (1 - p) + p r, where p is the probability that it is
right without a change, and r its ratio if it is right. Shifts of the level of a fault-free car (`fault_free_shifts`)
are part of the density of the fault-free hypothesis. The sum of the ratios over all beginnings, each weighted with the
days in which the change may have begun, is the Shiryaev-Roberts statistic in days: without a change its mean is the
elapsed time. A fault-free car therefore reaches A days after A days on average or later, whatever the number of drives.

Sources: A. S. Willsky, H. L. Jones, 1976, doi 10.1109/TAC.1976.1101146 (signatures); A. N. Shiryaev, 1963, doi
10.1137/1108002; M. Pollak, 1987, doi 10.1214/aos/1176350373 (mean time between false alarms); A. P. Dawid, 1984, doi
10.2307/2981683 (densities of each drive given those before).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import ParameterError
from tierod.methods.trends.drive_filter import LEVEL, SLOPE, Filtered, observed
from tierod.methods.trends.drive_scatter import WRONG
from tierod.methods.trends.drives import Drives
from tierod.methods.trends.fleet_alarms import FaultFreeShifts

STEP, RAMP = 0, 1  # Kinds of change: a step of the level, and a ramp that starts a constant slope


@dataclass(frozen=True)
class Changes:
    """Prior of the changes to be detected, and of shifts and outliers of fault-free cars."""

    # standard deviation of the sizes of steps [unit]; the size of a step worth finding
    step: Annotated[float, "unit of the quantity"]
    ramp: Annotated[float, "unit of the quantity/d"]  # standard deviation of the sizes of ramps [unit/d]
    # standard deviation of the shifts of fault-free levels, up or down [unit]
    shift: Annotated[float, "unit of the quantity"] = 0.0
    wrong: Annotated[float, ""] = 0.01  # share of wrong drives [-]
    beginnings: int = 26  # number of latest drives at which a change may have begun
    side: Annotated[float, ""] = 1.0  # 1 for rising levels, -1 for falling ones

    def __post_init__(self) -> None:
        if not (self.step > 0.0 and self.ramp > 0.0 and self.shift >= 0.0 and self.beginnings >= 1):
            raise ParameterError(f"{self}: step and ramp must be positive, shift not negative, beginnings at least 1")
        if not 0.0 < self.wrong < 1.0:
            raise ParameterError(f"the share of wrong drives is {self.wrong}; expected more than 0 and less than 1")
        if abs(self.side) != 1.0:
            raise ParameterError(f"side is {self.side}; expected 1 for rising or -1 for falling levels")


class Right(NamedTuple):
    """Logarithms of the probabilities that drives are right and that they are wrong, without a change."""

    right: np.ndarray
    wrong: np.ndarray


def right(normal: np.ndarray, wrong: float) -> Right:
    """Probabilities that drives are right and wrong, if the car has not changed.

    Innovations of wrong drives have a Cauchy distribution `WRONG` times as wide: its tail is so heavy that a single
    drive, however far off, never proves a change.
    """
    usual = np.log1p(-wrong) - 0.5 * (normal**2 + np.log(2.0 * np.pi))
    far = np.log(wrong / (np.pi * WRONG)) - np.log1p((normal / WRONG) ** 2)
    both = np.logaddexp(usual, far)
    return Right(usual - both, far - both)


@dataclass(frozen=True, eq=False)
class Evidence:
    """Evidence accumulated up to each drive."""

    # of the statistic in days after each drive, (cars, drives); without a drive, that of the drive before
    logarithm: np.ndarray
    kind: np.ndarray  # of the likeliest change after each drive, `STEP` or `RAMP`, (cars, drives)
    began: np.ndarray  # first drive that the likeliest change affects, (cars, drives)
    size: np.ndarray  # of the likeliest change [unit] or [unit/d], with its standard deviation, (cars, drives) each
    size_deviation: np.ndarray
    shift: np.ndarray  # of the level by that change so far [unit], (cars, drives)
    # earliest, latest: drives between which it began with 90 % posterior probability, (cars, drives)
    earliest: np.ndarray
    latest: np.ndarray


def evidence(drives: Drives, found: Filtered, changes: Changes) -> Evidence:
    """The statistic of every car after each drive, and the change that explains it best.

    Args:
        found: output of the filter that assumes no change
    """
    cars, count = drives.day.shape
    rows = observed(drives)
    search = _Search(cars, min(changes.beginnings, count), rows.shape[2], changes)
    shape = (cars, count)
    result = Evidence(
        np.full(shape, -np.inf), *(np.zeros(shape, int) for _ in range(2)), *(np.zeros(shape) for _ in range(3)),
        *(np.zeros(shape, int) for _ in range(2)),
    )  # fmt: skip
    present = drives.present
    for k in range(count):
        there = present[:, k]
        variance = np.where(there, found.variance[:, k], 1.0)
        normal = np.where(there, found.innovation[:, k], 0.0) / np.sqrt(variance)
        search.step(k, rows[:, k], found.gap[:, k], there, normal, variance, found.gain[:, k])
        search.conclude(k, there, result)
    return result


class _Search:
    """Running sums for the latest beginnings, steps first, then ramps; the newest beginning replaces the oldest."""

    def __init__(self, cars: int, beginnings: int, order: int, changes: Changes):
        self.changes, self.beginnings = changes, beginnings
        self.kinds = np.repeat((STEP, RAMP), beginnings)
        self.deviation = np.where(self.kinds == STEP, changes.step, changes.ramp)
        self.score = np.zeros((cars, 2 * beginnings))
        self.information = np.zeros_like(self.score)
        self.single = np.zeros_like(self.score)  # logarithm of the ratio that score and information give
        self.ratio = np.zeros_like(self.score)  # logarithm of the ratio with wrong drives
        self.signature = np.zeros_like(self.score)
        self.response = np.zeros((cars, 2 * beginnings, order))
        self.days = np.zeros_like(self.score)
        self.begun = np.zeros(2 * beginnings, int)
        self.shifts = FaultFreeShifts(cars, beginnings, changes.shift)

    def step(
        self,
        k: int,
        row: np.ndarray,
        gap: np.ndarray,
        there: np.ndarray,
        normal: np.ndarray,
        variance: np.ndarray,
        gain: np.ndarray,
    ) -> None:
        """Update with one drive of every car; cars without a drive keep their sums."""
        ramps = slice(self.beginnings, None)
        self.response[:, :, LEVEL] += gap[:, None] * self.response[:, :, SLOPE]
        self.signature[:, ramps] += np.where(self.days[:, ramps] > 0.0, gap[:, None], 0.0)
        for kind in (STEP, RAMP):
            self._begin(kind * self.beginnings + k % self.beginnings, k, gap, kind)
        self.shifts.begin(k % self.beginnings, gap)
        expected = np.einsum("cmi,ci->cm", self.response, row)
        unexplained = np.where(there[:, None], self.signature - expected, 0.0)
        self._weigh(unexplained / np.sqrt(variance)[:, None], normal)
        self.response += unexplained[:, :, None] * gain[:, None, :]

    def _weigh(self, signature: np.ndarray, normal: np.ndarray) -> None:
        """Ratios with one more drive, which enters the sums of a change where it is more likely right than wrong."""
        score = self.score + signature * (self.changes.side * normal)[:, None]
        information = self.information + signature**2
        single = half_normal_ratio(score, information, self.deviation)
        odds = right(normal, self.changes.wrong)
        with_change = odds.right[:, None] + single - self.single
        counts = with_change > odds.wrong[:, None]
        steps = slice(None, self.beginnings)
        self.shifts.step(score[:, steps], information[:, steps], counts[:, steps], odds.right, odds.wrong)
        self.ratio += np.logaddexp(odds.wrong[:, None], with_change)
        np.copyto(self.score, score, where=counts)
        np.copyto(self.information, information, where=counts)
        np.copyto(self.single, single, where=counts)

    def _begin(self, slot: int, k: int, gap: np.ndarray, kind: int) -> None:
        for each in (self.score, self.information, self.single, self.ratio):
            each[:, slot] = 0.0
        self.response[:, slot] = 0.0
        self.days[:, slot] = gap  # no change can have begun before the first drive, nor where there is none
        self.signature[:, slot] = np.where(gap > 0.0, 1.0 if kind == STEP else 0.5 * gap, 0.0)
        self.begun[slot] = k

    def logarithms(self) -> np.ndarray:
        """Logarithm of each beginning's part of the statistic; minus infinity where no change can have begun."""
        # Steps and ramps are equally likely: each kind gets half of the days.
        with np.errstate(divide="ignore"):
            weight = np.log(0.5 * self.days)
        return np.asarray(weight + self.ratio - np.tile(self.shifts.ratio, 2))

    def conclude(self, k: int, there: np.ndarray, result: Evidence) -> None:
        parts = self.logarithms()
        top = parts.max(axis=1)
        sane = np.isfinite(top)
        shares = np.exp(parts - np.where(sane, top, 0.0)[:, None])
        whole = shares.sum(axis=1)
        with np.errstate(divide="ignore"):
            now = np.where(sane, top + np.log(whole), -np.inf)
        best, line = parts.argmax(axis=1), np.arange(len(parts))
        precise = self.information[line, best] + 1.0 / self.deviation[best] ** 2
        result.logarithm[:, k] = np.where(there, now, result.logarithm[:, k - 1] if k else now)
        result.kind[:, k], result.began[:, k] = self.kinds[best], self.begun[best]
        result.size[:, k] = self.changes.side * self.score[line, best] / precise
        result.size_deviation[:, k] = 1.0 / np.sqrt(precise)
        result.shift[:, k] = result.size[:, k] * self.signature[line, best]
        order = np.argsort(self.begun, kind="stable")
        summed = np.cumsum(shares[:, order], axis=1) / np.where(whole > 0.0, whole, 1.0)[:, None]
        last = len(order) - 1
        result.earliest[:, k] = self.begun[order][np.minimum((summed < 0.05).sum(axis=1), last)]
        result.latest[:, k] = self.begun[order][np.minimum((summed < 0.95).sum(axis=1), last)]


def half_normal_ratio(score: np.ndarray, information: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Logarithm of the mean of exp(a d - a^2 c / 2) over a positive, half-normal size a."""
    from scipy.special import log_ndtr

    precise = information + 1.0 / deviation**2
    normal = score / np.sqrt(precise)
    return np.asarray(np.log(2.0) + log_ndtr(normal) + 0.5 * (normal**2 - np.log(precise * deviation**2)))
