"""A virtual fleet as its file describes it, and the cars that are drawn from it."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np

from tierod.core.errors import ParameterError, TierodError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.files import expanded
from tierod.core.toml import Document, build
from tierod.fleet.virtual_ageing import SECONDS_PER_DAY, YEAR, Ageing

REFERENCE = 288.15
"""Temperature at which frictions are stated [K]: 15 °C."""
HOTTEST = 200.0
"""Day of the year (19 July)."""


@dataclass(frozen=True)
class Group:
    """A cohort of cars: a batch of racks, a supplier, a climate.

    Args:
        kind, name: such as "rack batch" and "2026-03"
        share: of the cars; what the groups of a kind leave belongs to a last group without a name of its own, "others"
        friction: by which that of its cars is higher [N*m]
        warmer: by which the places of its cars are warmer than the usual one [K]
    """

    kind: str
    name: str
    share: Annotated[float, "", POSITIVE]
    friction: Annotated[float, "N*m"] = 0.0
    warmer: Annotated[float, "K"] = 0.0


@dataclass(frozen=True)
class Season:
    """Ambient temperature over the year.

    Args:
        mean: of the year [K]
        amplitude: of the year's wave [K]
        weather: standard deviation from day to day [K]
        winter: whether cars stand on winter tyres from November to March
    """

    mean: Annotated[float, "K", POSITIVE] = 283.15
    amplitude: Annotated[float, "K", NOT_NEGATIVE] = 9.0
    weather: Annotated[float, "K", NOT_NEGATIVE] = 4.0
    winter: bool = True


@dataclass(frozen=True)
class FleetFile:
    """A virtual fleet.

    Args:
        name, description: for people
        cars: how many
        start: first day
        seed: of all chance
        weeks: how long they are driven
        drives_per_week: of each car
        duration: of a drive [s]
        vehicle: parameter set that monitors assume, a shipped name
        friction: of the usual fault-free car at 15 °C [N*m]
        friction_deviation: from car to car [N*m]
        per_kelvin: change of friction with temperature [N*m/K]; grease stiffens in the cold
        per_metre: rise of friction with mileage [N*m/m]; 0.02 N*m per 10 000 km is 2e-9
        mileage_per_year, mileage_deviation: of the cars [m], log-normal with this relative deviation
        age: oldest car at the start [s]; ages are drawn evenly
        season: of the places
        groups: cohorts
        ageing: of some cars
        wrong_share: of drives at estimate level with an error five times as large
    """

    name: str
    cars: Annotated[int, "", POSITIVE]
    start: str
    description: str = ""
    seed: Annotated[int, "", NOT_NEGATIVE] = 1
    weeks: Annotated[int, "", POSITIVE] = 52
    drives_per_week: Annotated[int, "", POSITIVE] = 1
    duration: Annotated[float, "s", POSITIVE] = 300.0
    vehicle: str = "midsize-eps"
    friction: Annotated[float, "N*m", POSITIVE] = 4.0
    friction_deviation: Annotated[float, "N*m", NOT_NEGATIVE] = 0.2
    per_kelvin: Annotated[float, "N*m/K"] = -0.01
    per_metre: Annotated[float, "N*m/m"] = 2e-9
    mileage_per_year: Annotated[float, "m", POSITIVE] = 1.5e7
    mileage_deviation: Annotated[float, "", NOT_NEGATIVE] = 0.4
    age: Annotated[float, "s", NOT_NEGATIVE] = 3.0 * YEAR * SECONDS_PER_DAY
    season: Season = field(default_factory=Season)
    groups: tuple[Group, ...] = ()
    ageing: tuple[Ageing, ...] = ()
    wrong_share: Annotated[float, "", NOT_NEGATIVE] = 0.005

    def __post_init__(self) -> None:
        _first_day(self.start)
        for kind in {each.kind for each in self.groups}:
            whole = sum(each.share for each in self.groups if each.kind == kind)
            if whole > 1.0 + 1e-9:
                raise ParameterError(f"the groups '{kind}' have shares of {whole:g} together; expected 1 at the most")
        if sum(each.share for each in self.ageing) > 1.0 + 1e-9:
            raise ParameterError("the shares of all ageings together exceed 1; a car has one ageing at the most")


def load(path: str | Path) -> FleetFile:
    """The virtual fleet of a file.

    Raises:
        ParameterError: no such file, or one with a slip (message: file, line, nearest name)
    """
    document = Document.read(expanded(str(path)), "virtual fleet")
    made: FleetFile = build(FleetFile, document.content, document)
    return made


def describes_fleet(path: str | Path) -> bool:
    """Whether a file describes a virtual fleet, and not a scenario of one drive."""
    if not Path(path).is_file():
        return False
    try:
        return "cars" in Document.read(Path(path), "virtual fleet").content
    except TierodError:
        return False


def _first_day(start: str) -> float:
    """Days since 1970."""
    try:
        return float((dt.date.fromisoformat(start) - dt.date(1970, 1, 1)).days)
    except ValueError:
        raise ParameterError(f"'start' is '{start}'; expected a day like 2026-01-05") from None


@dataclass(frozen=True, eq=False)
class VirtualCars:
    """The cars of a virtual fleet and when they are driven; rows are cars, columns are drives.

    Args:
        file: that describes them
        names: of the cars
        labels: kind of cohort -> name of each car's
        day: of each drive, since 1970 [d], (cars, drives)
        temperature: [K], (cars, drives)
        mileage: [m], (cars, drives)
        friction: true one [N*m], (cars, drives)
        ageing: name of each car's ageing; "" for none
        begin: day at which it begins, (cars,); NaN for none
    """

    file: FleetFile
    names: tuple[str, ...]
    labels: Mapping[str, tuple[str, ...]]
    day: np.ndarray
    temperature: np.ndarray
    mileage: np.ndarray
    friction: np.ndarray
    ageing: tuple[str, ...]
    begin: np.ndarray

    @property
    def winter(self) -> np.ndarray:
        """Whether a drive is on winter tyres, (cars, drives)."""
        of_year = self.day % YEAR  # days count from a first of January
        return np.asarray(self.file.season.winter & ((of_year < 90.0) | (of_year >= 305.0)))


def drawn(file: FleetFile) -> VirtualCars:
    """The cars of a fleet with the true friction of every drive; every part draws from a stream of its own.

    Args:
        file: that describes them
    """
    streams = iter(np.random.default_rng([file.seed, number]) for number in range(100))
    chance = next(streams)
    first, count = _first_day(file.start), file.weeks * file.drives_per_week
    span = 7.0 / file.drives_per_week
    day = first + span * (np.arange(count) + chance.uniform(0.1, 0.9, (file.cars, count)))
    labels, friction, warmer = _groups(file, next(streams))
    chance = next(streams)
    wave = file.season.amplitude * np.cos(2.0 * np.pi * (day - HOTTEST) / YEAR)
    temperature = file.season.mean + warmer[:, None] + wave + file.season.weather * chance.standard_normal(day.shape)
    chance = next(streams)
    rate = file.mileage_per_year / YEAR * np.exp(file.mileage_deviation * chance.standard_normal(file.cars))
    age = chance.uniform(0.0, file.age / SECONDS_PER_DAY, file.cars)
    mileage = rate[:, None] * (day - first + age[:, None])
    chance = next(streams)
    own = file.friction + file.friction_deviation * chance.standard_normal(file.cars) + friction
    level = own[:, None] + file.per_kelvin * (temperature - REFERENCE) + file.per_metre * mileage
    ageing, begin, added = _aged(file, day, first, next(streams))
    width = len(str(file.cars))
    return VirtualCars(
        file,
        tuple(f"car-{number + 1:0{width}d}" for number in range(file.cars)),
        labels,
        day,
        temperature,
        mileage,
        np.maximum(level + added, 0.0),
        ageing,
        begin,
    )


def _groups(file: FleetFile, chance: np.random.Generator) -> tuple[dict[str, tuple[str, ...]], np.ndarray, np.ndarray]:
    """Labels of every kind, and what they add to friction and temperature."""
    labels: dict[str, tuple[str, ...]] = {}
    friction, warmer = np.zeros(file.cars), np.zeros(file.cars)
    for kind in dict.fromkeys(each.kind for each in file.groups):
        order = chance.permutation(file.cars)
        names = ["others"] * file.cars
        first = 0.0
        for group in (each for each in file.groups if each.kind == kind):
            # Exact counts, so that a batch of 20 in 1 000 is one.
            chosen = order[round(first * file.cars) : round((first + group.share) * file.cars)]
            first += group.share
            friction[chosen] += group.friction
            warmer[chosen] += group.warmer
            for car in chosen:
                names[car] = group.name
        labels[kind] = tuple(names)
    return labels, friction, warmer


def _aged(
    file: FleetFile, day: np.ndarray, first: float, chance: np.random.Generator
) -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    """Name and begin of each car's ageing, and what it adds to every drive."""
    names, begin, added = [""] * file.cars, np.full(file.cars, np.nan), np.zeros(day.shape)
    order, taken = chance.permutation(file.cars), 0.0
    for each in file.ageing:
        chosen = order[round(taken * file.cars) : round((taken + each.share) * file.cars)]
        taken += each.share
        begin[chosen] = first + chance.uniform(*each.begin, len(chosen)) / SECONDS_PER_DAY
        added[chosen] = each.law.added(day[chosen], begin[chosen, None])
        for car in chosen:
            names[car] = each.name
    return tuple(names), begin, added
