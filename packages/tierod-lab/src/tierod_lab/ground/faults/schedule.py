"""Schedule of faults over a run, and their injection into the parts of a car."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.recording import Recording
from tierod.core.signals import SIGNALS
from tierod.core.toml import kind_name
from tierod_lab.ground.faults.active import Active, prepared
from tierod_lab.ground.faults.behaviour import ACTUATOR, LOOP, PARAMETER, SIGNAL, SURROUNDING, Change
from tierod_lab.ground.faults.behaviours import described
from tierod_lab.ground.faults.elements import Reach, Target
from tierod_lab.ground.faults.fault import AtDistance, Fault, When, trigger_table
from tierod_lab.ground.parts import Plant
from tierod_lab.ground.sensors import Sensor, SensorSet


class Levels(NamedTuple):
    """Gain and offset of a port at one step."""

    gain: float = 1.0
    offset: float = 0.0


class PortCourse:
    """Gain, offset and hold of a port over the steps of a piece: held where `held` is one, then gain * value + offset.

    Args:
        time: times of the steps [s]
    """

    def __init__(self, time: np.ndarray):
        self.time = time
        self.gain, self.offset, self.held = np.ones(len(time)), np.zeros(len(time)), np.zeros(len(time))

    @property
    def last(self) -> Levels:
        """Levels of the last step."""
        return Levels(float(self.gain[-1]), float(self.offset[-1]))

    def add(self, during: np.ndarray, change: Change, before: Levels) -> Levels:
        """Apply one more fault.

        Returns:
            gain and offset ahead of this fault at the end of the piece, or at the step at which it began to hold
        """
        holds = np.zeros(len(self.time), dtype=bool)
        # At the first step of a run there is no previous value to hold.
        holds[during] = change.held & (self.time[during] > 0.0)
        # Index of the last step before the hold; -1 if the hold began in an earlier piece.
        source = np.maximum.accumulate(np.where(holds, -1, np.arange(len(self.time))))
        for values, old in ((self.gain, before.gain), (self.offset, before.offset)):
            values[:] = np.where(source < 0, old, values[source])
        into = self.last
        self.gain[during] *= change.gain
        self.offset[during] = change.gain * self.offset[during] + change.offset
        self.held[holds] = 1.0
        return into

    def inputs(self, name: str) -> dict[str, np.ndarray]:
        """Inputs of a car for a port of this name."""
        return {f"ports.{name}.{part}": getattr(self, part) for part in ("gain", "offset", "held")}


_STREAM = 4  # Number of the faults' random stream, separate from those of road, driver, sensors and scatter

Usual = Callable[[str], np.ndarray]


class Schedule:
    """The faults of one run.

    A signal that is recorded and also read by a control unit of the car gets the fault in both places: at the same
    times, and with the same random numbers where the instants coincide. In a loop, a lost frame repeats the previous
    value; a delay and a bit flip are refused there, since neither is a gain, an offset or a held value. Faults of
    recorded signals act after the sensor, and their values get the sensor's resolution and range. A fault with a
    condition starts with the piece of the run that follows the one in which the condition became true.

    Args:
        faults: faults of the run; several at once are applied in order
        seconds: duration of the run [s]
    """

    def __init__(
        self,
        faults: Iterable[Fault],
        car: Plant | None,
        sensors: SensorSet,
        seed: int,
        seconds: float,
        reach: Reach | None = None,
    ):
        self.seconds = seconds
        self._reach = reach or Reach(car, sensors)
        self._faults: list[Active] = []
        self._before: dict[tuple[Active, int, str], Levels] = {}
        counts: Counter[int] = Counter()
        for fault in faults:
            name = zlib.crc32(fault.label.encode())
            key = (seed, _STREAM, name, counts[name])
            counts[name] += 1
            self._faults.append(prepared(fault, self._reach, key, seconds))

    @property
    def parameters(self) -> tuple[str, ...]:
        """Dotted paths of the car's fields that faults change."""
        return tuple(sorted({target.name for _, target in self._targets(PARAMETER)}))

    @property
    def pending(self) -> bool:
        """Whether a fault is still waiting for its condition."""
        return any(active.watch is not None for active in self._faults)

    def _targets(self, *roles: str) -> list[tuple[tuple[Active, int], Target]]:
        return [
            ((active, number), target)
            for active in self._faults
            for number, effect in enumerate(active.effects)
            for target in effect.targets
            if target.role in roles
        ]

    def observe(self, time: np.ndarray, outputs: Mapping[str, np.ndarray]) -> None:
        """Evaluate the conditions of pending faults on a piece of the run; faults start at the next step.

        Args:
            time: times of the piece [s]
        """
        for active in self._faults:
            if active.watch is not None and active.watch.held(time, outputs):
                step = float(time[-1] - time[-2]) if len(time) > 1 else getattr(self._reach.car, "step_time", 0.0)
                active.begin(float(time[-1]) + step, self.seconds)

    def inputs(self, time: np.ndarray, usual: Usual | None = None) -> dict[str, np.ndarray]:
        """Inputs of the car that faults change at the steps of the next piece.

        Call it for the pieces in order, since held values carry over from one piece to the next.

        Args:
            time: times of the steps [s]
            usual: function that returns the course's value of an input of the car, in the shape of `time`; needed if a
                fault changes the surroundings of the car

        Returns:
            "ports.NAME.gain", ".offset", ".held", "parameters.PATH", and inputs of the car such as
            "road.adhesion_left"; each in the shape of `time`
        """
        given = self._through_ports(time)
        for (active, number), target in self._targets(PARAMETER, SURROUNDING):
            during = active.during(time)
            if during.any():
                change = active.change(number, time[during])
                values = given.setdefault(_input(target), _without_fault(target, time, usual))
                values[during] = change.gain * values[during] + change.offset
        return given

    def _through_ports(self, time: np.ndarray) -> dict[str, np.ndarray]:
        courses: dict[str, PortCourse] = {}
        for (active, number), target in self._targets(LOOP, ACTUATOR):
            during, effect = active.during(time), (active, number, target.name)
            if during.any():
                course = courses.setdefault(target.name, PortCourse(time))
                change = active.change(number, time[during])
                self._before[effect] = course.add(during, change, self._before.get(effect, Levels()))
            else:
                self._before[effect] = courses[target.name].last if target.name in courses else Levels()
        return {name: values for port, course in courses.items() for name, values in course.inputs(port).items()}

    def on_channel(self, name: str, time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        for (active, number), target in self._targets(SIGNAL):
            during = active.during(time)
            if target.name == name and during.any():
                behaviour, sensor = active.effects[number].behaviour, self._reach.sensors[name]
                time, values = behaviour.on_channel(time, values, during, sensor, active.chances[number])
        return time, values

    @property
    def windows(self) -> tuple[dict[str, Any], ...]:
        """Fault name, element, behaviour, start and end [s] of every effect; None if the fault did not start."""
        return tuple(
            {
                "name": active.fault.label,
                "element": effect.targets[0].name,
                "behaviour": kind_name(type(effect.behaviour)),
                "start": active.start,
                "end": None if active.start is None else active.end,
            }
            for active in self._faults
            for effect in active.effects
        )

    @property
    def provenance(self) -> tuple[dict[str, Any], ...]:
        """Complete description of every effect: window, behaviour with all numbers in SI units, and trigger."""
        effects = [(active, effect) for active in self._faults for effect in active.effects]
        return tuple(
            window
            | {
                "targets": [f"{target.role} {target.name}" for target in effect.targets],
                "behaviour": described(effect.behaviour),
                "trigger": trigger_table(active.fault.trigger),
            }
            for window, (active, effect) in zip(self.windows, effects, strict=True)
        )


def _input(target: Target) -> str:
    return f"parameters.{target.name}" if target.role == PARAMETER else target.name


def _without_fault(target: Target, time: np.ndarray, usual: Usual | None) -> np.ndarray:
    if target.role == PARAMETER:
        return np.full(len(time), target.usual)
    if usual is None:
        raise ParameterError(f"a fault of '{target.name}' needs the values of the course; give `usual`")
    return np.array(usual(target.name), dtype=float)


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
