"""Faults of the motion sensors of virtual cars, and hard starts and stops: what the monitor of a rolling car names.

As a script: `python motion_alone.py SEED EXCERPTS [SENSORS]` prints a table, `... hard SEED DRIVES` false declarations.
Development used seeds below 100.
"""

import math
import sys
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.monitors.condition.courses import FAULT
from tierod.monitors.condition.definition import rolling_monitor
from tierod.monitors.condition.kinds import KINDS
from tierod.monitors.condition.limits import aligned
from tierod.monitors.condition.signals import ACCELERATIONS, ALL_WHEELS, FRONT_WHEELS, OF_CARS, ConditionSample
from tierod.vehicles import load
from tierod_lab.ground.cars.catalogue import load as car_of
from tierod_lab.ground.courses import load as course_of
from tierod_lab.ground.courses.roads import Bend, Circuit, Halt, Straight
from tierod_lab.ground.courses.way import Pace
from tierod_lab.ground.faults import injected
from tierod_lab.ground.run import run
from tierod_lab.papers.condition.drives import DRIFT, GAIN, LOSS, NOISE, OFFSET, STUCK, Injected

BEFORE, LASTING, AFTER = 10.0, 10.0, 4.0
"""Of an excerpt: fault-free, with the fault, fault-free again [s]."""
WHEEL = {LOSS: math.nan, OFFSET: 2.0, GAIN: 1.3, STUCK: math.nan, DRIFT: 0.2, NOISE: 1.0}
SIZES = {
    "yaw_rate": {LOSS: math.nan, OFFSET: 0.1, GAIN: 1.5, STUCK: math.nan, DRIFT: 0.05, NOISE: 0.1},
    "steering_wheel_angle": {LOSS: math.nan, OFFSET: 0.5, GAIN: 1.5, STUCK: math.nan, DRIFT: 0.2, NOISE: 0.5},
}
"""Magnitude of each kind in the unit of the signal; of wheels else."""
SHOWS = {"yaw_rate": 0.06, "steering_wheel_angle": 0.35}
"""Deviation from which on a fault shows, in the unit of the signal."""
SHOWS_WHEEL = 0.5
MOTION = (*OF_CARS, *ACCELERATIONS)
SETS = {
    "all": MOTION,
    "without accelerations": OF_CARS,
    "without front wheels": tuple(name for name in MOTION if name not in FRONT_WHEELS),
    "four wheel speeds alone": ALL_WHEELS,
}


class Outcome(NamedTuple):
    """Of one injected fault; times since its beginning [s]."""

    shows: float
    onset: float
    declared: float
    kind: str
    error: float
    wrong: frozenset[str]


@lru_cache(maxsize=4)
def drive(seed, seconds=240.0, course="mixed"):
    """A drive of a virtual compact SUV."""
    made = run(car_of("rav4-like").block, replace(course_of(course), seed=seed), seconds, seed).recording
    return Recording({name: made[name] for name in MOTION})


@lru_cache(maxsize=4)
def hard(seed, driven, seconds=300.0):
    """Starts and stops that are as hard as tyres allow without spinning or locking, with bends between them."""
    chance, parts, halts, place = np.random.default_rng(seed), [], [], 0.0
    while place < 3000.0:
        place += (length := chance.uniform(60.0, 200.0))
        radius, turn = chance.uniform(12.0, 80.0), chance.choice([-1.0, 1.0]) * chance.uniform(0.5, 1.6)
        if chance.random() < 0.5 and place < 2200.0:
            halts.append(Halt(place - 10.0, chance.uniform(1.0, 3.0)))
        parts += [Straight(length), Bend(radius, turn)]
        place += radius * abs(turn) + 8.0
    pace = Pace(chance.uniform(2.0, 3.5), chance.uniform(3.0, 4.8), 0.25)
    across = chance.uniform(2.5, 4.0)
    course = Circuit(
        seed=seed,
        pace=pace,
        sections=tuple(parts),
        time=seconds,
        speed=25.0,
        lateral_acceleration=across,
        halts=tuple(halts),
    )
    car = car_of("rav4-like").block
    share, force = (1.0, 6000.0) if driven == "front" else (0.0, 7500.0)
    car = replace(car, powertrain=replace(car.powertrain, front_share=share, greatest_drive_force=force))
    made = run(car, course, seconds, seed).recording
    return Recording({name: made[name] for name in MOTION})


