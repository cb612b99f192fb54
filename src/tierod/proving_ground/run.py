"""Run a virtual car over a course, with its sensors and faults, into a recording."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from tierod.core.block import tuning
from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import check_ranges, replaced
from tierod.core.graph.kernel import kernel
from tierod.core.graph.maths import Number
from tierod.core.graph.trace import initial_memory, trace
from tierod.core.recording import Channel, Recording
from tierod.proving_ground.courses import Course
from tierod.proving_ground.courses.course import FACTORS
from tierod.proving_ground.faults import Fault, Schedule
from tierod.proving_ground.parts import Plant
from tierod.proving_ground.recorder import Readings, Recorder, channel_names, declared_units, generator, true_channels
from tierod.proving_ground.scatter import Scatter
from tierod.proving_ground.sensors import Sensor, SensorSet
from tierod.proving_ground.varied import Varied, path_of


class Foresight:
    """Distance and speed foreseen from look to look, without a jump where a look corrects them.

    A driver reads the curvature of the path there: a jump of a few centimetres would be one of the steering's target.

    Args:
        distance: along the path at the beginning [m]
        speed: at the beginning [m/s]
    """

    def __init__(self, distance: float, speed: float):
        self._distance, self._speed, self._acceleration = distance, speed, 0.0
        self._foreseen = distance, speed

    def look(self, distance: float, speed: float, after: float) -> None:
        """Set the true place of the car.

        Args:
            distance: along the path [m]
            speed: [m/s]
            after: time since the last look [s]
        """
        self._acceleration = (speed - self._speed) / after
        self._distance, self._speed = distance, speed

    def over(self, time: np.ndarray, until: float) -> tuple[np.ndarray, np.ndarray]:
        """Distance [m] and speed [m/s] at instants after the last look; what was foreseen wrongly fades until the next.

        Args:
            time: since the last look [s], (n,)
            until: time of the next look [s]
        """
        wrong = [seen - now for seen, now in zip(self._foreseen, (self._distance, self._speed), strict=True)]
        left = 1.0 - time / until
        self._foreseen = self._at(until)
        distance, speed = self._at(time)
        return distance + wrong[0] * left, speed + wrong[1] * left

    def _at(self, time: Number) -> tuple[Number, Number]:
        distance = self._distance + (self._speed + 0.5 * self._acceleration * time) * time
        return distance, self._speed + self._acceleration * time


LOOK = 0.2
"""Between two looks at the course [s]; over that time the distance is foreseen to a centimetre."""
WAITING_LOOK = 0.05
"""Between two looks while a fault waits for its condition [s]."""

LIMITS = {"truth_speed": 150.0, "yaw_rate": 30.0, "steering_wheel_rate": 1e3}
"""A run has diverged where a signal leaves these limits or is no longer finite."""

_SCATTER = 3


@dataclass(frozen=True)
class Outcome:
    """Outcome of a run.

    Args:
        recording: measured channels, and the truth in channels prefixed `truth_`
        diverged_at: last good time of a run that did not stay finite [s], zero where no instant was good; None where
            all went well
        windows: every fault as it came: name, element, behaviour, start and end [s]
        reason: why it ended early, where more is known than that it diverged
    """

    recording: Recording
    diverged_at: float | None = None
    windows: tuple[dict[str, Any], ...] = ()
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
        car: a plant block of `tierod.proving_ground.cars`
        course: what is asked of car and driver
        seconds: duration [s]; the course's own where None
        seed: of all chance; sensors, scatter and faults draw from streams of their own, so that one does not move the
            other
        sensors: those of a production car where None; channels that the car does not have are left out
        faults: changes from outside, see `tierod.proving_ground.faults`
        scatter: how car and sensors are drawn around the given ones
        metadata: kept in the recording beside what is written there anyway
        progress: called with the share that is done

    Raises:
        ParameterError: no finite duration of at least a step; a step too long, or parts of the car that keep different
            ones; a fault, sensor or course that does not fit the car
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
    provenance = _provenance(car, readings.sensors, schedule)
    provenance |= {"course": course.name, "seed": seed, "seconds": seconds, "diverged_at": diverged_at}
    recording = Recording(channels, provenance | dict(metadata or {}))
    return Outcome(recording, diverged_at, schedule.windows, drive.reason)


def started(car: Plant, course: Course) -> Plant:
    """A car that begins as a course does.

    Args:
        car: a plant block
        course: with its start
    """
    begun: Plant = replaced(car, {"start": course.start}) if hasattr(car, "start") else car
    return begun


def _provenance(car: Plant, sensors: Mapping[str, Sensor], schedule: Schedule) -> dict[str, Any]:
    return {
        "source": "tierod virtual test vehicle",
        "car": type(car).__name__,
        "vehicle": dict(tuning(car)),
        "sensors": {name: dataclasses.asdict(sensor) for name, sensor in sensors.items()},
        "faults": list(schedule.provenance),
    }


def _require_fault_free(car: Plant, seconds: float) -> None:
    if not car.step_time <= seconds < math.inf:
        raise ParameterError(
            f"a run needs a positive, finite duration of at least {car.step_time:g} s, not {seconds} s"
        )
    check_ranges(car)
    for path, value in tuning(car):
        if path.endswith(".step_time") and value != car.step_time:
            raise ParameterError(
                f"{type(car).__name__} is computed every {car.step_time:g} s, but its '{path}' says {value:g} s; "
                "make them equal"
            )


class _Run:
    """A car on its way: kernel, memory, and what acts on the car in the next piece."""

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
        # A unit of another tool may have the speed of its wheels alone.
        self.speed = self.outputs.get("truth_speed", self.outputs.get("vehicle_speed", 0))
        self.car, self.reason = car, ""
        self.advance: Callable[[np.ndarray, np.ndarray, np.ndarray, int], int | None]
        self.advance = self.kernel.scan

    @contextmanager
    def begun(self, seconds: float) -> Iterator[None]:
        """The run with another tool's unit that computes the vehicle, if there is one; the unit is closed behind it.

        Args:
            seconds: duration [s]
        """
        make = getattr(self.car, "coupled", None)
        if make is None:
            yield
            return
        usual, graph = dict(zip(self.index, self.usual, strict=True)), self.kernel.graph
        shape = (self.longest, len(graph.sample), len(graph.output))
        with closing(make(self.block, usual, seconds, shape)) as unit:
            self.advance = unit.scan
            try:
                yield
            finally:
                self.reason = unit.failure

    def to_the_end(self, seconds: float, recorder: Recorder, progress: Callable[[float], None]) -> float | None:
        """All pieces; the last good time if the run diverged."""
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
                distance = float(outputs[-1, self.outputs["truth_distance"]])
                speed = float(outputs[-1, self.speed])
                foresight.look(distance + speed * self.step_time, speed, size * self.step_time)
            done += size
            progress(done / count)
        return None

    def _piece(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray, done: int) -> np.ndarray:
        samples = self.samples[: len(time)]
        samples[:] = self.usual
        self._set(samples, self.course.columns(time, distance, speed, self.ahead), f"the course '{self.course.name}'")
        said = partial(self._said, samples)
        self._set(samples, self.schedule.inputs(time, said), "a fault")
        outputs = np.empty((len(time), len(self.kernel.graph.output)))
        rows = self.advance(self.memory, samples, outputs, done)
        return outputs[:rows]

    def _set(self, samples: np.ndarray, columns: Mapping[str, np.ndarray], whose: str) -> None:
        for name, values in columns.items():
            samples[:, self._column(name, whose)] = values

    def _said(self, samples: np.ndarray, name: str) -> np.ndarray:
        return samples[:, self._column(name, "a fault")]

    def _column(self, name: str, whose: str) -> int:
        if name not in self.index:
            raise ParameterError(
                f"{whose} sets '{name}', which {self.kernel.graph.name} does not have{nearest(name, self.index)}"
            )
        return self.index[name]

    def _good(self, outputs: np.ndarray) -> int:
        """Number of rows within the limits and finite; what a state has lost stays lost until the last row."""
        good = np.ones(len(outputs), bool)
        for column, limit in self.limits:
            good &= np.abs(outputs[:, column]) < limit
        if not np.isfinite(outputs[-1]).all():
            good &= np.isfinite(outputs).all(axis=1)
        return len(outputs) if good.all() else int(np.argmin(good))


def usual_inputs(car: Plant) -> dict[str, float]:
    """Values of every input of a car where neither course nor fault sets it.

    Args:
        car: a plant block of `tierod.proving_ground.cars`
    """
    own = dict(tuning(car))
    return {name: _usual(name, own) for name in trace(car).sample}


def _usual(name: str, own: Mapping[str, float]) -> float:
    """Value of an input where neither course nor fault sets it."""
    if name.startswith("parameters."):
        return own[name.removeprefix("parameters.")]
    one = name in FACTORS or (name.startswith("ports.") and name.endswith(".gain"))
    return 1.0 if one else 0.0


def _until(each: Channel, end: float) -> Channel:
    kept = each.time <= end
    return replace(each, time=each.time[kept], values=each.values[kept])
