"""Inspection of a recording and of a vehicle: the monitors that could judge it, and what they lack."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tierod.core.errors import TierodError
from tierod.core.findings import ChannelQuality
from tierod.core.recording import Recording
from tierod.core.units import COUNT
from tierod.io.derive import RECIPES, complete
from tierod.io.formats import plain
from tierod.io.quality import channel_quality
from tierod.io.readers import ChannelMap, load_channel_map, read
from tierod.io.readings import noise_warnings
from tierod.io.signs import sign_warnings, turn_warnings
from tierod.monitors.acceptance import Readiness, refusals, vehicle_named_in
from tierod.monitors.registry import MONITORS
from tierod.monitors.session import Monitor, Variant
from tierod.vehicles import QUANTITIES, Parameter, Vehicle, load, shipped
from tierod.vehicles.classes import is_guess, may_move, typical
from tierod.vehicles.vehicle import Parameters, read_by

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


@dataclass(frozen=True)
class Inspection:
    """Result of the inspection of a recording."""

    recording: Recording  # the recording with all signals that can be derived
    # vehicle whose parameters would be used; None where none is given or named, so that only the signals were checked
    vehicle: Vehicle | None
    quality: tuple[ChannelQuality, ...]  # quality of each channel
    warnings: tuple[str, ...]  # warnings of the reader, and on signs and turns that contradict each other
    monitors: tuple[Readiness, ...]  # for each monitor, whether it could judge the recording

    def document(self) -> dict[str, Any]:
        """Content as data for JSON."""
        return {
            "schema": "tierod.inspection/2",
            "metadata": plain(self.recording.metadata),
            "start": self.recording.span[0],
            "end": self.recording.span[1],
            "channels": [
                dataclasses.asdict(row) | {"source": self.recording.channels[row.name].source} for row in self.quality
            ],
            "warnings": list(self.warnings),
            "monitors": [
                {
                    "name": each.monitor.name,
                    "can_run": bool(each.variants),
                    "condition": each.monitor.condition,
                    "obstacles": list(each.obstacles),
                    "variants": [{"name": name, "obstacle": reason} for name, reason in each.reasons.items()],
                }
                for each in self.monitors
            ],
        }


def inspect(
    source: Recording | str | Path,
    vehicle: Vehicle | str | Path | None = None,
    *,
    dbc: str | Path | Sequence[str | Path] | None = None,
    channel_map: str | Path | ChannelMap | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Inspection:
    """Inspect a recording: its channels with their quality, and the missing requirements of each monitor.

    Args:
        source: a recording, or the path of one
        vehicle: parameter set, its name, or the path of its file; None takes the one that the recording names
        dbc: path(s) of CAN databases; the vehicle's own where not given
        channel_map: path of a channel map; the vehicle's own where not given
        progress: called with 1 once the recording is read

    Raises:
        InputError: the recording cannot be read
        ParameterError: no such vehicle
    """
    car = vehicle if isinstance(vehicle, Vehicle) or vehicle is None else load(vehicle)
    if isinstance(source, Recording):
        whole = source
    else:
        databases, used = read_by(car, dbc, channel_map)
        whole = read(source, dbc=databases, channel_map=used)
    progress(1.0)
    car = car or _named_in(whole)
    monitors = tuple(Readiness(each, _reasons(each, car, whole)) for each in MONITORS.values())
    whole = complete(whole)
    quality = tuple(channel_quality(channel) for channel in whole.channels.values())
    warnings = (*whole.warnings, *sign_warnings(whole), *turn_warnings(whole), *noise_warnings(whole))
    return Inspection(whole, car, quality, warnings, monitors)


def _reasons(monitor: Monitor, car: Vehicle | None, whole: Recording) -> Mapping[str, str]:
    """Reason, by variant, why a diagnosis would refuse the recording; without a vehicle, with a typical car."""
    if car is not None:
        return refusals(monitor, car, whole)
    without = refusals(monitor, None, whole)
    if monitor.condition:
        return without
    typically = refusals(monitor, _typical_car(whole), whole)
    # If no variant can run with the typical car, its reasons say nothing about the recording.
    said = not all(LACKING in reason for reason in typically.values())
    return {name: reason or (typically[name] if said else "") for name, reason in without.items()}


LACKING = "cannot run as"  # Part of a message that refuses a vehicle, not a recording


def _typical_car(whole: Recording) -> Vehicle:
    """Car with all parameters of a class of cars and of a motor bench; torques in counts if the recording has any."""
    counts = any(channel.unit == COUNT for channel in whole.channels.values())
    bench = load("motor-bench").parameters
    return dataclasses.replace(
        load("midsize-eps"),
        name="of a typical car",
        torque_unit=COUNT if counts else "N*m",
        parameters={**bench, **typical("midsize")},
    )


def _named_in(whole: Recording) -> Vehicle | None:
    try:
        return load(vehicle_named_in(whole, None, None))
    except TierodError:
        return None
