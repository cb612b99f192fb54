"""Simulation of a virtual car on a course, with its sensors and faults, into a recording; usual drives for studies."""

from __future__ import annotations

import dataclasses
import math
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tierod.core.block import tuning
from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import check_ranges, replaced
from tierod.core.graph.kernel import kernel
from tierod.core.graph.maths import Number
from tierod.core.graph.trace import initial_memory, trace
from tierod.core.recording import Channel, Recording
from tierod.core.toml import override
from tierod_lab.ground.cars.road_cars import EpsCar
from tierod_lab.ground.courses.course import FACTORS, AnyCondition, Course, Restlessness
from tierod_lab.ground.courses.manoeuvres import LockToLock
from tierod_lab.ground.courses.roads import AnyRoad, City, Country, Motorway, NaturalDrive
from tierod_lab.ground.faults import Course as LevelCourse
from tierod_lab.ground.faults import Fault, Schedule
from tierod_lab.ground.integration import Varied, path_of
from tierod_lab.ground.parts import Plant
from tierod_lab.ground.recorder import Readings, Recorder, channel_names, declared_units, generator, true_channels
from tierod_lab.ground.scatter import Scatter
from tierod_lab.ground.sensors import SensorSet


class Foresight:
    """Predicts distance [m] and speed [m/s] over one piece of a run, without a jump where the true values correct it.

    The driver model reads the curvature of the path at the predicted distance; a jump of a few centimetres there would
    become a jump of the steering target.
    """

    def __init__(self, distance: float, speed: float):
        self._distance, self._speed, self._acceleration = distance, speed, 0.0
        self._foreseen = distance, speed

    def look(self, distance: float, speed: float, after: float) -> None:
        """Correct the prediction by the true distance and speed, a time [s] after the last correction."""
        self._acceleration = (speed - self._speed) / after
        self._distance, self._speed = distance, speed

    def over(self, time: np.ndarray, until: float) -> tuple[np.ndarray, np.ndarray]:
        """Distance and speed at times since the last correction [s], whose jump fades linearly until the next one."""
        wrong = [seen - now for seen, now in zip(self._foreseen, (self._distance, self._speed), strict=True)]
        left = 1.0 - time / until
        self._foreseen = self._at(until)
        distance, speed = self._at(time)
        return distance + wrong[0] * left, speed + wrong[1] * left

    def _at(self, time: Number) -> tuple[Number, Number]:
        distance = self._distance + (self._speed + 0.5 * self._acceleration * time) * time
        return distance, self._speed + self._acceleration * time


LOOK = 0.2  # Interval at which the course is evaluated [s]; over it the distance is predicted to within a centimetre
WAITING_LOOK = 0.05  # The same interval while a fault waits for its condition [s]
LIMITS = {"truth_speed": 150.0, "yaw_rate": 30.0, "steering_wheel_rate": 1e3}
"""Limits of signals; a run has diverged where a signal exceeds them or is not finite."""
_SCATTER = 3  # Number of the scatter's random stream


@dataclass(frozen=True)
class Outcome:
    """Outcome of a run."""

    recording: Recording
    # last valid time of a diverged run [s], zero if no instant was valid; None for a run that did not diverge
    diverged_at: float | None = None
    windows: tuple[dict[str, Any], ...] = ()  # name, element, behaviour, start and end [s] of every effect of a fault
    reason: str = ""


