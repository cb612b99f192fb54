"""Schedule of faults over a run: prepared against car and sensors, and injected into the parts of a car."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.recording import Recording
from tierod.core.signals import SIGNALS
from tierod.core.toml import kind_name
from tierod_lab.ground.faults.behaviours import (
    ACTUATOR,
    LOOP,
    PARAMETER,
    SIGNAL,
    SURROUNDING,
    Behaviour,
    Chance,
    Change,
    Course,
    described,
)
from tierod_lab.ground.faults.elements import MisfitError, Reach, Target
from tierod_lab.ground.faults.fault import (
    AtDistance,
    AtTime,
    Comparison,
    Effect,
    Fault,
    When,
    Within,
    resolved,
    trigger_table,
)
from tierod_lab.ground.parts import Plant
from tierod_lab.ground.sensors import Sensor, SensorSet

DISTANCE = "truth_distance"  # Channel of the distance that the car has travelled


class Watch:
    """Evaluates a condition on the outputs of a car, piece by piece, until it has held for long enough."""

    def __init__(self, trigger: AtDistance | When, reach: Reach):
        self.comparisons: list[tuple[Comparison, str]] = []
        self.since: float | None = None
        wanted: tuple[Comparison, ...]
        if isinstance(trigger, AtDistance):
            self.hold, wanted = 0.0, (Comparison(DISTANCE, False, ">=", trigger.distance, "m"),)
        else:
            self.hold, wanted = trigger.hold, trigger.comparisons
        for each in wanted:
            if each.signal not in reach.outputs:
                near = nearest(each.signal, reach.outputs)
                raise ParameterError(f"the car has no channel '{each.signal}' to wait for{near}")
            unit = reach.outputs[each.signal] or ""
            try:
                each.holds(np.zeros(1), unit)
            except InputError as error:
                against = f"'{each.signal}' cannot be held against {each.value:g} {each.unit}"
                raise ParameterError(f"{against}: {error}") from None
            self.comparisons.append((each, unit))

    def held(self, time: np.ndarray, outputs: Mapping[str, np.ndarray]) -> bool:
        """Whether the condition has held for long enough by the end of these samples.

        Args:
            time: times of the samples [s], which directly follow those of the previous call
        """
        true = np.ones(len(time), dtype=bool)
        for comparison, unit in self.comparisons:
            true &= comparison.holds(outputs[comparison.signal], unit)
        begins = np.where(true, time, np.inf)
        for place in np.flatnonzero(true):
            # The condition may have begun to hold in an earlier piece.
            before = self.since if place == 0 else (begins[place - 1] if true[place - 1] else None)
            begins[place] = time[place] if before is None else before
            if time[place] - begins[place] >= self.hold - 1e-9:
                return True
        self.since = float(begins[-1]) if true[-1] else None
        return False


_NOTHING, _NO_CHANCE = np.empty(0), Chance((0,), 0.0, 0.0)
_LOOP_RATE = 1000.0  # Sampling rate of the control loops [Hz]
_EARLY = 1e-9  # Tolerance for rounding of the time of a run [s]


class Acting:
    """One effect of a fault in a run: a behaviour with amounts in the unit of its targets, and its random numbers."""

    def __init__(self, active: Active, number: int, behaviour: Behaviour, targets: tuple[Target, ...]):
        self.active, self.number, self.behaviour, self.targets = active, number, behaviour, targets
        self.chance = _NO_CHANCE

    def change(self, time: np.ndarray) -> Change:
        return self.behaviour.change(time - self.active.start, self.chance)

    @property
    def window(self) -> dict[str, Any]:
        """Fault name, element, behaviour, start and end [s]; None if the fault did not start."""
        active = self.active
        return {
            "name": active.fault.label,
            "element": self.targets[0].name,
            "behaviour": kind_name(type(self.behaviour)),
            "start": active.start,
            "end": None if active.start is None else active.end,
        }


class Active:
    """State of a fault during a run of a duration [s]: its effects and its window."""

    def __init__(self, fault: Fault, reach: Reach, key: tuple[int, ...], seconds: float):
        self.fault, self.reach, self.key, self.seconds = fault, reach, key, seconds
        self.start: float | None = None
        self.end = np.inf
        self.watch: Watch | None = None
        aimed = [_aimed(fault, each, reach, seconds) for each in fault.effects]
        self.effects = [Acting(self, at, *each) for at, each in enumerate(each for each in aimed if each[1])]
        if not self.effects:
            raise fault.error("element", reach.nothing_of(each.element for each in fault.effects))
        step = getattr(reach.car, "step_time", 0.0)
        if fault.duration is not None and fault.duration < step:
            lasts = f"the fault lasts {fault.duration:g} s, less than a step of the car, {step:g} s"
            raise fault.error("duration", f"{lasts}; let it last longer")
        if not isinstance(fault.trigger, AtDistance | When):
            self.begin(_start(fault, key, seconds))
            return
        try:
            self.watch = Watch(fault.trigger, reach)
        except ParameterError as error:
            raise fault.error("trigger", str(error)) from None

    def begin(self, start: float) -> None:
        """Start the fault at a time [s]."""
        lasts = self.fault.lasts
        self.start, self.watch = start, None
        self.end = self.seconds if lasts is None else min(start + lasts, self.seconds)
        for effect in self.effects:
            recorded = [target.name for target in effect.targets if target.role == SIGNAL]
            rate = self.reach.sensors[recorded[0]].rate if recorded else _LOOP_RATE
            effect.chance = Chance((*self.key, effect.number), start, self.end - start, rate)

    def during(self, time: np.ndarray) -> np.ndarray:
        """Whether the fault is active at given times [s]."""
        if self.start is None:
            return np.zeros(len(time), dtype=bool)
        return (time >= self.start - _EARLY) & (time < self.end - _EARLY)


def _aimed(fault: Fault, effect: Effect, reach: Reach, seconds: float) -> tuple[Behaviour, tuple[Target, ...]]:
    try:
        targets = reach.targets(effect.element, effect.behaviour)
    except ParameterError as error:
        part = "behaviour" if isinstance(error, MisfitError) else "element"
        raise fault.error(part, str(error), effect) from None
    behaviour = resolved(fault, effect, targets[0].unit) if targets else effect.behaviour
    for target in targets:
        if target.role == SIGNAL:
            try:  # Some channels cannot behave so, such as a bit flip without a quantum.
                behaviour.on_channel(_NOTHING, _NOTHING, _NOTHING > 0.0, reach.sensors[target.name], _NO_CHANCE)
            except ParameterError as error:
                raise fault.error("behaviour", str(error), effect) from None
        if target.limits is not None and (wrong := _out_of_range(fault, behaviour, target, seconds)):
            raise fault.error("size", wrong, effect)
    return behaviour, targets


def _out_of_range(fault: Fault, behaviour: Behaviour, target: Target, seconds: float) -> str:
    """Message if a fault takes a parameter or the surroundings out of range, considered alone; "" if none does."""
    assert target.limits is not None
    core = behaviour.core
    # Samples suffice: ramps and drifts are extreme at their ends, a course at its corners.
    since = np.linspace(0.0, _longest(fault, seconds), 101)
    if isinstance(core, Course):
        since = np.union1d(since, [time for time in core.times if 0.0 <= time <= since[-1]])
    change = core.change(since, _NO_CHANCE)
    gain, offset = np.broadcast_arrays(change.gain, change.offset)
    # The usual value of a surrounding is known only during the run: here, only values independent of it are checked.
    values = offset[gain == 0.0] if target.usual is None else np.ravel(gain * target.usual + offset)
    wrong = next((value for value in values if not target.limits.holds(value)), None)
    if wrong is None:
        return ""
    unit = f" {target.unit}" if target.unit else ""
    return f"'{target.name}' would become {wrong:g}{unit}, but has to be {target.limits}{unit}"


def _longest(fault: Fault, seconds: float) -> float:
    """Longest possible duration of a fault in a run [s]."""
    trigger = fault.trigger
    start = trigger.time if isinstance(trigger, AtTime) else trigger.earliest if isinstance(trigger, Within) else 0.0
    return max(min(fault.lasts or seconds, seconds - start), 0.0)


def _start(fault: Fault, key: tuple[int, ...], seconds: float) -> float:
    trigger: Any = fault.trigger
    if isinstance(trigger, Within):
        start, latest = float(np.random.default_rng(key).uniform(trigger.earliest, trigger.latest)), trigger.latest
    else:
        start = latest = trigger.time if isinstance(trigger, AtTime) else 0.0
    if not latest < seconds:
        begins = f"the fault begins at {latest:g} s, but the run ends at {seconds:g} s; begin earlier"
        raise fault.error("trigger", begins)
    return start


class Levels(NamedTuple):
    """Gain and offset of a port at one step."""

    gain: float = 1.0
    offset: float = 0.0


class PortCourse:
    """Gain, offset and hold of a port over the steps of a piece: held at one, then gain * value + offset."""

    def __init__(self, time: np.ndarray):
        self.time = time
        self.gain, self.offset, self.held = np.ones(len(time)), np.zeros(len(time)), np.zeros(len(time))

    @property
    def last(self) -> Levels:
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
        self._before: dict[tuple[Acting, str], Levels] = {}
        counts: Counter[int] = Counter()
        for fault in faults:
            name = zlib.crc32(fault.label.encode())
            key = (seed, _STREAM, name, counts[name])
            counts[name] += 1
            self._faults.append(Active(fault, self._reach, key, seconds))

    @property
    def parameters(self) -> tuple[str, ...]:
        """Dotted paths of the car's fields that faults change."""
        return tuple(sorted({target.name for _, target in self._targets(PARAMETER)}))

    @property
    def pending(self) -> bool:
        """Whether a fault is still waiting for its condition."""
        return any(active.watch is not None for active in self._faults)

    @property
    def _effects(self) -> list[Acting]:
        return [effect for active in self._faults for effect in active.effects]

    def _targets(self, *roles: str) -> list[tuple[Acting, Target]]:
        return [(effect, target) for effect in self._effects for target in effect.targets if target.role in roles]

    def observe(self, time: np.ndarray, outputs: Mapping[str, np.ndarray]) -> None:
        """Evaluate the conditions of pending faults on a piece of the run [s]; faults start at the next step."""
        for active in self._faults:
            if active.watch is not None and active.watch.held(time, outputs):
                step = float(time[-1] - time[-2]) if len(time) > 1 else getattr(self._reach.car, "step_time", 0.0)
                active.begin(float(time[-1]) + step)

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
        for effect, target in self._targets(PARAMETER, SURROUNDING):
            during = effect.active.during(time)
            if during.any():
                change = effect.change(time[during])
                name = f"parameters.{target.name}" if target.role == PARAMETER else target.name
                values = given.setdefault(name, _without_fault(target, time, usual))
                values[during] = change.gain * values[during] + change.offset
        return given

    def _through_ports(self, time: np.ndarray) -> dict[str, np.ndarray]:
        courses: dict[str, PortCourse] = {}
        for effect, target in self._targets(LOOP, ACTUATOR):
            during, place = effect.active.during(time), (effect, target.name)
            if during.any():
                course = courses.setdefault(target.name, PortCourse(time))
                change = effect.change(time[during])
                self._before[place] = course.add(during, change, self._before.get(place, Levels()))
            else:
                self._before[place] = courses[target.name].last if target.name in courses else Levels()
        parts = ("gain", "offset", "held")
        return {f"ports.{port}.{part}": getattr(course, part) for port, course in courses.items() for part in parts}

    def on_channel(self, name: str, time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        for effect, target in self._targets(SIGNAL):
            during = effect.active.during(time)
            if target.name == name and during.any():
                sensor = self._reach.sensors[name]
                time, values = effect.behaviour.on_channel(time, values, during, sensor, effect.chance)
        return time, values

    @property
    def windows(self) -> tuple[dict[str, Any], ...]:
        """Fault name, element, behaviour, start and end [s] of every effect; None if the fault did not start."""
        return tuple(effect.window for effect in self._effects)

    @property
    def provenance(self) -> tuple[dict[str, Any], ...]:
        """Complete description of every effect: window, behaviour with all numbers in SI units, and trigger."""
        return tuple(
            effect.window
            | {
                "targets": [f"{target.role} {target.name}" for target in effect.targets],
                "behaviour": described(effect.behaviour),
                "trigger": trigger_table(effect.active.fault.trigger),
            }
            for effect in self._effects
        )


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