def with_slip(part, share, driven):
    """More slip: of the driven axle under its drive, of all wheels under brakes, up to 1.2 times a share."""
    along, found = part["longitudinal_acceleration"], []
    smooth = np.convolve(along.values, np.ones(15) / 15.0, "same")
    for name in (each for each in ALL_WHEELS if each in part):
        read, front = part[name], name in FRONT_WHEELS
        pushed = np.interp(read.time, along.time, smooth)
        braked = (1.2 if front else 0.8) * np.clip(pushed / 8.0, -1.2, 0.0)
        slip = share * np.where(pushed > 0.0, np.clip(pushed / 4.0, 0.0, 1.2) * (front == (driven == "front")), braked)
        found.append(Channel(name, read.time, read.values * (1.0 + slip), read.unit))
    return part.with_channels(found)


def excerpts(made, count, seed):
    """Parts of a drive in which the car moves, at times drawn from the seed."""
    chance, time = np.random.default_rng(seed), made[OF_CARS[0]].time
    starts = chance.uniform(time[0], time[-1] - BEFORE - LASTING - AFTER, 50 * count)
    parts = [made.slice(start, start + BEFORE + LASTING + AFTER) for start in starts.tolist()]
    return [part for part in parts if part[OF_CARS[0]].values.min() > 2.0][:count]


def judged(bank, part, only=MOTION):
    """What the monitor states over a recording of which it gets some signals only."""
    samples = aligned(part)
    samples[:, [place for place, name in enumerate(ConditionSample._fields) if name not in only]] = np.nan
    return scan(bank, samples)


def declared(result):
    """The sensors that are declared anywhere."""
    return {name for name in OF_CARS if (result[f"statements.{name}.status"] == FAULT).any()}


def outcome(bank, part, sensor, kind, only=MOTION):
    """A fault that begins `BEFORE` and lasts `LASTING` seconds, judged while it lasts."""
    size, first = SIZES.get(sensor, WHEEL)[kind], part[OF_CARS[0]].time[0]
    fault = Injected(sensor, kind, size, first + BEFORE, first + BEFORE + LASTING)
    wrong = injected(part, [fault.fault])
    result, inside = judged(bank, wrong, only), slice(round(BEFORE * 100.0), round((BEFORE + LASTING) * 100.0))
    off = np.abs(aligned(wrong) - aligned(part))[inside, ConditionSample._fields.index(sensor)]
    shows = np.flatnonzero(np.nan_to_num(off) > SHOWS.get(sensor, SHOWS_WHEEL))
    said = np.flatnonzero(result[f"statements.{sensor}.status"][inside] == FAULT)
    last = said[-1] if len(said) else 0
    number, magnitude = (result[f"statements.{sensor}.{each}"][inside][last] for each in ("kind", "magnitude"))
    return Outcome(
        len(shows) / 100.0,
        shows[0] / 100.0 if len(shows) else math.inf,
        said[0] / 100.0 if len(said) else math.inf,
        KINDS[int(number) - 1] if len(said) and number > 0.5 else "",
        abs(magnitude / size - 1.0) if size == size else math.nan,
        frozenset(declared(result) - {sensor}),
    )


def _table(seed, count, only):
    bank, parts = rolling_monitor(load("rav4")), excerpts(drive(seed), count, seed)
    for sensor in (name for name in OF_CARS if name in only):
        for kind in WHEEL:
            rows = [outcome(bank, part, sensor, kind, only) for part in parts]
            shown = [row for row in rows if row.shows > 1.0]
            right = [row for row in shown if row.kind == kind]
            late = sorted(row.declared - row.onset for row in shown) or [math.nan]
            print(
                f"{sensor:24s} {kind:7s} shown {len(shown):3d} named {sum(row.declared < LASTING for row in shown):3d}"
                f" right kind {len(right):3d} others {sum(bool(row.wrong) for row in rows)}"
                f" after onset {late[len(late) // 2]:6.2f} {late[-1]:6.2f} s"
                f" within 15 % {sum(not row.error > 0.15 for row in right):3d}",
                flush=True,
            )


def _hard(seed, count):
    bank, runs = rolling_monitor(load("rav4")), 0
    for number in range(seed, seed + count):
        for driven in ("front", "rear"):
            for share in (0.0, 0.03, 0.1):
                part = with_slip(hard(number, driven), share, driven)
                for name, only in SETS.items():
                    runs += 1
                    if found := declared(judged(bank, part, only)):
                        print(number, driven, share, name, sorted(found), flush=True)
    print(f"{runs} runs of 300 s, {runs / 12.0:.1f} h")


if __name__ == "__main__":
    if sys.argv[1] == "hard":
        _hard(int(sys.argv[2]), int(sys.argv[3]))
    else:
        _table(int(sys.argv[1]), int(sys.argv[2]), SETS[sys.argv[3] if len(sys.argv) > 3 else "all"])
