"""Recordings of the semantic attack: for every monitor fault-free and faulty ones, simulated once per process."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod.io.readers import read
from tierod.io.writers import write
from tierod_lab.ground import FrictionCourse, SensorSet, drive, lock_to_lock
from tierod_lab.ground.cars.catalogue import load as load_car
from tierod_lab.ground.courses import load as load_course
from tierod_lab.ground.faults import Always, AtTime, Fault
from tierod_lab.ground.faults import load as load_fault
from tierod_lab.ground.faults.behaviours import Gain, Offset
from tierod_lab.ground.run import run as run_car
from tierod_lab.ground.scenarios import load as load_scenario


@dataclass(frozen=True)
class Drive:
    """One recording, and how it is judged."""

    monitor: str
    name: str
    vehicle: str
    faulty: bool
    make: Callable[[int], Recording]
    variant: str | None = None


def _scenario(name: str, seconds: float | None = None, *faults: Fault) -> Callable[[int], Recording]:
    """A shipped scenario with another seed, and with other faults."""

    def make(seed: int) -> Recording:
        scenario = dataclasses.replace(load_scenario(name), faults=()).with_run(seconds, seed)
        return dataclasses.replace(scenario, faults=faults).run().recording

    return make


def _shipped(name: str, start: float | None = None) -> Fault:
    """A shipped fault, from its own time or another [s] on."""
    fault = load_fault(name).fault
    return fault if start is None else dataclasses.replace(fault, trigger=AtTime(start))


def _friction(after: float) -> Callable[[int], Recording]:
    """The mixed drive; the friction steps half-way."""
    return lambda seed: drive(minutes=13.0, friction=FrictionCourse.step(4.0, after, 390.0), seed=seed)


def _test_car(*faults: Fault) -> Callable[[int], Recording]:
    """The car steered by wire in its test of sideslip observers, read as on a test car."""

    def make(seed: int) -> Recording:
        course = load_course("sideslip-test")
        return run_car(load_car("steer-by-wire").block, course, None, seed, SensorSet.bench(), faults).recording

    return make


def _active_front(*faults: Fault) -> Callable[[int], Recording]:
    """Slalom with active front steering: its motor turns all the time."""

    def make(seed: int) -> Recording:
        car = load_car("active-front-steering").block
        return run_car(car, load_course("slalom"), 12.0, seed, None, faults).recording

    return make


def _motor_bench(degrees: float = 0.0) -> Callable[[int], Recording]:
    """The bench under control of its angle; the sensor's zero moves by electrical degrees in the fifth second."""

    def make(seed: int) -> Recording:
        from monitors.motor_angle.monitored import recording
        from tierod_lab.papers.motor_angle import bench

        return recording(bench.drive(seed, 8.0, bench.offset(degrees) if degrees else None, 5.0).samples)

    return make


_BAR = Fault(element="driver_torque", behaviour=Gain(1.5), trigger=AtTime(5.0))
"""A torsion bar that a driver torque of half as much again belongs to: vehicle file and recording do not fit."""

_TURNING = Fault(element="sensor.yaw_rate", behaviour=Offset(0.03), trigger=Always())
"""A yaw rate that was never calibrated."""

DRIVES: tuple[Drive, ...] = (
    Drive("friction", "healthy", "midsize-eps", False, _friction(4.0)),
    Drive("friction", "step", "midsize-eps", True, _friction(8.0)),
    Drive("hysteresis", "hoist", "midsize-eps", False, lambda seed: lock_to_lock(4.0, hoist=True, seed=seed), "hoist"),
    Drive("hysteresis", "worn", "midsize-eps", True, lambda seed: lock_to_lock(8.5, hoist=True, seed=seed), "hoist"),
    Drive("driver-torque", "bench", "column-bench", False, _scenario("column-bench-hands", 40.0)),
    Drive("driver-torque", "road", "midsize-eps", False, _scenario("hands-off")),
    Drive("driver-torque", "bench-gain", "column-bench", True, _scenario("column-bench-hands", 40.0, _BAR)),
    Drive("driver-torque", "road-gain", "midsize-eps", True, _scenario("hands-off", None, _BAR)),
    Drive("sideslip", "test", "steer-by-wire", False, _test_car(), "two-stage-kalman"),
    Drive("sideslip", "town", "midsize-eps", False, _scenario("mixed-drive-healthy", 120.0)),
    Drive("sideslip", "test-offset", "steer-by-wire", True, _test_car(_TURNING), "two-stage-kalman"),
    Drive("sideslip", "town-offset", "midsize-eps", True, _scenario("mixed-drive-healthy", 120.0, _TURNING)),
    Drive("motor-angle", "bench", "motor-bench", False, _motor_bench()),
    Drive("motor-angle", "car", "active-front-steering", False, _active_front()),
    Drive("motor-angle", "bench-offset", "motor-bench", True, _motor_bench(10.0)),
    Drive(
        "motor-angle", "car-offset", "active-front-steering", True, _active_front(_shipped("motor-angle-offset", 5.0))
    ),
    Drive("condition", "round", "smartload", False, _scenario("demonstrator-healthy", 100.0)),
    Drive(
        "condition",
        "yaw-rate",
        "smartload",
        True,
        _scenario("demonstrator-healthy", 100.0, _shipped("yaw-rate-offset")),
    ),
    Drive(
        "condition",
        "drive",
        "smartload",
        True,
        _scenario("demonstrator-healthy", 100.0, _shipped("drive-motor-left-loss")),
    ),
)
"""Every recording that is attacked."""

