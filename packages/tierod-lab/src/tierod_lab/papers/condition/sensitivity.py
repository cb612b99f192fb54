"""Sensitivity of the bank's verdicts to its tuning: each number 20 % smaller or larger, all others unchanged."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import product
from typing import Annotated, NamedTuple
from zlib import crc32

import numpy as np

from tierod.core.claims import Claim, at_least, exactly
from tierod.core.content import Heading, Item, Table
from tierod.core.graph import Bank, Scanner
from tierod.core.recording import Recording
from tierod.monitors.condition.limits import aligned
from tierod_lab.papers.condition.by_bank import Known, declared_of
from tierod_lab.papers.condition.drives import (
    ACTUATORS,
    SENSORS,
    Drive,
    healthy_drives,
    mixed_pairs,
    more_kinds,
    sensor_pairs,
    supply_tests,
)
from tierod_lab.papers.condition.faults import DELAY, DRIFT, GAIN, LOSS, NOISE, OFFSET, OUTLIER, STUCK, lost
from tierod_lab.papers.condition.odd_drives import SLIPPERY, on_ice, sliced
from tierod_lab.papers.condition.recorded import recorded
from tierod_lab.papers.condition.reported import first_vehicle
from tierod_lab.papers.condition.runs import BEST, VARIANTS, calibrations
from tierod_lab.papers.condition.scoring import FOUND, DriveScore, score
from tierod_lab.papers.condition.sensors import GOAL
from tierod_lab.papers.condition.truth import Truth, truth_of
from tierod_lab.papers.condition.tuned_numbers import Number, first_clause, numbers_of, varied
from tierod_lab.papers.condition.vehicles import SHORT
from tierod_lab.studies.effort import Effort

TEXT = (
    "Every float field that the bank's graph depends on, at 0.8 and 1.2 of its value, all others as they are, the "
    "limits included, which a calibration would design anew. Counts go to the next whole number at least; sensors and "
    "lanes that share a field are varied together. Parameters of the vehicle, which its file gives, and constants "
    "inside the equations are not varied. The last column is what the field says about its value; where that is no "
    "reason, the value is a choice.",
    "A verdict is what a drive's fault was named most of the time, whether it was missed, its kind, whether anything "
    "fault-free was named, and the number of false alarms. The drives are short: loss, offset, outlier and "
    "one further kind of fault of every sensor, a loss of every actuator, two faults at once, a fault-free round, and "
    "drives on ice. A fault begins with the first bend, where it shows. The vehicle follows from the monitor's digest.",
)
FACTORS = (0.8, 1.2)
UNCHANGED = 0.95
"""Goal of the share of numbers that change no verdict [-]."""
BEFORE, START, END, SECONDS = 5.0, 7.0, 11.0, 12.5
"""Start of the judged part, beginning of a fault (with the first bend), its end, and end of the drive [s]."""
ROUND, ON_ICE = 40.0, 20.0
"""End of the fault-free drives, on a round and on ice [s]."""
FURTHER = (STUCK, GAIN, DRIFT, NOISE, DELAY)
"""Kinds beside those of the paper's tests, which the sensors get in turn."""
EVERY = 20
"""Step between the numbers that are varied in a quick study."""


class Judged(NamedTuple):
    """Results of all drives with one number varied.

    Args:
        scores: scores of the drives, in their order
        digests: checksums of the outputs of the bank, equal where no output changed
    """

    scores: tuple[DriveScore, ...]
    digests: tuple[int, ...]


class Effect(NamedTuple):
    """Changes of the results by one number.

    Args:
        changed: names of the drives whose verdict differs
        alarms: increase of the false alarms
        alarming: names of the drives with more false alarms
        accuracy: increase of the mean accuracy [-]
        delay: increase of the longest delay, counted in observable time
        shows: whether any output differs
    """

    changed: tuple[str, ...]
    alarms: int
    alarming: tuple[str, ...]
    accuracy: float
    delay: Annotated[float, "s"]
    shows: bool


def drives(number: int) -> list[Drive]:
    """Drives with faults and without, except those on ice.

    Args:
        number: number of the demonstrator
    """
    seed = 60 + number
    # Reversed, so that the first drive of a kind remains, with its positive size.
    every = {
        (each.injected[0].element, each.injected[0].kind): each for each in reversed(more_kinds(number, SHORT, seed))
    }
    of_sensors = [
        every[sensor, kind]
        for place, sensor in enumerate(SENSORS)
        for kind in (LOSS, OFFSET, OUTLIER, FURTHER[place % len(FURTHER)])
    ]
    of_actuators = [
        Drive(SHORT, 0.0, number, seed, (lost(actuator, share),))
        for actuator, share in zip(ACTUATORS, (1.0, 0.5, 0.5, 1.0), strict=True)
    ]
    pairs = [*sensor_pairs(number, SHORT, seed)[::11], *mixed_pairs(number, SHORT, seed)[::11]]
    pairs += supply_tests(number)[:2]
    quiet = replace(healthy_drives(0.1, (number,))[0], seconds=ROUND)
    return [*(_short(each) for each in (*of_sensors, *of_actuators, *pairs)), quiet]


