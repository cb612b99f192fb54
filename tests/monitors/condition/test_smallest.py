"""The smallest fault that a fault-free element states: one of that size would have been seen."""

import json
from collections import Counter

import numpy as np
import pytest

from monitors.condition.motion_alone import drive
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.monitors.diagnose import diagnose
from tierod.report.diagnosis import element_rows as rows
from tierod.report.document import document
from tierod_lab.ground.faults import injected
from tierod_lab.papers.condition.drives import OFFSET, Drive, Injected, lost
from tierod_lab.papers.condition.recorded import recorded

LASTING, TESTABLE = 10.0, 5.0
"""Length of a fault, and least time in it in which it would show [s]."""


def car(seed):
    """A drive of a virtual car, and a function that makes the same drive with a change of one sensor."""
    made = Recording(dict(drive(seed, 90.0).channels))
    return made, "rav4", lambda name, size, at: injected(made, [Injected(name, OFFSET, size, at, at + LASTING).fault])


def demonstrator(seed):
    """The same of a virtual demonstrator, with losses of its actuators."""
    course, number = f"round-{3000 + seed}", 1 + seed % 3

    def changed(name, size, at):
        if name.startswith("wheel") or "_rate" in name or "_angle" in name or "torque" in name or "force" in name:
            return injected(made, [Injected(name, OFFSET, size, at, at + LASTING).fault])
        return recorded(Drive(course, 60.0, number, seed, (lost(name, size, at, at + LASTING),)))

    made = recorded(Drive(course, 60.0, number, seed))
    return made, "smartload", changed


def begins(found, name, seed):
    """Time at which a fault of an element begins, drawn among those at which it would show; None without one [s]."""
    trace = found.traces[f"state_of_{name}"]
    time, shows = np.asarray(trace.time), np.asarray(trace.mean) < 0.1
    step = time[1] - time[0]
    inside = np.convolve(shows, np.ones(round(LASTING / step)), "full")[round(LASTING / step) - 1 :] * step
    fits = time[(inside[: len(time)] >= TESTABLE) & (time > 8.0) & (time < time[-1] - LASTING - 5.0)]
    return float(np.random.default_rng(seed).choice(fits)) if len(fits) else None


def seen(made, factors, seed, only=None):
    """Whether faults of the stated sizes are seen, by factor and element."""
    recording, vehicle, changed = made
    found, results = diagnose(recording, vehicle, "condition", spread=False), []
    for element in found.elements:
        at = None if element.smallest is None else begins(found, element.name, seed)
        if at is None or (only and element.name not in only):
            continue
        size = element.smallest / (100.0 if element.unit == "percent" else 1.0)
        for factor in factors:
            if element.role == "actuator" and factor * size > 1.0:
                continue
            wrong = diagnose(changed(element.name, factor * size, at), vehicle, "condition", spread=False)
            (state,) = (each for each in wrong.elements if each.name == element.name)
            results.append((factor, element.name, state.status is Status.FAULT))
    return results


def test_offsets_of_the_stated_size_are_seen():
    found = seen(car(11), (1.0,), 1, ("yaw_rate", "wheel_speed_rear_left"))
    assert [each for *_, each in found] == [True, True]


def test_every_fault_free_element_states_its_smallest_fault_with_its_unit():
    found = diagnose(car(11)[0], "rav4", "condition", spread=False)
    quiet = [each for each in found.elements if each.status is Status.HEALTHY]
    assert len(quiet) == 6
    assert all(each.smallest > 0.0 for each in quiet)
    (yaw,) = (each for each in json.loads(document(found, False))["elements"] if each["name"] == "yaw_rate")
    assert (yaw["unit"], 0.02 < yaw["smallest"] < 0.2) == ("rad/s", True)
    (row,) = rows(next(each for each in quiet if each.name == "yaw_rate"))
    (fault,) = (cell for cell in row if str(cell).startswith("no offset above "))
    assert fault.endswith(" °/s")
    assert all(each.smallest is None for each in found.elements if each.status is not Status.HEALTHY)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1.0, 1.5])
def test_nine_of_ten_faults_of_the_stated_size_are_seen(factor):
    results = [each for seed in (121, 122, 123) for each in seen(car(seed), (factor,), seed)]
    results += [each for seed in (121, 122) for each in seen(demonstrator(seed), (factor,), seed)]
    count, good = Counter(name for _, name, _ in results), Counter(name for _, name, found in results if found)
    print({name: f"{good[name]} of {number}" for name, number in count.items()})
    assert sum(good.values()) >= 0.9 * sum(count.values())
