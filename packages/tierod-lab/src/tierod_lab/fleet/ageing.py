"""Ageing of the friction of a virtual car: steady, sudden, or after every winter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE

SECONDS_PER_DAY = 86400.0
YEAR = 365.25
THAW = 75.0  # Day of the year on which the roads are free of salt and corrosion begins to swell (16 March)


@dataclass(frozen=True)
class Linear:
    """Steady rise, as by wear of a gear or loss of grease."""

    rate: Annotated[float, "N*m/s"]  # rise per second [N*m/s]; "1 N*m" over "100 d" is "0.01 N*m/d"

    def added(self, day: np.ndarray, begin: np.ndarray) -> np.ndarray:
        """Friction added [N*m] on days since 1970, for ageing that begins on a day; the shapes are broadcast."""
        return np.asarray(self.rate * SECONDS_PER_DAY * np.maximum(day - begin, 0.0))


@dataclass(frozen=True)
class Sudden:
    """Sudden rise, as by a bent rack or a broken bearing."""

    size: Annotated[float, "N*m"]  # size of the step [N*m]

    def added(self, day: np.ndarray, begin: np.ndarray) -> np.ndarray:
        """Friction added by this ageing [N*m]; arguments as in `Linear`."""
        return np.asarray(np.where(day >= begin, self.size, 0.0))


@dataclass(frozen=True)
class Corrosion:
    """Corrosion under a torn boot: after every winter, added friction grows exponentially to its final value."""

    size: Annotated[float, "N*m", NOT_NEGATIVE]  # final increase after each winter [N*m]
    time: Annotated[float, "s", POSITIVE] = 60.0 * SECONDS_PER_DAY  # time constant of the growth [s]

    def added(self, day: np.ndarray, begin: np.ndarray) -> np.ndarray:
        """Friction added by this ageing [N*m]; arguments as in `Linear`."""
        first = THAW + YEAR * np.ceil((begin - THAW) / YEAR)
        grown = np.zeros(np.broadcast_shapes(np.shape(day), np.shape(begin)))
        for winter in range(int(np.ceil(np.nanmax(day - begin, initial=0.0) / YEAR)) + 1):
            since = np.maximum(day - first - YEAR * winter, 0.0)
            grown += -np.expm1(-since * SECONDS_PER_DAY / self.time)
        return np.asarray(self.size * grown)


@dataclass(frozen=True)
class Ageing:
    """Ageing of some of the cars."""

    name: str
    law: Linear | Sudden | Corrosion  # course of the added friction over time
    share: Annotated[float, "", NOT_NEGATIVE]
    # earliest and latest time after the start at which it begins, uniformly distributed [s]
    begin: tuple[Annotated[float, "s", NOT_NEGATIVE], Annotated[float, "s", NOT_NEGATIVE]] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if self.share > 1.0:
            raise ParameterError(f"'share' of the ageing '{self.name}' is {self.share}; expected 1 or less")
        if self.begin[1] < self.begin[0]:
            raise ParameterError(f"the ageing '{self.name}' begins between {self.begin}; give the earlier time first")
