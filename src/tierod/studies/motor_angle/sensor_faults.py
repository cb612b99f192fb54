"""Faults of the motor's angle sensor on the bench: what is found, how soon, and how often without a fault."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from tierod.graph import Result, scan
from tierod.monitors.motor_angle.detector import ANGLE_DRIFT, ANGLE_THRESHOLD, MotorAngleMonitor
from tierod.studies.claims import Claim, at_least, at_most, exactly
from tierod.studies.content import Heading, Item, Table
from tierod.studies.motor_angle.fault_drives import FAULTS, RATE, Fault, drive
from tierod.studies.registry import Effort
from tierod.vehicles import load

TEXT = (
    "The bench's motor turns to and fro under control of its angle, up to some 100 rad/s. At a random instant at which "
    "the motor turns fast enough for its currents to tell the angle, a fault begins inside the loop: the current "
    "control reads the wrong sensor, and what it reads is recorded. The delay is that of the first alarm of any test, "
    "with the time in it in which the motor reverses and nothing counts.",
    "Sound drives have resistance, flux and inductance that differ from the vehicle file's: 0.8 to 1.3, 0.94 to 1.02, "
    "and 7 % either way.",
)

FIRST_FAULTY, FIRST_SOUND = 2000, 5000
"""Seeds; those below were used while the tests were made."""

EARLIEST, LATEST, AFTER = 5.5, 7.0, 1.5
"""Of the begin of a fault, and how long it is watched then [s]."""


@dataclass(frozen=True)
class Delays:
    """Delays of one fault, from when it is as large as five degrees; infinite where it was not found.

    Args:
        values: of every trial [ms]
        turning: the same, of time in which the motor turned fast enough [ms]
        first: test that alarmed first -> how often
    """

    values: np.ndarray
    turning: np.ndarray
    first: dict[str, int]

    @property
    def found(self) -> int:
        """Trials in which an alarm came."""
        return int(np.isfinite(self.values).sum())


def items(effort: Effort) -> Iterator[Item]:
    """Delays, coverage and false alarms."""
    yield Heading("Faults of the angle sensor", TEXT)
    trials = 4 if effort.quick else 40
    delays = {fault.name: delays_of_fault(fault, trials) for fault in FAULTS}
    yield _table(delays)
    sound = false_alarms(2 if effort.quick else 30)
    yield from _claims(delays, sound)


@cache
def _begins(seed: int) -> float | None:
    """A random instant at which a drive turns; None where it does not."""
    known = scan(_monitor(), drive(seed, LATEST).samples)["known"]
    turning = np.flatnonzero(known[round(EARLIEST * RATE) :] > 0.5)
    if not len(turning):
        return None
    chosen = np.random.default_rng(seed).choice(turning)
    return EARLIEST + int(chosen / RATE * 1e3) / 1e3


@cache
def _monitor() -> MotorAngleMonitor:
    return MotorAngleMonitor.of_vehicle(load("motor-bench"), 1.0 / RATE)


def delays_of_fault(fault: Fault, trials: int) -> Delays:
    """Delays of a fault that begins while the motor turns.

    Args:
        fault: which
        trials: drives
    """
    values: list[float] = []
    turning: list[float] = []
    first: dict[str, int] = {}
    for seed in range(FIRST_FAULTY, FIRST_FAULTY + trials):
        begin = _begins(seed)
        if begin is None:
            continue
        found = scan(_monitor(), drive(seed, begin + AFTER, fault, begin).samples)
        start = round(begin * RATE)
        alarms = _alarms(found, start)
        if not alarms:
            values.append(np.inf)
            turning.append(np.inf)
            continue
        name = min(alarms, key=lambda each: alarms[each])
        first[name] = first.get(name, 0) + 1
        delay = alarms[name] / RATE - fault.size
        known = found["known"][start + round(fault.size * RATE) : start + alarms[name]]
        values.append(1e3 * delay)
        turning.append(1e3 * min(float(known.sum()) / RATE, delay))
    return Delays(np.array(values), np.array(turning), first)


def _alarms(found: Result, start: int) -> dict[str, int]:
    """Samples from the start to the begin of every alarm."""
    names = [name for name in found.names if name.startswith("alarms.") and (found[name][start:] > 0.5).any()]
    return {name.rsplit(".", 1)[-1]: int(np.argmax(found[name][start:] > 0.5)) for name in names}


@dataclass(frozen=True)
class SoundDrives:
    """What sound drives gave.

    Args:
        hours, turning: of all, and of these with a known angle [h]
        alarms: drives with an alarm of any test
        greatest: residual that counted, electrical [rad]
    """

    hours: float
    turning: float
    alarms: int
    greatest: float


def false_alarms(drives: int, seconds: float = 60.0, first: int = FIRST_SOUND) -> SoundDrives:
    """Sound drives, every one with a motor of its own.

    Args:
        drives: how many
        seconds: of each
        first: seed
    """
    turning, alarms, greatest = 0.0, 0, 0.0
    for seed in range(first, first + drives):
        random = np.random.default_rng([seed, 11])
        observer = _monitor().observer
        p = observer.parameters
        other = replace(
            p,
            motor_resistance=p.motor_resistance / random.uniform(0.8, 1.3),
            motor_flux=p.motor_flux / random.uniform(0.94, 1.02),
            motor_inductance=p.motor_inductance * random.uniform(0.93, 1.07),
        )
        found = scan(replace(_monitor(), observer=replace(observer, parameters=other)), drive(seed, seconds).samples)
        turning += float(found["known"].sum()) / RATE / 3600.0
        alarms += bool(_alarms(found, 0))
        counts = found["counts"] > 0.5
        greatest = max(greatest, float(np.abs(found["residual"][counts]).max(initial=0.0)))
    return SoundDrives(drives * seconds / 3600.0, turning, alarms, greatest)


def _table(delays: dict[str, Delays]) -> Table:
    header = ("fault", "found", "median [ms]", "95 % [ms]", "worst [ms]", "95 %, turning [ms]", "first alarm of")
    rows = tuple(
        (
            name,
            f"{each.found} of {len(each.values)}",
            *(f"{_quantile(each.values, q):.0f}" for q in (0.5, 0.95, 1.0)),
            f"{_quantile(each.turning, 0.95):.0f}",
            ", ".join(f"{test.replace('_', ' ')} {count}" for test, count in each.first.items()),
        )
        for name, each in delays.items()
    )
    note = (
        "A delay below zero: found before a drift had reached five degrees. Turning: only time in which the motor "
        "turned fast enough for the angle to be known."
    )
    return Table("Delay from the begin of a fault to the first alarm", header, rows, note)


def _quantile(values: np.ndarray, share: float) -> float:
    return float(np.quantile(values, share, method="higher"))


def _claims(delays: dict[str, Delays], sound: SoundDrives) -> Iterator[Claim]:
    target = "target of tierod"
    offset, drift = delays["offset of 5° electrical"], delays["drift of 20°/s electrical"]
    yield Claim(
        "faults.offset-median",
        "An offset of five degrees electrical is found while turning: median of the delay.",
        target,
        None,
        _quantile(offset.values, 0.5),
        at_most(35.0),
        "ms",
    )
    note = "what is longer is reversals: within one stroke the sum needs 21 ms"
    yield Claim(
        "faults.offset-p95", "The same, 95 %.", target, None, _quantile(offset.values, 0.95), at_most(80.0), "ms", note
    )
    yield Claim(
        "faults.offset-turning",
        "The same, 95 %, of time in which the motor turns.",
        target,
        None,
        _quantile(offset.turning, 0.95),
        at_most(80.0),
        "ms",
    )
    claim = "A drift of 20°/s is found within 50 ms of reaching five degrees: 95 % of the delay"
    yield Claim(
        "faults.drift",
        f"{claim}.",
        target,
        None,
        _quantile(drift.values, 0.95),
        at_most(50.0),
        "ms",
        "reversals, again",
    )
    turning = _quantile(drift.turning, 0.95)
    yield Claim("faults.drift-turning", f"{claim}, turning.", target, None, turning, at_most(50.0), "ms")
    stalls = ("stuck", "sine and cosine swapped", "current phases b and c swapped")
    share = min(delays[name].found / len(delays[name].values) for name in stalls)
    yield Claim(
        "faults.stalling", "Stuck sensors and swapped phases are all found.", target, None, share, at_least(1.0)
    )
    yield Claim(
        "faults.none-false",
        "No alarm in sound drives.",
        target,
        None,
        float(sound.alarms),
        exactly(0.0),
        note=(
            f"{sound.hours:.2g} h, {sound.turning:.2g} h of them turning: fewer than {3.0 / sound.turning:.2g} per "
            f"hour of turning at 95 %. The greatest residual was {sound.greatest:.3f} rad; the sum forgives "
            f"{ANGLE_DRIFT:g} rad a value and alarms at {ANGLE_THRESHOLD:g} rad"
        ),
    )