_KEPT: dict[tuple[Path, str, int], Recording] = {}


def recorded(each: Drive, seed: int, folder: Path) -> Recording:
    """The recording without truth: simulated once, then read from a folder, then from memory."""
    name = f"{each.monitor}-{each.name}-{seed}"
    key = (folder, name, seed)
    if key not in _KEPT:
        path = folder / f"{name}.parquet"
        if not path.exists():
            whole = each.make(seed)
            measured = {n: channel for n, channel in whole.channels.items() if not n.startswith("truth_")}
            write(Recording(measured), path)
        _KEPT[key] = read(path)
    return _KEPT[key]


STUCK_FROM = 1.0 / 3.0
"""Share of the recording after which a stuck signal stands still, and one that creeps begins: before any fault of the
recordings can be judged."""

CLIPPED_AT = 0.8
"""Quantile of the magnitude at which a clipped signal ends."""


def _stuck(channel: Channel, random: np.random.Generator) -> Channel:
    at = int(STUCK_FROM * len(channel.values))
    values = channel.values.copy()
    values[at:] = values[at]
    return replace(channel, values=values)


def _times(factor: float) -> Callable[[Channel, np.random.Generator], Channel]:
    return lambda channel, random: replace(channel, values=factor * channel.values)


def _offset(channel: Channel, random: np.random.Generator) -> Channel:
    return replace(channel, values=channel.values + np.nanstd(channel.values))


def _growth(channel: Channel) -> np.ndarray:
    """Share of a change that grows evenly from `STUCK_FROM` to the end."""
    share = np.linspace(0.0, 1.0, len(channel.values))
    return np.clip((share - STUCK_FROM) / (1.0 - STUCK_FROM), 0.0, 1.0)


def _drifting(channel: Channel, random: np.random.Generator) -> Channel:
    return replace(channel, values=channel.values + 2.0 * np.nanstd(channel.values) * _growth(channel))


def _growing(channel: Channel, random: np.random.Generator) -> Channel:
    return replace(channel, values=channel.values * (1.0 + _growth(channel)))


def _late(seconds: float) -> Callable[[Channel, np.random.Generator], Channel]:
    """The same values so much later; what was before the recording is taken as its first value."""

    def change(channel: Channel, random: np.random.Generator) -> Channel:
        before = np.searchsorted(channel.time, channel.time - seconds + 1e-9, side="right") - 1
        return replace(channel, values=channel.values[np.maximum(before, 0)])

    return change


def _noisy(channel: Channel, random: np.random.Generator) -> Channel:
    noise = np.nanstd(channel.values) * random.normal(size=len(channel.values))
    return replace(channel, values=channel.values + noise)


def _clipped(channel: Channel, random: np.random.Generator) -> Channel:
    most = np.nanquantile(np.abs(channel.values), CLIPPED_AT)
    return replace(channel, values=np.clip(channel.values, -most, most))


def _missing(channel: Channel, random: np.random.Generator) -> Channel:
    return replace(channel, values=np.full(len(channel.values), np.nan))


CHANGES: dict[str, Callable[[Channel, np.random.Generator], Channel]] = {
    "stuck": _stuck,
    "sign": _times(-1.0),
    "x2": _times(2.0),
    "x0.5": _times(0.5),
    "offset": _offset,
    "drift to two deviations": _drifting,
    "gain that grows to 2": _growing,
    "late .1 s": _late(0.1),
    "late .5 s": _late(0.5),
    "noise": _noisy,
    "clip": _clipped,
    "missing": _missing,
}
"""Changes of one channel by name."""

DROPPED = "dropped"
"""The column is not there."""

SWAP = "swap with "
"""Begins the name of a change that gives a signal the samples of another one, and that one its own."""


def changes(names: tuple[str, ...], signal: str) -> tuple[str, ...]:
    """Every change of a signal; each pair of signals is swapped once."""
    others = names[names.index(signal) + 1 :]
    return (*CHANGES, DROPPED, *(f"{SWAP}{other}" for other in others))


def changed(recording: Recording, signal: str, change: str, seed: int) -> Recording:
    """The recording with one change."""
    if change == DROPPED:
        return replace(recording, channels={n: c for n, c in recording.channels.items() if n != signal})
    channel = recording[signal]
    if change.startswith(SWAP):
        other = recording[change.removeprefix(SWAP)]
        pair = (
            replace(channel, time=other.time, values=other.values),
            replace(other, time=channel.time, values=channel.values),
        )
        return recording.with_channels(pair)
    return recording.with_channels([CHANGES[change](channel, np.random.default_rng(seed))])


def touched(signal: str, change: str) -> tuple[str, ...]:
    """The signals that a change changes."""
    return (signal, change.removeprefix(SWAP)) if change.startswith(SWAP) else (signal,)