def _short(drive: Drive) -> Drive:
    first = drive.injected[0].start
    injected = tuple(
        replace(each, start=(start := START + each.start - first), end=start + 1.0 if each.kind == OUTLIER else END)
        for each in drive.injected
    )
    return replace(drive, seconds=SECONDS, injected=injected)


def items(effort: Effort) -> Iterator[Item]:
    if BEST not in VARIANTS or not (effort.thorough or effort.quick):
        return
    vehicle = first_vehicle()
    known = calibrations((BEST,), (vehicle,), effort)[VARIANTS[BEST].module, vehicle]
    every = numbers_of(known.bank)
    chosen = [each for each in every if each.used and not each.off][:: EVERY if effort.quick else 1]
    asked = [None, *product(chosen, FACTORS)]
    found = effort.made(partial(judged, known, vehicle, effort.quick), asked, lambda each: f"a variation ({each})")
    # The first result is that of the unchanged bank; two follow for each number.
    effects = {each: [effect(found[0], one) for one in found[1 + 2 * k : 3 + 2 * k]] for k, each in enumerate(chosen)}
    yield Heading("Numbers a fifth smaller or larger", TEXT)
    yield _table(effects, every, found[0])
    yield from _claims(effects, len(found[0].scores))


def judged(known: Known, vehicle: int, quick: bool, asked: tuple[Number, float] | None) -> Judged:
    """Results of all drives by the bank with a number multiplied by a factor; unchanged if None."""
    bank = known.bank if asked is None else varied(known.bank, *asked)
    return judged_by(bank, prepared(vehicle, quick))


def judged_by(bank: Bank, every: Sequence[Prepared]) -> Judged:
    """Results of all drives by a bank."""
    scanner: Scanner = Scanner(bank)
    scores, digests = [], []
    for each in every:
        result = scanner.scan(each.samples)
        digests.append(crc32(result.values.tobytes()))
        scores.append(score(each.drive, each.truth, declared_of(result, each.time)))
    return Judged(tuple(scores), tuple(digests))


class Prepared(NamedTuple):
    """A drive with its truth, sampling times and the samples of the bank."""

    drive: Drive
    truth: Truth
    time: Annotated[np.ndarray, "s"]
    samples: np.ndarray


