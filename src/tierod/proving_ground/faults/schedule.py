"""All faults of one run: what they do to the car while it drives, and to the channels afterwards."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from tierod.errors import ParameterError
from tierod.proving_ground.faults import triggers
from tierod.proving_ground.faults.active import Active, prepared
from tierod.proving_ground.faults.behaviour import ACTUATOR, LOOP, PARAMETER, SIGNAL, SURROUNDING
from tierod.proving_ground.faults.behaviours import described
from tierod.proving_ground.faults.elements import Reach, Target
from tierod.proving_ground.faults.fault import Fault
from tierod.proving_ground.sensors import SensorSet
from tierod.toml_builder import kind_name

_STREAM = 4
"""The stream of chance of faults, apart from those of road, driver, sensors and scatter."""

Usual = Callable[[str], np.ndarray]


class Schedule:
    """The faults of one run.

    A signal that is recorded and also read by a control unit of the car gets the fault in both places: at the same
    times, and with the same random numbers where the instants are the same. In a loop a lost frame means the value
    before; a delay and a bit flip are refused there, since neither is a factor, an offset or a held value. Faults of
    recorded signals come after the sensor, and what they give is rounded and limited as the sensor's own readings.
    A fault that waits for a condition begins with the piece of the run after the one in which the condition came true.

    Args:
        faults: several at once are applied in order
        car: that is driven, as it was drawn if there is scatter
        sensors: that read it
        seed: of the run
        seconds: duration of the run [s]

    Raises:
        ParameterError: a fault that does not fit the car, its sensors or the run; with file and line if it has them
    """

    def __init__(self, faults: Iterable[Fault], car: Any, sensors: SensorSet, seed: int, seconds: float):
        self.seconds = seconds
        self._reach = Reach(car, sensors)
        self._faults: list[Active] = []
        counts: Counter[int] = Counter()
        for fault in faults:
            name = zlib.crc32(fault.label.encode())
            key = (seed, _STREAM, name, counts[name])
            counts[name] += 1
            self._faults.append(prepared(fault, self._reach, key, seconds))

    @property
    def parameters(self) -> tuple[str, ...]:
        """Dotted paths of the fields of the car that faults change."""
        return tuple(sorted({target.name for _, target in self._targets(PARAMETER)}))

    @property
    def pending(self) -> bool:
        """Whether a fault still waits for its condition."""
        return any(active.watch is not None for active in self._faults)

    def _targets(self, *roles: str) -> list[tuple[tuple[Active, int], Target]]:
        """((fault, number of its effect), target) of everything of these roles, in order."""
        return [
            ((active, number), target)
            for active in self._faults
            for number, change in enumerate(active.changes)
            for target in change.targets
            if target.role in roles
        ]

    def observe(self, time: np.ndarray, outputs: Mapping[str, np.ndarray]) -> None:
        """Look at a piece of the run for what begins faults; they act from the next step on.

        Args:
            time: of the piece [s]
            outputs: every channel of the car at these times
        """
        for active in self._faults:
            if active.watch is not None and active.watch.held(time, outputs):
                step = float(time[-1] - time[-2]) if len(time) > 1 else getattr(self._reach.car, "step_time", 0.0)
                active.begin(float(time[-1]) + step, self.seconds)

    def inputs(self, time: np.ndarray, usual: Usual | None = None) -> dict[str, np.ndarray]:
        """What faults give the car at the steps of the next piece; only what differs from a sound car.

        Args:
            time: of the steps [s]
            usual: gives what the course says about an input of the car, shape of `time`; needed where a fault changes
                what is around the car

        Returns:
            "ports.NAME.gain", ".offset", ".held", "parameters.PATH", and inputs of the car such as
            "road.adhesion_left"; shape of `time` each
        """
        given: dict[str, np.ndarray] = {}
        for (active, number), target in self._targets(LOOP, ACTUATOR, PARAMETER, SURROUNDING):
            during = active.during(time)
            if not during.any():
                continue
            since = time[during] - active.start
            change = active.changes[number].behaviour.change(since, active.chances[number])
            for name, start in _started(target, time, usual):
                given.setdefault(name, start)
            if target.role in (LOOP, ACTUATOR):
                gain, offset, held = (given[f"ports.{target.name}.{part}"] for part in ("gain", "offset", "held"))
                gain[during] *= change.gain
                offset[during] = change.gain * offset[during] + change.offset
                held[during] = np.where(change.held, 1.0, held[during])
                held[time <= 0.0] = 0.0
            else:
                values = given[_input(target)]
                values[during] = change.gain * values[during] + change.offset
        return given

    def on_channel(self, name: str, time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A recorded channel with its faults.

        Args:
            name: canonical
            time: stamps [s]
            values: readings of its sensor

        Returns:
            (stamps, readings)
        """
        for (active, number), target in self._targets(SIGNAL):
            during = active.during(time)
            if target.name == name and during.any():
                behaviour, sensor = active.changes[number].behaviour, self._reach.sensors[name]
                time, values = behaviour.on_channel(time, values, during, sensor, active.chances[number])
        return time, values

    @property
    def windows(self) -> tuple[dict[str, Any], ...]:
        """Every effect as it came: name of the fault, element, behaviour, start and end [s], None if it did not."""
        return tuple(
            {
                "name": active.fault.label,
                "element": change.targets[0].name,
                "behaviour": kind_name(type(change.behaviour)),
                "start": active.start,
                "end": None if active.start is None else active.end,
            }
            for active in self._faults
            for change in active.changes
        )

    @property
    def provenance(self) -> tuple[dict[str, Any], ...]:
        """Every effect whole: its window, its behaviour with all numbers in SI units, its trigger."""
        changes = [(active, change) for active in self._faults for change in active.changes]
        return tuple(
            window
            | {
                "targets": [f"{target.role} {target.name}" for target in change.targets],
                "behaviour": described(change.behaviour),
                "trigger": triggers.described(active.fault.trigger),
            }
            for window, (active, change) in zip(self.windows, changes, strict=True)
        )


def _input(target: Target) -> str:
    return f"parameters.{target.name}" if target.role == PARAMETER else target.name


def _started(target: Target, time: np.ndarray, usual: Usual | None) -> list[tuple[str, np.ndarray]]:
    """(input, value without fault) of what a target goes through."""
    if target.role in (LOOP, ACTUATOR):
        parts = (("gain", 1.0), ("offset", 0.0), ("held", 0.0))
        return [(f"ports.{target.name}.{part}", np.full(len(time), value)) for part, value in parts]
    if target.role == PARAMETER:
        return [(_input(target), np.full(len(time), target.usual))]
    if usual is None:
        raise ParameterError(f"a fault of '{target.name}' needs to know what the course says; give `usual`")
    return [(_input(target), np.array(usual(target.name), dtype=float))]
