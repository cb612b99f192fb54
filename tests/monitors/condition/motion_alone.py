"""Drives of virtual cars with motion sensors alone, faults of these sensors, and what the monitor declares."""

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.monitors.condition.courses import FAULT
from tierod.monitors.condition.kinds import KINDS
from tierod.monitors.condition.limits import aligned
from tierod.monitors.condition.signals import ACCELERATIONS, ALL_WHEELS, FRONT_WHEELS, OF_CARS, ConditionSample
from tierod_lab.ground.cars.catalogue import load as car_of
from tierod_lab.ground.courses import load as course_of
from tierod_lab.ground.courses.course import Adhesion, During
from tierod_lab.ground.courses.manoeuvres import AngleRamp, SineSteer, StepSteer
from tierod_lab.ground.courses.roads import Bend, Circuit, Halt, Straight
from tierod_lab.ground.courses.way import Pace
from tierod_lab.ground.faults import injected
from tierod_lab.ground.run import run
from tierod_lab.papers.condition.drives import DRIFT, OFFSET, STUCK, Injected

BEFORE, LASTING, AFTER = 10.0, 10.0, 4.0
"""Of an excerpt: fault-free, with the fault, fault-free again [s]."""
WHEEL = {OFFSET: 2.0, STUCK: math.nan, DRIFT: 0.2}
SHOWS_WHEEL = 0.5
"""Sizes of faults of a wheel, and deviation from which on one shows [m/s]."""
MOTION = (*OF_CARS, *ACCELERATIONS)
SETS = {
    "all": MOTION,
    "without accelerations": OF_CARS,
    "without front wheels": tuple(name for name in MOTION if name not in FRONT_WHEELS),
    "four wheel speeds alone": ALL_WHEELS,
}


@lru_cache(maxsize=4)
def drive(seed, seconds=240.0, course="mixed"):
    """A drive of a virtual compact SUV."""
    made = run(car_of("rav4-like").block, replace(course_of(course), seed=seed), seconds, seed).recording
    return Recording({name: made[name] for name in MOTION})


@lru_cache(maxsize=4)
def hard(seed, driven, seconds):
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
    usual = {"seed": seed, "pace": pace, "sections": tuple(parts), "halts": tuple(halts), "time": seconds}
    course = Circuit(speed=25.0, lateral_acceleration=chance.uniform(2.5, 4.0), **usual)
    car = car_of("rav4-like").block
    share, force = (1.0, 6000.0) if driven == "front" else (0.0, 7500.0)
    car = replace(car, powertrain=replace(car.powertrain, front_share=share, greatest_drive_force=force))
    made = run(car, course, seconds, seed).recording
    return Recording({name: made[name] for name in MOTION})


def with_slip(part, share, driven):
    """More slip: of the driven axle under its drive, of all wheels under brakes, up to 1.2 times a share."""
    along, found = part["longitudinal_acceleration"], []
    smooth = np.convolve(along.values, np.ones(15) / 15.0, "same")
    for name in ALL_WHEELS:
        read, front = part[name], name in FRONT_WHEELS
        pushed = np.interp(read.time, along.time, smooth)
        braked = (1.2 if front else 0.8) * np.clip(pushed / 8.0, -1.2, 0.0)
        slip = share * np.where(pushed > 0.0, np.clip(pushed / 4.0, 0.0, 1.2) * (front == (driven == "front")), braked)
        found.append(Channel(name, read.time, read.values * (1.0 + slip), read.unit))
    return part.with_channels(found)


def courses(ratio):
    """Tests at the limit of grip, by name, for a car of so many degrees at the steering wheel per degree of steer."""
    scale = math.radians(ratio / 15.0)
    ice = (Adhesion(window=During(start=11.0, end=14.0), left=0.15, right=0.15),)

    def grip(value):
        return {"speed": 25.0 if value > 0.5 else 18.0, "conditions": (Adhesion(left=value, right=value),)}

    found = {
        "ice in a bend": AngleRamp(speed=22.0, angle=80.0 * scale, rate=30.0 * scale, conditions=ice),
        "dwell 0.6": SineSteer(amplitude=150.0 * scale, frequency=0.7, dwell=0.5, **grip(0.6)),
        "slalom 0.35": SineSteer(amplitude=90.0 * scale, frequency=0.5, periods=6, **grip(0.35)),
        "step 1.0": StepSteer(angle=-180.0 * scale, rate=math.radians(500.0), hold=4.0, **grip(1.0)),
    }
    return {name: replace(course, name=name, settle=8.0, rest=8.0) for name, course in found.items()}


def at_the_limit(car, name, seed):
    """One test of a car: what is on its bus, and the largest sideslip [deg]."""
    made = run(car.block, courses(1.0 / car.true["steering_ratio"])[name], seed=seed).recording
    slip = abs(made["truth_sideslip_angle"].values).max()
    return Recording({each: made[each] for each in MOTION}), math.degrees(slip)


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


class Outcome(NamedTuple):
    """Of one injected fault; times since its beginning [s]."""

    shows: float
    onset: float
    declared: float
    kind: str
    error: float
    wrong: set[str]


def outcome(bank, part, sensor, kind, only=MOTION):
    """A fault of a wheel that begins `BEFORE` and lasts `LASTING` seconds, judged while it lasts."""
    size, first = WHEEL[kind], part[OF_CARS[0]].time[0]
    wrong = injected(part, [Injected(sensor, kind, size, first + BEFORE, first + BEFORE + LASTING).fault])
    result, inside = judged(bank, wrong, only), slice(round(BEFORE * 100.0), round((BEFORE + LASTING) * 100.0))
    off = np.abs(aligned(wrong) - aligned(part))[inside, ConditionSample._fields.index(sensor)]
    shows = np.flatnonzero(np.nan_to_num(off) > SHOWS_WHEEL)
    said = np.flatnonzero(result[f"statements.{sensor}.status"][inside] == FAULT)
    last = said[-1] if len(said) else 0
    number, magnitude = (result[f"statements.{sensor}.{each}"][inside][last] for each in ("kind", "magnitude"))
    return Outcome(
        len(shows) / 100.0,
        shows[0] / 100.0 if len(shows) else math.inf,
        said[0] / 100.0 if len(said) else math.inf,
        KINDS[int(number) - 1] if len(said) and number > 0.5 else "",
        abs(magnitude / size - 1.0) if size == size else math.nan,
        declared(result) - {sensor},
    )
