"""Recordings of the virtual bench for tests, and what may be wrong with them."""

from dataclasses import replace
from functools import cache

from tierod.core.recording import Recording
from tierod.methods.identification.bench_recording import bench_recording
from tierod_lab.papers.column.benches import bench, recorded, truth

TRUTH = truth()
FREE, LOCKED, RAMPS, SINES = "sweep, wheel free", "sweep, wheel locked", "ramps, wheel locked", "many sines, wheel free"


@cache
def recordings(seconds=4.0, seed=5):
    return recorded(bench(), seed, seconds=seconds)


def changed(recording, **changes):
    """A recording with channels put through functions of (time, values)."""
    channels = dict(recording.channels)
    for name, change in changes.items():
        time, values = change(channels[name].time, channels[name].values)
        channels[name] = replace(channels[name], time=time, values=values)
    return Recording(channels)


def turned(recording, *names):
    return changed(recording, **{name: lambda time, values: (time, -values) for name in names})


def row(name, recording=None):
    return bench_recording(name, recording or recordings()[name], TRUTH)
