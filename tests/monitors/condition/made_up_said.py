"""What a monitor might say of a drive, sample by sample, made by hand."""

import numpy as np

from tierod.monitors.condition.said import Said
from tierod.monitors.condition.signals import ELEMENTS, SENSORS

PERIOD = 0.01


def place(element):
    return ELEMENTS.index(element)


def span(start, stop):
    """Samples from one instant to another [s]."""
    return slice(round(start / PERIOD), round(stop / PERIOD))


def sound(seconds=10.0):
    """Sound and testable throughout, with its times [s]."""
    count = round(seconds / PERIOD)
    no = np.zeros((count, len(ELEMENTS)), bool)
    untold = np.full(no.shape, np.nan)
    gated = no[:, : len(SENSORS)].copy()
    return np.arange(count) * PERIOD, Said(
        no.copy(),
        no.copy(),
        ~no,
        np.zeros(no.shape),
        untold.copy(),
        untold.copy(),
        gated,
        no[:, 0].copy(),
        np.zeros(count),
    )


def part(said, start, stop):
    """Some of the samples."""
    return Said(*(values[start:stop] for values in said))