def run(
    car: Plant,
    course: Course,
    seconds: float | None = None,
    seed: int = 0,
    sensors: SensorSet | None = None,
    faults: Iterable[Fault] = (),
    scatter: Scatter | None = None,
    metadata: Mapping[str, Any] | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Outcome:
    """Drive a car over a course.

    Args:
        seconds: duration [s]; that of the course if None
        seed: seed of all random numbers; sensors, scatter and faults use separate streams and do not affect each other
        sensors: sensors of the car; those of a production car if None; sensors of channels the car lacks are dropped
    """
    seconds = course.duration if seconds is None else seconds
    _require_fault_free(car, seconds)
    sensors = sensors or SensorSet.production()
    if scatter is not None:
        car, sensors = scatter.draw(car, sensors, generator(seed, _SCATTER))
    car = started(car, course)
    schedule = Schedule(faults, car, sensors, seed, seconds)
    drive = _Run(car, course, schedule)
    columns = channel_names(drive.block)
    readings = Readings({name: sensor for name, sensor in sensors.items() if name in columns}, seconds, seed)
    recorder = Recorder(columns, readings.instants, car.step_time, seconds)
    with drive.begun(seconds):
        diverged_at = drive.to_the_end(seconds, recorder, progress)
    truths = recorder.truths()
    described = declared_units(drive.kernel.graph.output_tree)
    channels = readings.channels(truths, schedule.on_channel, described)
    channels |= true_channels(truths, readings.sensors, described)
    if diverged_at is not None:
        channels = {name: _until(each, diverged_at) for name, each in channels.items()}
    provenance = {
        "source": "tierod virtual test vehicle",
        "car": type(car).__name__,
        "vehicle": dict(tuning(car)),
        "sensors": {name: dataclasses.asdict(sensor) for name, sensor in readings.sensors.items()},
        "faults": list(schedule.provenance),
        "course": course.name,
        "seed": seed,
        "seconds": seconds,
        "diverged_at": diverged_at,
    }
    recording = Recording(channels, provenance | dict(metadata or {}))
    return Outcome(recording, diverged_at, schedule.windows, drive.reason)


def started(car: Plant, course: Course) -> Plant:
    begun: Plant = replaced(car, {"start": course.start}) if hasattr(car, "start") else car
    return begun


def _require_fault_free(car: Plant, seconds: float) -> None:
    if not car.step_time <= seconds < math.inf:
        raise ParameterError(
            f"a run needs a positive, finite duration of at least {car.step_time:g} s, not {seconds} s"
        )
    check_ranges(car)
    if wrong := unequal_steps(car):
        raise ParameterError(wrong)


def unequal_steps(car: Plant) -> str:
    """Message about a part that is computed with another step than its car; "" if there is none."""
    for path, value in tuning(car):
        if path.endswith(".step_time") and value != car.step_time:
            of_car = f"{type(car).__name__} is computed every {car.step_time:g} s"
            return f"{of_car}, but its '{path}' is {value:g} s; make them equal"
    return ""


class _Run:
    def __init__(self, car: Plant, course: Course, schedule: Schedule):
        self.block = Varied(car, schedule.parameters) if schedule.parameters else car
        self.kernel, self.memory = kernel(self.block), initial_memory(self.block)
        self.course, self.schedule = course, schedule
        self.step_time = car.step_time
        self.ahead = getattr(getattr(car, "driver", None), "anticipation", 0.0)
        self.index = {path_of(name): column for column, name in enumerate(self.kernel.graph.sample)}
        own = dict(tuning(car))
        self.usual = np.array([_usual(name, own) for name in self.index])
        self.longest, self.waiting = (max(round(time / car.step_time), 1) for time in (LOOK, WAITING_LOOK))
        self.samples = np.empty((self.longest, len(self.index)))
        self.outputs = {name: columns[0] for name, columns in channel_names(self.block).items()}
        self.limits = [(self.outputs[name], limit) for name, limit in LIMITS.items() if name in self.outputs]
        # A unit of another tool may give the speed of its wheels only.
        self.speed = self.outputs.get("truth_speed", self.outputs.get("vehicle_speed", 0))
        self.car, self.reason = car, ""
        self.advance: Callable[[np.ndarray, np.ndarray, np.ndarray, int], int | None]
        self.advance = self.kernel.scan

    @contextmanager
    def begun(self, seconds: float) -> Iterator[None]:
        """Context of a run [s] that opens and closes the unit of another tool, if one computes the car."""
        make = getattr(self.car, "coupled", None)
        if make is None:
            yield
            return
        usual = dict(zip(self.index, self.usual, strict=True))
        with closing(make(self.block, usual, seconds)) as unit:
            self.advance = unit.scan
            try:
                yield
            finally:
                self.reason = unit.failure

    def to_the_end(self, seconds: float, recorder: Recorder, progress: Callable[[float], None]) -> float | None:
        """Simulate all pieces and return the last valid time if the run diverged."""
        count, done = round(seconds / self.step_time), 0
        foresight = Foresight(0.0, self.course.start.speed)
        while done < count:
            look = self.waiting if self.schedule.pending else self.longest
            size = min(look, count - done)
            time = np.arange(done, done + size) * self.step_time
            outputs = self._piece(time, *foresight.over(time - time[0], look * self.step_time), done)
            good = self._good(outputs) if len(outputs) else 0
            recorder.add(outputs[:good])
            if good < size:
                return float(max(done + good - 1, 0) * self.step_time)
            if self.schedule.pending:
                seen = {name: outputs[:, column] for name, column in self.outputs.items()}
                self.schedule.observe(time, seen)
            if "truth_distance" in self.outputs:
                # The last output precedes the first sample of the next piece by one step.
                distance = float(outputs[-1, self.outputs["truth_distance"]])
                speed = float(outputs[-1, self.speed])
                foresight.look(distance + speed * self.step_time, speed, size * self.step_time)
            done += size
            progress(done / count)
        return None

    def _piece(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray, done: int) -> np.ndarray:
        samples = self.samples[: len(time)]
        samples[:] = self.usual
        for name, values in self.course.columns(time, distance, speed, self.ahead).items():
            samples[:, self._column(name, f"the course '{self.course.name}'")] = values

        def said(name: str) -> np.ndarray:
            return samples[:, self._column(name, "a fault")]

        for name, values in self.schedule.inputs(time, said).items():
            said(name)[:] = values
        outputs = np.empty((len(time), len(self.kernel.graph.output)))
        rows = self.advance(self.memory, samples, outputs, done)
        return outputs[:rows]

    def _column(self, name: str, whose: str) -> int:
        if name not in self.index:
            raise ParameterError(
                f"{whose} sets '{name}', which {self.kernel.graph.name} does not have{nearest(name, self.index)}"
            )
        return self.index[name]

    def _good(self, outputs: np.ndarray) -> int:
        good = np.ones(len(outputs), bool)
        for column, limit in self.limits:
            good &= np.abs(outputs[:, column]) < limit
        # A state that is not finite stays so: only if the last row is affected must the others be searched.
        if not np.isfinite(outputs[-1]).all():
            good &= np.isfinite(outputs).all(axis=1)
        return len(outputs) if good.all() else int(np.argmin(good))


def usual_inputs(car: Plant) -> dict[str, float]:
    """Value of every input of a car that neither course nor fault sets."""
    own = dict(tuning(car))
    return {name: _usual(name, own) for name in trace(car).sample}


def _usual(name: str, own: Mapping[str, float]) -> float:
    if name.startswith("parameters."):
        return own[name.removeprefix("parameters.")]
    one = name in FACTORS or (name.startswith("ports.") and name.endswith(".gain"))
    return 1.0 if one else 0.0


def _until(each: Channel, end: float) -> Channel:
    kept = each.time <= end
    return replace(each, time=each.time[kept], values=each.values[kept])


@dataclass(frozen=True)
class FrictionCourse:
    """Level of dry friction over time: linear between corners, constant before the first and after the last."""

    times: tuple[float, ...]  # instants of the corners [s], not decreasing; two equal ones form a step
    levels: tuple[float, ...]  # friction torque at the column at each corner [N*m], not negative

    def __post_init__(self) -> None:
        times = self.times
        if not times or len(times) != len(self.levels):
            raise ParameterError(
                f"a friction course has {len(times)} times and {len(self.levels)} levels; give one level per time"
            )
        if list(times) != sorted(times):
            raise ParameterError(f"the times of a friction course run backwards: {times}; put them in order")
        if any(map(operator.eq, times, times[2:])):
            raise ParameterError(f"a friction course has three corners at one instant: {times}; leave the middle out")
        if not all(0.0 <= level < float("inf") for level in self.levels):
            raise ParameterError(f"friction levels must be finite and not negative, not {self.levels} N*m")

    @classmethod
    def constant(cls, level: float) -> FrictionCourse:
        """Course with the same level [N*m] at all times."""
        return cls((0.0,), (level,))

    @classmethod
    def step(cls, before: float, after: float, at: float) -> FrictionCourse:
        return cls((at, at), (before, after))

    def behaviour(self) -> LevelCourse:
        """The course as behaviour of a fault that acts from the start of the run."""
        times = np.array(self.times, dtype=float)
        step = np.flatnonzero(np.diff(times) == 0.0)
        # `LevelCourse` needs ascending times: a step starts a nanosecond early, which is between two samples.
        times[step] -= 1e-9
        return LevelCourse(tuple(times.tolist()), self.levels)


LEVEL = "steering.friction.level"  # Path of the car's parameter that a friction fault changes
CHANNELS = (
    "steering_wheel_angle",
    "steering_wheel_rate",
    "driver_torque",
    "motor_torque",
    "yaw_rate",
    "lateral_acceleration",
    "vehicle_speed",
)
"""Channels that the friction monitors need, as a production car with EPS sends them on its bus."""


def drive(
    vehicle: EpsCar | None = None,
    minutes: float = 13.0,
    friction: FrictionCourse | float | None = None,
    seed: int = 0,
    scatter: bool | Scatter = False,
    sensors: SensorSet | None = None,
    roads: Sequence[AnyRoad] = (City(), Country(), Motorway()),
    conditions: Sequence[AnyCondition] = (Restlessness(),),
) -> Recording:
    """Simulate a drive through city, country and motorway, recorded by production sensors.

    Args:
        vehicle: the car; a mid-size one with a two-track chassis if None
        minutes: duration [min]
        friction: level of dry friction at the column [N*m], constant or over time; that of the car if None
        seed: seed of all random numbers; route, sensors, scatter and faults use separate streams, so that the route of
            a seed does not depend on friction, car or sensors
        sensors: sensors of the car; those of a production car if None

    Returns:
        canonical channels at the rates of their sensors, and true values at 100 Hz in channels prefixed `truth_`;
        `truth_friction_torque` is the friction level that a monitor should estimate, `truth_friction_resistance` the
        signed friction torque
    """
    if not 0.0 < minutes < math.inf:
        raise ParameterError(f"a drive needs a positive duration, not {minutes} min")
    seconds = 60.0 * minutes
    course = NaturalDrive(
        name="natural drive", seed=seed, conditions=tuple(conditions), roads=tuple(roads), time=seconds
    )
    spread = Scatter() if scatter is True else scatter or None
    return _recorded(vehicle or EpsCar(), course, friction, seed, spread, sensors)


def lock_to_lock(
    friction: float,
    hoist: bool,
    vehicle: EpsCar | None = None,
    rate: float = 1.0,
    lock_angle: float = math.radians(570.0),
    seed: int = 0,
    sensors: SensorSet | None = None,
) -> Recording:
    """Simulate the slow turn of the standing car from the middle to the right lock, to the left one, and back.

    Args:
        friction: level of dry friction at the column [N*m]
        hoist: whether the wheels hang free; on the ground the tyres scrub
        vehicle: the car; a mid-size one if None
        rate: maximum rate of the steering wheel [rad/s]; each stroke is half a cosine
        lock_angle: steering wheel angle at the locks [rad]
        sensors: sensors of the car; those of a production car if None

    Source: Mohtat et al., Appendix A: 0, -570, +570, 0 degrees.
    """
    if not (rate > 0.0 and lock_angle > 0.0):
        raise ParameterError(f"lock to lock needs a positive rate and angle, not {rate} rad/s and {lock_angle} rad")
    course = LockToLock(name="lock to lock", lock_angle=lock_angle, rate=rate, load=0.0 if hoist else 1.0)
    return _recorded(vehicle or EpsCar(), course, friction, seed, None, sensors, {"hoist": hoist})


def _recorded(
    car: EpsCar,
    course: Course,
    friction: FrictionCourse | float | None,
    seed: int,
    scatter: Scatter | None,
    sensors: SensorSet | None,
    metadata: dict[str, Any] | None = None,
) -> Recording:
    level = dict(tuning(car))[LEVEL] if friction is None else friction
    levels = level if isinstance(level, FrictionCourse) else FrictionCourse.constant(float(level))
    car = override(car, {LEVEL: float(levels.levels[0])})
    faults = () if len(set(levels.levels)) == 1 else (Fault(element=LEVEL, behaviour=levels.behaviour()),)
    measured = SensorSet.production().only(CHANNELS) if sensors is None else sensors
    drawn = course.stretches if isinstance(course, NaturalDrive) else ()
    stretches = [(place, type(kind).__name__.lower()) for place, kind in drawn] or None  # (start [m], kind) of each
    said = {"friction": dataclasses.asdict(levels), "stretches": stretches} | (metadata or {})
    outcome = run(car, course, None, seed, measured, faults, scatter, said)
    if outcome.diverged_at is not None:
        diverged = f"the drive with seed {seed} diverged after {outcome.diverged_at:.2f} s"
        advice = "check its parameters, or take `run`, which keeps what was recorded until then"
        raise ParameterError(f"{diverged}: the car left the road for good; {advice}")
    return outcome.recording
