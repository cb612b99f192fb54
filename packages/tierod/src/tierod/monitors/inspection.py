"""Inspection of a recording: its channels, their quality, and the monitors that could judge it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.core.errors import TierodError
from tierod.core.findings import ChannelQuality
from tierod.core.recording import Recording
from tierod.core.units import COUNT
from tierod.io.derive import complete
from tierod.io.formats import plain
from tierod.io.quality import channel_quality
from tierod.io.readers import ChannelMap, read
from tierod.io.readings import noise_warnings
from tierod.io.signs import sign_warnings, turn_warnings
from tierod.monitors.harness.acceptance import Readiness, refusals
from tierod.monitors.harness.named_vehicle import vehicle_named_in
from tierod.monitors.harness.session import Monitor
from tierod.monitors.registry import MONITORS
from tierod.vehicles import Vehicle, load
from tierod.vehicles.classes import typical
from tierod.vehicles.reading import read_by


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
