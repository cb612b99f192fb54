"""Parameters of a vehicle that a monitor requires, those that it can use, and those that a vehicle file lacks.

They are found by opening every variant with every shipped vehicle and recording which parameters it reads.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from tierod.core.errors import TierodError
from tierod.io.derive import RECIPES
from tierod.io.readers import load_channel_map
from tierod.monitors.harness.session import Monitor, Variant
from tierod.monitors.registry import MONITORS
from tierod.vehicles import QUANTITIES, Parameter, Vehicle, load, shipped
from tierod.vehicles.uncertain import is_guess, may_move
from tierod.vehicles.vehicle import Parameters

GUESSED = 0.03
"""Relative standard deviation from which a parameter counts as a guess [-]: a tape measure and a scale do better."""


@dataclass
class Reading:
    """Parameters of a vehicle that a session reads."""

    needed: set[str] = field(default_factory=set)  # parameters without which the session cannot be opened
    optional: set[str] = field(default_factory=set)  # parameters that it uses if the vehicle file gives them
    unclear: set[str] = field(default_factory=set)  # parameters that it requests without a default, but may not require


class _Parameters(Mapping[str, Parameter]):
    """Parameters of a vehicle that record every lookup as optional."""

    def __init__(self, known: Mapping[str, Parameter], reading: Reading):
        self.known, self.reading = known, reading

    def __getitem__(self, name: str) -> Parameter:
        self.reading.optional.add(name)
        return self.known[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.known)

    def __len__(self) -> int:
        return len(self.known)


@dataclass(frozen=True)
class _ReadVehicle(Vehicle):
    """Vehicle that records which parameters are read, and which of these have no default."""

    reading: Reading = field(default_factory=Reading)

    def __getitem__(self, name: str) -> float:
        """Value of a parameter."""
        self.reading.unclear.add(name)
        return super().__getitem__(name)

    def parameters_for(self, wanted: type[Parameters]) -> Parameters:
        """Dataclass of parameters; see `Vehicle.parameters_for`."""
        fields = [each for each in dataclasses.fields(wanted) if each.init]  # type: ignore[arg-type]
        missing = dataclasses.MISSING
        self._asked({each.name for each in fields if each.default is missing and each.default_factory is missing})
        return super().parameters_for(wanted)

    def _asked(self, names: set[str]) -> None:
        """Record names that are requested without a default."""
        looked_for = names & self.reading.optional
        self.reading.unclear |= looked_for
        self.reading.needed |= names - looked_for


@functools.cache
def readings(monitor: str) -> dict[str, dict[str, Reading]]:
    """Parameters that a monitor reads: variant -> shipped vehicle with which it opens -> parameters."""
    found: dict[str, dict[str, Reading]] = {}
    for variant in MONITORS[monitor].variants.values():
        found[variant.name] = {}
        for name in shipped():
            with contextlib.suppress(TierodError):
                found[variant.name][name] = _reading(variant, load(name), MONITORS[monitor].rate)
    return found


def _reading(variant: Variant, vehicle: Vehicle, rate: float) -> Reading:
    reading = Reading()
    fields = {each.name: getattr(vehicle, each.name) for each in dataclasses.fields(Vehicle)}
    fields["parameters"] = _Parameters(vehicle.parameters, reading)
    session = variant.open(_ReadVehicle(**fields, reading=reading), rate, None)
    # Some parameters are read only in the conclusion, which may fail in a session without a recording.
    with contextlib.suppress(Exception):
        session.conclude()
    reading.needed &= vehicle.parameters.keys()
    # A lookup does not show whether the session has a fallback: open it once without each of these parameters.
    for name in (reading.unclear & vehicle.parameters.keys()) - reading.needed:
        without = {key: value for key, value in vehicle.parameters.items() if key != name}
        try:
            variant.open(dataclasses.replace(vehicle, parameters=without), rate, None)
        except TierodError:
            reading.needed.add(name)
    reading.optional = (reading.optional | reading.unclear) - reading.needed
    return reading


@dataclass(frozen=True)
class Lacking:
    """Requirements of a variant that a vehicle does not fulfil."""

    obstacle: str  # reason why the variant cannot run with this vehicle; "" if it can
    needed: tuple[str, ...]  # needed, optional: required and optional parameters that the vehicle file does not give
    optional: tuple[str, ...]
    # parameters of the file that the variant reads and whose relative standard deviation is `GUESSED` or more, the
    # least certain first
    guessed: tuple[str, ...]
    # needed_signals, optional_signals: required and optional signals that the channel map of the vehicle does not name;
    # None if the vehicle names no map
    needed_signals: tuple[str, ...] | None
    optional_signals: tuple[str, ...] | None


def lacking(monitor: Monitor, variant: Variant, car: Vehicle) -> Lacking:
    """Requirements of a variant that a vehicle does not fulfil."""
    cars = readings(monitor.name).get(variant.name, {}) if monitor.name in MONITORS.own else {}
    needed = set.intersection(*(each.needed for each in cars.values())) if cars else set()
    used = set().union(*(each.needed | each.optional for each in cars.values())) - needed
    read: set[str] = set()
    try:
        reading = _reading(variant, car, monitor.rate)
        obstacle, read = "", reading.needed | reading.optional
        used &= read
    except TierodError as error:
        obstacle = str(error)
    absent = [name for name in QUANTITIES if name not in car]
    required = monitor.needing(variant).required
    return Lacking(
        obstacle,
        tuple(name for name in absent if name in needed),
        tuple(name for name in absent if name in used),
        _guessed(car, read),
        _unmapped(required, car),
        _unmapped(tuple(name for name in monitor.optional if name not in required), car),
    )


def _guessed(car: Vehicle, read: set[str]) -> tuple[str, ...]:
    """Parameters that are read and that the vehicle file gives as guesses, the least certain first."""
    known = [each for name, each in car.parameters.items() if name in read and may_move(name)]
    guessed = [each for each in known if is_guess(each, GUESSED)]
    ordered = sorted(guessed, key=lambda each: -(each.standard_deviation or 0.0) / max(abs(each.value), 1e-9))
    return tuple(each.name for each in ordered)


def _unmapped(names: tuple[str, ...], car: Vehicle) -> tuple[str, ...] | None:
    """Signals for which the channel map names neither a column nor the ingredients of a derivation."""
    if car.channel_map is None:
        return None
    mapped = load_channel_map(car.channel_map).entries

    def there(name: str) -> bool:
        return name in mapped or (name in RECIPES and all(each in mapped for each in RECIPES[name].needs))

    return tuple(name for name in names if not there(name))
