"""Virtual fleet: its description in a file, and the cars drawn from it."""

from __future__ import annotations

import datetime as dt
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from tierod.core.errors import ParameterError, TierodError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.files import expanded
from tierod.core.toml import Document, build

SECONDS_PER_DAY = 86400.0
YEAR = 365.25


@dataclass(frozen=True)
class Linear:
    """Steady rise, as by wear of a gear or loss of grease; 1 N*m over 100 days is a rate of "0.01 N*m/d"."""

    rate: Annotated[float, "N*m/s"]

    def added(self, day: np.ndarray, begin: np.ndarray) -> np.ndarray:
        """Friction added [N*m] on days since 1970, for ageing that begins on a day; the shapes are broadcast."""
        return np.asarray(self.rate * SECONDS_PER_DAY * np.maximum(day - begin, 0.0))


@dataclass(frozen=True)
class Sudden:
    """Sudden rise, as by a bent rack or a broken bearing."""

    size: Annotated[float, "N*m"]

    def added(self, day: np.ndarray, begin: np.ndarray) -> np.ndarray:
        return np.asarray(np.where(day >= begin, self.size, 0.0))


@dataclass(frozen=True)
class Ageing:
    """Ageing of some of the cars."""

    name: str
    law: Linear | Sudden
    share: Annotated[float, "", NOT_NEGATIVE]
    # earliest and latest time after the start at which it begins, uniformly distributed [s]
    begin: tuple[Annotated[float, "s", NOT_NEGATIVE], Annotated[float, "s", NOT_NEGATIVE]] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if self.share > 1.0:
            raise ParameterError(f"'share' of the ageing '{self.name}' is {self.share}; expected 1 or less")
        if self.begin[1] < self.begin[0]:
            raise ParameterError(f"the ageing '{self.name}' begins between {self.begin}; give the earlier time first")


REFERENCE = 288.15  # Temperature at which friction is stated [K]: 15 °C
HOTTEST = 200.0  # Warmest day of the year (19 July) [d]


@dataclass(frozen=True)
class Group:
    """A cohort of cars: a batch of racks, a supplier, a climate."""

    kind: str  # kind, name: such as "rack batch" and "2026-03"
    name: str
    share: Annotated[float, "", POSITIVE]  # share of the cars; the rest of a kind forms a group "others"
    friction: Annotated[float, "N*m"] = 0.0  # additional friction of its cars
    warmer: Annotated[float, "K"] = 0.0  # additional ambient temperature of its cars


@dataclass(frozen=True)
class Season:
    """Ambient temperature over the year."""

    mean: Annotated[float, "K", POSITIVE] = 283.15  # mean over the year
    amplitude: Annotated[float, "K", NOT_NEGATIVE] = 9.0  # amplitude of the annual cycle
    weather: Annotated[float, "K", NOT_NEGATIVE] = 4.0  # standard deviation from day to day
    winter: bool = True  # whether cars stand on winter tyres from November to March


@dataclass(frozen=True)
class FleetFile:
    """A virtual fleet."""

    name: str
    cars: Annotated[int, "", POSITIVE]
    start: str  # first day, as an ISO date
    description: str = ""
    seed: Annotated[int, "", NOT_NEGATIVE] = 1
    weeks: Annotated[int, "", POSITIVE] = 52
    drives_per_week: Annotated[int, "", POSITIVE] = 1
    duration: Annotated[float, "s", POSITIVE] = 300.0  # duration of a drive
    vehicle: str = "midsize-eps"  # parameter set that the monitors assume, as a shipped name
    friction: Annotated[float, "N*m", POSITIVE] = 4.0  # mean friction of the fault-free cars at 15 °C
    friction_deviation: Annotated[float, "N*m", NOT_NEGATIVE] = 0.2  # standard deviation from car to car
    per_kelvin: Annotated[float, "N*m/K"] = -0.01  # change with temperature; grease stiffens in the cold
    per_metre: Annotated[float, "N*m/m"] = 2e-9  # rise with mileage; 0.02 N*m per 10 000 km is 2e-9
    mileage_per_year: Annotated[float, "m", POSITIVE] = 1.5e7  # median of the cars, log-normal
    mileage_deviation: Annotated[float, "", NOT_NEGATIVE] = 0.4
    age: Annotated[float, "s", NOT_NEGATIVE] = 3.0 * YEAR * SECONDS_PER_DAY  # greatest age at the start, uniform
    season: Season = field(default_factory=Season)
    groups: tuple[Group, ...] = ()
    ageing: tuple[Ageing, ...] = ()
    wrong_share: Annotated[float, "", NOT_NEGATIVE] = 0.005  # outliers at estimate level: errors five times as large

    def __post_init__(self) -> None:
        _first_day(self.start)
        for kind in {each.kind for each in self.groups}:
            whole = sum(each.share for each in self.groups if each.kind == kind)
            if whole > 1.0 + 1e-9:
                raise ParameterError(f"the groups '{kind}' have shares of {whole:g} together; expected 1 at the most")
        if sum(each.share for each in self.ageing) > 1.0 + 1e-9:
            raise ParameterError("the shares of all ageings together exceed 1; a car has one ageing at the most")


