"""What a monitor might state over a drive, sample by sample, made by hand."""

import numpy as np

from tierod.monitors.condition.courses import FAULT, HEALTHY, SUSPECT, StatementCourse
from tierod.monitors.condition.signals import ELEMENTS

PERIOD = 0.01


def place(element):
    return ELEMENTS.index(element)


def span(start, stop):
    """Samples from one instant to another [s]."""
    return slice(round(start / PERIOD), round(stop / PERIOD))


def fault_free(seconds=10.0):
    """Healthy and testable throughout, with its times [s]."""
    count = round(seconds / PERIOD)
    shape = (count, len(ELEMENTS))
    numbers = [np.zeros(shape) for _ in range(4)]
    stated = StatementCourse(
        np.full(shape, HEALTHY),
        np.ones(shape, bool),
        *numbers,
        np.zeros(count, bool),
        np.zeros(count),
        np.zeros(shape),
        np.full(shape, np.nan),
        np.zeros(shape, bool),
    )
    return np.arange(count) * PERIOD, stated


def declare(stated, at, names=ELEMENTS, kind=0.0, magnitude=0.0, onset=None):
    """Faults of some elements over some samples, with evidence from their onset [s] to their last sample."""
    time = np.arange(len(stated.status)) * PERIOD
    first = time[at][0] if onset is None else onset
    for name in names:
        stated.status[at, place(name)] = FAULT
        stated.kind[at, place(name)], stated.magnitude[at, place(name)] = kind, magnitude
        stated.deviation[at, place(name)] = 0.01
        stated.since[at, place(name)], stated.supported[at, place(name)] = first, time[at]


def doubt(stated, at, names=ELEMENTS):
    """Doubt between some elements over some samples."""
    for name in names:
        column = stated.status[at, place(name)]
        stated.since[at, place(name)][column != FAULT] = at.start * PERIOD
        column[column != FAULT] = SUSPECT


def part(stated, start, stop):
    """Some of the samples."""
    return StatementCourse(*(values[start:stop] for values in stated))
