"""Fault-free drives of virtual cars at and over the limit of grip, and what the monitor of a rolling car names on them.

As a script: `python at_the_limit.py SEED` prints false declarations. Development used seed 41.
"""

import math
import sys
from dataclasses import replace

from monitors.condition.motion_alone import MOTION, SETS, declared, judged
from tierod.core.recording import Recording
from tierod.monitors.condition.definition import rolling_monitor
from tierod_lab.ground.courses.course import Adhesion, During
from tierod_lab.ground.courses.manoeuvres import AngleRamp, SineSteer, StepSteer
from tierod_lab.ground.run import run
from tierod_lab.papers.own_car.cars import drawn

CARS = 7
ADHESION = (1.0, 0.6, 0.35, 0.2)
BEFORE = 8.0
"""Straight on before each test [s]."""


def courses(ratio):
    """Tests by name for a car of so many degrees at the steering wheel per degree at the road wheels."""
    scale = math.radians(ratio / 15.0)
    ice = (Adhesion(window=During(start=11.0, end=14.0), left=0.15, right=0.15),)
    found = {"ice in a bend": AngleRamp(speed=22.0, angle=80.0 * scale, rate=30.0 * scale, conditions=ice)}
    for grip in ADHESION:
        usual = {"speed": 25.0 if grip > 0.5 else 18.0, "conditions": (Adhesion(left=grip, right=grip),)}
        dwell, slalom = {"frequency": 0.7, "dwell": 0.5}, {"frequency": 0.5, "periods": 6}
        found |= {
            f"dwell {grip}": SineSteer(amplitude=150.0 * scale, **dwell, **usual),
            f"ramp {grip}": AngleRamp(angle=200.0 * scale, rate=math.radians(20.0), **usual),
            f"slalom {grip}": SineSteer(amplitude=90.0 * scale, **slalom, **usual),
            f"step {grip}": StepSteer(angle=-180.0 * scale, rate=math.radians(500.0), hold=4.0, **usual),
        }
    return {name: _placed(course, name) for name, course in found.items()}


def _placed(course, name):
    return replace(course, name=name, settle=BEFORE, rest=8.0)


def driven(car, name, seed):
    """One test of a car: what is on its bus, and the largest sideslip [deg]."""
    made = run(car.block, courses(1.0 / car.true["steering_ratio"])[name], seed=seed).recording
    slip = abs(made["truth_sideslip_angle"].values).max()
    return Recording({each: made[each] for each in MOTION}), math.degrees(slip)


def _all(seed):
    runs = wrong = 0
    for number in range(CARS):
        car = drawn(number, seed)
        banks = {"brochure": rolling_monitor(car.brochure), "true": rolling_monitor(car.true)}
        for name in courses(15.0):
            part, slip = driven(car, name, 100 * seed + number)
            for file, bank in banks.items():
                for sensors in ("all", "without accelerations", "without front wheels"):
                    found = declared(judged(bank, part, SETS[sensors]))
                    runs, wrong = runs + 1, wrong + bool(found)
                    if found:
                        print(f"{car.name}, {name}, {slip:.0f} degrees, {file}, {sensors}: {sorted(found)}", flush=True)
    print(f"{wrong} of {runs} runs with a fault named")


if __name__ == "__main__":
    _all(int(sys.argv[1]))