def load(path: str | Path) -> FleetFile:
    """Read the virtual fleet of a file."""
    document = Document.read(expanded(str(path)), "virtual fleet")
    made: FleetFile = build(FleetFile, document.content, document)
    return made


def describes_fleet(path: str | Path) -> bool:
    """Whether a file describes a virtual fleet, and not a scenario of a single drive."""
    if not Path(path).is_file():
        return False
    try:
        return "cars" in Document.read(Path(path), "virtual fleet").content
    except TierodError:
        return False


def _first_day(start: str) -> float:
    try:
        return float((dt.date.fromisoformat(start) - dt.date(1970, 1, 1)).days)
    except ValueError:
        raise ParameterError(f"'start' is '{start}'; expected a day like 2026-01-05") from None


@dataclass(frozen=True, eq=False)
class VirtualCars:
    """Cars of a virtual fleet and their drives; rows are cars, columns are drives."""

    file: FleetFile
    names: tuple[str, ...]
    labels: Mapping[str, tuple[str, ...]]  # kind of cohort -> name of each car's cohort
    day: np.ndarray  # day of each drive since 1970 [d]
    temperature: np.ndarray  # ambient temperature [K]
    mileage: np.ndarray  # [m]
    friction: np.ndarray  # true friction [N*m]
    ageing: tuple[str, ...]  # name of each car's ageing; "" for none
    begin: np.ndarray  # day on which the ageing begins, (cars,); NaN for none

    @property
    def winter(self) -> np.ndarray:
        of_year = self.day % YEAR  # days count from a first of January
        return np.asarray(self.file.season.winter & ((of_year < 90.0) | (of_year >= 305.0)))


def drawn(file: FleetFile) -> VirtualCars:
    """Draw the cars of a fleet with the true friction of every drive; each part uses a random stream of its own."""
    streams = iter(np.random.default_rng([file.seed, number]) for number in range(100))
    chance = next(streams)
    first, count = _first_day(file.start), file.weeks * file.drives_per_week
    span = 7.0 / file.drives_per_week
    day = first + span * (np.arange(count) + chance.uniform(0.1, 0.9, (file.cars, count)))
    labels, excess, warmer = _groups(file, next(streams))
    chance = next(streams)
    wave = file.season.amplitude * np.cos(2.0 * np.pi * (day - HOTTEST) / YEAR)
    temperature = file.season.mean + warmer[:, None] + wave + file.season.weather * chance.standard_normal(day.shape)
    chance = next(streams)
    rate = file.mileage_per_year / YEAR * np.exp(file.mileage_deviation * chance.standard_normal(file.cars))
    age = chance.uniform(0.0, file.age / SECONDS_PER_DAY, file.cars)
    mileage = rate[:, None] * (day - first + age[:, None])
    chance = next(streams)
    own = file.friction + file.friction_deviation * chance.standard_normal(file.cars) + excess
    level = own[:, None] + file.per_kelvin * (temperature - REFERENCE) + file.per_metre * mileage
    ageing, begin, added = _aged(file, day, first, next(streams))
    names = tuple(f"car-{number + 1:0{len(str(file.cars))}d}" for number in range(file.cars))
    friction = np.maximum(level + added, 0.0)
    return VirtualCars(file, names, labels, day, temperature, mileage, friction, ageing, begin)


def _shared(order: np.ndarray, among: Sequence[Group] | Sequence[Ageing]) -> Iterator[tuple[Any, np.ndarray]]:
    """Exact numbers of cars instead of draws: a batch with a share of 0.02 in 1 000 cars has 20 cars."""
    taken = 0.0
    for each in among:
        yield each, order[round(taken * len(order)) : round((taken + each.share) * len(order))]
        taken += each.share


def _groups(file: FleetFile, chance: np.random.Generator) -> tuple[dict[str, tuple[str, ...]], np.ndarray, np.ndarray]:
    """Labels by kind of cohort, and the additional friction [N*m] and temperature [K] of each car."""
    labels: dict[str, tuple[str, ...]] = {}
    friction, warmer = np.zeros(file.cars), np.zeros(file.cars)
    for kind in dict.fromkeys(each.kind for each in file.groups):
        names = np.array(["others"] * file.cars, object)
        for group, chosen in _shared(
            chance.permutation(file.cars), [each for each in file.groups if each.kind == kind]
        ):
            friction[chosen] += group.friction
            warmer[chosen] += group.warmer
            names[chosen] = group.name
        labels[kind] = tuple(names)
    return labels, friction, warmer


def _aged(
    file: FleetFile, day: np.ndarray, first: float, chance: np.random.Generator
) -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    """Name and begin of each car's ageing, and the friction that it adds to every drive [N*m]."""
    names, begin, added = np.array([""] * file.cars, object), np.full(file.cars, np.nan), np.zeros(day.shape)
    for each, chosen in _shared(chance.permutation(file.cars), file.ageing):
        begin[chosen] = first + chance.uniform(each.begin[0], each.begin[1], len(chosen)) / SECONDS_PER_DAY
        added[chosen] = each.law.added(day[chosen], begin[chosen, None])
        names[chosen] = each.name
    return tuple(names), begin, added