@lru_cache(maxsize=2)
def prepared(vehicle: int, quick: bool) -> tuple[Prepared, ...]:
    """All drives of a vehicle, simulated once per process.

    Args:
        vehicle: number of the demonstrator
        quick: whether only a few drives are made
    """
    every = drives(vehicle)
    made = [_prepared(each, recorded(each)) for each in (every[:: len(every) // 4] if quick else every)]
    return (*made, *(_prepared(Drive(name, ON_ICE, vehicle), on_ice(vehicle, name, ON_ICE)) for name in SLIPPERY))


def _prepared(drive: Drive, recording: Recording) -> Prepared:
    injected = tuple(replace(each, start=each.start - BEFORE, end=each.end - BEFORE) for each in drive.injected)
    drive, recording = replace(drive, seconds=drive.seconds - BEFORE, injected=injected), sliced(recording, BEFORE)
    return Prepared(drive, truth_of(drive, recording), recording["yaw_rate"].time, aligned(recording))


def effect(usual: Judged, other: Judged) -> Effect:
    """Changes from one result to another."""
    pairs = list(zip(usual.scores, other.scores, strict=True))
    return Effect(
        tuple(before.drive.name for before, after in pairs if _verdict(before) != _verdict(after)),
        sum(after.false_alarms - before.false_alarms for before, after in pairs),
        tuple(before.drive.name for before, after in pairs if after.false_alarms > before.false_alarms),
        _accuracy(other) - _accuracy(usual),
        _longest(other) - _longest(usual),
        usual.digests != other.digests,
    )


def _verdict(each: DriveScore) -> tuple[object, ...]:
    faults = tuple((fault.outcome, fault.kind_right) for fault in each.faults)
    return each.named, faults, each.wrong_share > 0.0, each.false_alarms


def _accuracy(of: Judged) -> float:
    return float(np.mean([fault.accuracy for each in of.scores for fault in each.faults]))


def _longest(of: Judged) -> float:
    found = [fault for each in of.scores for fault in each.faults if fault.outcome == FOUND]
    return max((fault.delay_excited for fault in found), default=0.0)


HEADER = (
    *("number", "value", "verdicts that differ", "false alarms more"),
    *("accuracy more", "longest delay more [s]", "what its field says"),
)


def _table(effects: Mapping[Number, Sequence[Effect]], every: Sequence[Number], usual: Judged) -> Table:
    order = sorted(effects, key=lambda each: (-_weight(effects[each]), each.name))
    rows = tuple((each.name, _values(each), *_cells(effects[each]), _reason(each, effects[each])) for each in order)
    notes = [
        "Each cell: at 0.8 / 1.2 of the value; a dash where no output differs at all. As it is, the bank "
        "misses "
        f"{sum(fault.outcome != FOUND for each in usual.scores for fault in each.faults)} faults of "
        f"{sum(len(each.faults) for each in usual.scores)}, with {sum(e.false_alarms for e in usual.scores)} false "
        f"alarms, an accuracy of {_accuracy(usual):.4f} and a longest delay of {_longest(usual):.2f} s.",
        _listed("Not varied, since they are zero", [each.name for each in every if each.used and each.off]),
        _listed("Not in the graph", [each.name for each in every if not each.used]),
    ]
    return Table("Verdicts under numbers a fifth smaller or larger", HEADER, rows, " ".join(filter(None, notes)))


def _weight(both: Sequence[Effect]) -> float:
    """Sorting key of the rows: changed verdicts and false alarms, then accuracy and delay, then any change at all."""
    verdicts = sum(len(each.changed) + abs(each.alarms) for each in both)
    rest = max(min(abs(each.accuracy) + 0.01 * abs(each.delay), 0.5) for each in both)
    return verdicts + rest + 1e-9 * any(each.shows for each in both)


def _reason(number: Number, both: Sequence[Effect]) -> str:
    return number.reason if any(each.changed for each in both) else first_clause(number.reason)


def _values(number: Number) -> str:
    low, high = min(number.values), max(number.values)
    return f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"


def _cells(both: Sequence[Effect]) -> tuple[str, ...]:
    if not any(each.shows for each in both):
        return ("–",) * 4
    changes = (
        [len(each.changed) for each in both],
        [each.alarms for each in both],
        # Adding 0.0 turns a rounded -0.0 into 0.0.
        [round(each.accuracy, 3) + 0.0 for each in both],
        [round(each.delay, 2) + 0.0 for each in both],
    )
    return tuple(" / ".join(f"{value:g}" for value in each) if any(each) else "0" for each in changes)


def _listed(what: str, names: Sequence[str]) -> str:
    return f"{what}: {', '.join(names)}." if names else ""


def _claims(effects: Mapping[Number, Sequence[Effect]], count: int) -> Iterator[Claim]:
    idle = sum(not any(one.shows for one in both) for both in effects.values())
    deciding = {each: both for each, both in effects.items() if any(one.changed for one in both)}
    words = "; ".join(
        f"{each.name} ({' / '.join(str(len(one.changed)) for one in both)} of {count})"
        for each, both in deciding.items()
    )
    yield Claim(
        "sensitivity.unchanged",
        "Share of the numbers of the tuning of which a fifth more or less changes no verdict.",
        GOAL,
        None,
        1.0 - len(deciding) / len(effects),
        at_least(UNCHANGED),
        note=f"Of {len(effects)} numbers and {count} drives, which do not reach {idle} of the numbers.",
        cause=f"These decide verdicts, at 0.8 / 1.2 of them: {words}.",
    )
    alarming = {each: both for each, both in effects.items() if any(one.alarms > 0 for one in both)}
    words = "; ".join(
        f"{each.name} ({' / '.join(f'{one.alarms:+d}' for one in both)})" for each, both in alarming.items()
    )
    where = {name for both in alarming.values() for one in both for name in one.alarming}
    fault_free = f"{sum(name.startswith('healthy') for name in where)} of {len(where)}"
    yield Claim(
        "sensitivity.alarms",
        "Numbers of the tuning of which a fifth more or less adds a false alarm.",
        GOAL,
        None,
        len(alarming),
        exactly(0.0),
        cause=f"False alarms more, at 0.8 / 1.2: {words}; {fault_free} drives with more are without a fault, in the "
        "others a state changes after the fault. A calibration designs the limits anew for what the filters then show; "
        "here they stay as they were.",
    )
