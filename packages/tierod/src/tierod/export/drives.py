"""Inputs of a monitor, read from recordings and resampled to its rate."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.export.subject import Subject
from tierod.io.derive import complete
from tierod.io.readers import read
from tierod.monitors.diagnose import find
from tierod.vehicles import Vehicle
from tierod.vehicles.reading import read_by


def inputs_from(subject: Subject, vehicle: Vehicle, source: Recording | str | Path) -> np.ndarray:
    """Input samples (n, inputs) of a monitor from a recording; NaN where a signal is missing.

    Args:
        vehicle: its databases and channel map decode the file

    Raises:
        InputError: the recording cannot be read, is empty, or contains none of the inputs
    """
    monitor, variant = find(subject.monitor, subject.variant)
    databases, used = read_by(vehicle)
    whole = source if isinstance(source, Recording) else read(source, dbc=databases, channel_map=used)
    names = subject.graph.sample
    filled = complete(whole, [*monitor.needing(variant).required, *monitor.optional, *names])
    known = [name for name in names if name in filled]
    if not known:
        raise InputError(
            f"the recording has none of the inputs of the monitor '{subject.monitor}' ({', '.join(names)}); give "
            "another one, or a channel map in the vehicle file"
        )
    aligned = filled.align(known, subject.rate, maximum_age=monitor.maximum_age)
    values = np.full((len(aligned.time), len(names)), np.nan)
    for name in known:
        values[:, names.index(name)] = aligned.values[:, aligned.names.index(name)]
    if not len(values):
        raise InputError("the recording holds no samples; give a longer one")
    return values
