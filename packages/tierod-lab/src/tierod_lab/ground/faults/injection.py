"""Injection of faults into an existing recording, of the virtual vehicle or of a real car."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from tierod.core.errors import ParameterError
from tierod.core.recording import Recording
from tierod.core.signals import SIGNALS
from tierod_lab.ground.faults.elements import Reach
from tierod_lab.ground.faults.fault import Fault
from tierod_lab.ground.faults.schedule import Schedule
from tierod_lab.ground.faults.triggers import AtDistance, When
from tierod_lab.ground.sensors import Sensor, SensorSet


class _OfRecording(Reach):
    def __init__(self, recording: Recording, sensors: SensorSet):
        given = {name: sensors.sensors.get(name, Sensor()) for name in recording.names if name in SIGNALS}
        super().__init__(None, SensorSet(given))
        # These values take the place of cached properties of the base class, which need a car.
        self.__dict__["outputs"] = {name: recording[name].unit for name in recording.names}
        self.__dict__["inputs"] = {}
        self.__dict__["parameters"] = {}


def injected(
    recording: Recording, faults: Iterable[Fault], sensors: SensorSet | None = None, seed: int = 0
) -> Recording:
    """A recording with faults of its signals, as if they had been present when it was made.

    Only the recorded signals change, not the reaction of control units that would have read a faulty signal. A
    fault-free recording of the virtual vehicle becomes identical to that of a run with the same faults of `sensor.`
    elements and the same seed.

    Args:
        recording: recording without these faults; times of faults refer to its time axis

    Raises:
        ParameterError: a fault of an element that is not a recorded signal, or one with a condition as its trigger
    """
    faults = tuple(faults)
    for fault in faults:
        if isinstance(fault.trigger, AtDistance | When):
            raise fault.error("trigger", "a recording does not wait for a condition; let the fault begin at a time")
    reach = _OfRecording(recording, sensors or SensorSet())
    if not reach.recorded:
        raise ParameterError("the recording has no signal of a known name that could fail; give it a channel map")
    schedule = Schedule(faults, None, reach.sensors, seed, recording.span[1], reach)
    changed = []
    for name in sorted({window["element"] for window in schedule.windows}):
        channel = recording[name]
        time, values = schedule.on_channel(name, channel.time, channel.values)
        changed.append(replace(channel, time=time, values=values))
    return recording.with_channels(changed)
