"""Print verdicts of the sideslip monitor on faulty signals and with files of other cars: `... SEED [MINUTES]`.

The tolerances were chosen on seeds 31, 32 and 33; report others. Real cars are included if `TIEROD_DATA` has them.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.errors import TierodError
from tierod.core.recording import Recording
from tierod.papers.own_car import real
from tierod.papers.own_car.cars import BASES, drawn
from tierod.papers.own_car.judging import ON_BUS, driven, over
from tierod.vehicles import Vehicle, load

TRUTHS = ("sideslip_angle", "truth_sideslip_angle")
STEERING = ("steering_wheel_angle", "road_wheel_angle")
SIGNALS = (("yaw_rate",), ("vehicle_speed",), STEERING, ("lateral_acceleration",))
OFFSETS = {
    "yaw_rate": math.radians(2.0),
    "vehicle_speed": 2.0,
    "steering_wheel_angle": math.radians(10.0),
    "road_wheel_angle": math.radians(10.0 / 15.0),
    "lateral_acceleration": 0.5,
}
CHANGES = ("times 0.8", "times 1.25", "offset", "late by 200 ms", "frozen for 20 s", "missing")
HELD = 0.8
"""Share of the true values in the 95 % band below which an unobjected estimate counts as wrong."""


class Car(NamedTuple):
    """A car with its own vehicle file, and a recording with true values."""

    name: str
    vehicle: Vehicle
    recording: Recording


def cars(seed: int, minutes: float) -> Iterator[Car]:
    """Real cars with their vehicle files, and one virtual car of each kind with data-sheet values."""
    for known in real.KNOWN:
        recording = real.recording_of(known)
        if recording is not None:
            yield Car(known.vehicle, load(known.vehicle), recording)
    for number in range(len(BASES)):
        car = drawn(number, seed)
        whole = driven(car, minutes, 1000 * seed + number)
        kept = {name: whole[name] for name in (*ON_BUS, TRUTHS[1]) if name in whole}
        yield Car(car.name, car.brochure, Recording(kept))


def changed(recording: Recording, names: tuple[str, ...], change: str) -> Recording:
    """The recording with one kind of change applied to the named signals."""
    channels = dict(recording.channels)
    begin, end = recording.span
    for name in names:
        if name not in channels:
            continue
        each = channels[name]
        if change == "missing":
            del channels[name]
        elif change.startswith("late"):
            channels[name] = replace(each, time=each.time + 0.2)
        elif change == "offset":
            channels[name] = replace(each, values=each.values + OFFSETS[name])
        elif change.startswith("frozen"):
            first = begin + 0.45 * (end - begin)
            at = np.flatnonzero((each.time >= first) & (each.time < first + min(20.0, 0.3 * (end - begin))))
            values = each.values.copy()
            values[at] = values[at[:1]]
            channels[name] = replace(each, values=values)
        else:
            channels[name] = replace(each, values=float(change.split()[1]) * each.values)
    return Recording(channels, recording.metadata)


def judged(vehicle: Vehicle, recording: Recording) -> tuple[str, float]:
    """Verdict on the recording without its true values, and the share of these in the 95 % band."""
    bare = Recording({n: each for n, each in recording.channels.items() if n not in TRUTHS}, recording.metadata)
    try:
        found = over("sideslip", vehicle, bare, uncertain=True)
    except TierodError:
        return "refused", math.nan
    truth = next((recording[name] for name in TRUTHS if name in recording), None)
    word = str(found.diagnosis.findings[0].status)
    if truth is None or TRUTHS[0] not in found.traces:
        return word, math.nan
    value, deviation = (found.traces[f"{TRUTHS[0]}{end}"] for end in ("", "_standard_deviation"))
    known = np.isfinite(truth.values)
    error = value.values - np.interp(value.time, truth.time[known], truth.values[known], np.nan, np.nan)
    length = value.time[-1] - value.time[0]
    # The filter's convergence at the beginning of the drive is not evaluated.
    settled = value.time > value.time[0] + (20.0 if length > 60.0 else 2.0)
    counted = settled & np.isfinite(error) & np.isfinite(deviation.values)
    if not counted.any():
        return word, math.nan
    return word, float(np.mean(np.abs(error[counted]) <= 1.96 * deviation.values[counted]))


def main() -> None:
    """Print the table."""
    seed, minutes = int(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 4.0
    every = list(cars(seed, minutes))
    cells: dict[str, list[tuple[str, float]]] = {}
    for car in every:
        cells.setdefault("none", []).append(judged(car.vehicle, car.recording))
        for names in SIGNALS:
            for change in CHANGES:
                wrong = judged(car.vehicle, changed(car.recording, names, change))
                cells.setdefault(f"{names[0]} {change}", []).append(wrong)
        for other in every:
            if other is not car:
                # Only the parameters are foreign; the unit of the recorded torques is known.
                foreign = replace(other.vehicle, torque_unit=car.vehicle.torque_unit)
                cells.setdefault("file of another car", []).append(judged(foreign, car.recording))
    print("| change | cells | inconsistent | no value | wrong | least share in the band |\n| --- |" + " ---: |" * 5)
    for change, found in cells.items():
        words = [word for word, _ in found]
        stated = [share for word, share in found if word in ("estimated", "consistent") and math.isfinite(share)]
        other = sum(word not in ("estimated", "consistent", "inconsistent") for word in words)
        least = f"{min(stated):.2f}" if stated else ""
        wrong = sum(share < HELD for share in stated)
        print(f"| {change} | {len(found)} | {words.count('inconsistent')} | {other} | {wrong} | {least} |")


if __name__ == "__main__":
    main()
