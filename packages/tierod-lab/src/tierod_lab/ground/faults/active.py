"""A fault prepared for one run: checked against car and sensors, with its trigger, window and random numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError, nearest
from tierod_lab.ground.faults.behaviour import SIGNAL, Behaviour, Chance, Change
from tierod_lab.ground.faults.behaviours import Course
from tierod_lab.ground.faults.elements import MisfitError, Reach, Target
from tierod_lab.ground.faults.fault import AtDistance, AtTime, Comparison, Effect, Fault, When, Within, resolved

DISTANCE = "truth_distance"  # Channel of the distance that the car has travelled


class Watch:
    """Evaluates a condition on the outputs of a car, piece by piece, until it has held for long enough."""

    def __init__(self, trigger: AtDistance | When, reach: Reach):
        self.hold = 0.0 if isinstance(trigger, AtDistance) else trigger.hold
        self.comparisons: list[tuple[Comparison, str]] = []
        self.since: float | None = None
        if isinstance(trigger, AtDistance):
            wanted: tuple[Comparison, ...] = (Comparison(DISTANCE, False, ">=", trigger.distance, "m"),)
        else:
            wanted = trigger.comparisons
        for comparison in wanted:
            name = comparison.signal
            if name not in reach.outputs:
                raise ParameterError(f"the car has no channel '{name}' to wait for{nearest(name, reach.outputs)}")
            unit = reach.outputs[name] or ""
            try:
                comparison.holds(np.zeros(1), unit)
            except InputError as error:
                raise ParameterError(
                    f"'{name}' cannot be held against {comparison.value:g} {comparison.unit}: {error}"
                ) from None
            self.comparisons.append((comparison, unit))

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


_LOOP_RATE = 1000.0  # Sampling rate of the control loops [Hz]
_EARLY = 1e-9  # Tolerance for rounding of the time of a run [s]


class AimedEffect(NamedTuple):
    """One effect of a fault: a behaviour with amounts in the unit of its targets."""

    behaviour: Behaviour
    targets: tuple[Target, ...]


class Active:
    """State of a fault during a run: its window and its random numbers.

    Args:
        rates: sampling rate of the target of every effect [Hz]
    """

    def __init__(self, fault: Fault, effects: tuple[AimedEffect, ...], key: tuple[int, ...], rates: tuple[float, ...]):
        self.fault, self.effects, self.key, self.rates = fault, effects, key, rates
        self.start: float | None = None
        self.end = np.inf
        self.watch: Watch | None = None
        self.chances: tuple[Chance, ...] = ()

    def begin(self, start: float, seconds: float) -> None:
        """Start the fault.

        Args:
            start: time of the onset [s]
            seconds: end of the run [s]
        """
        lasts = _lasts(self.fault)
        self.start, self.watch = start, None
        self.end = seconds if lasts is None else min(start + lasts, seconds)
        self.chances = tuple(
            Chance((*self.key, number), start, self.end - start, rate) for number, rate in enumerate(self.rates)
        )

    def during(self, time: np.ndarray) -> np.ndarray:
        """Whether the fault is active at given times [s]."""
        if self.start is None:
            return np.zeros(len(time), dtype=bool)
        return (time >= self.start - _EARLY) & (time < self.end - _EARLY)

    def change(self, number: int, time: np.ndarray) -> Change:
        return self.effects[number].behaviour.change(time - self.start, self.chances[number])


def prepared(fault: Fault, reach: Reach, key: tuple[int, ...], seconds: float) -> Active:
    """Prepare a fault for a run.

    Args:
        seconds: duration of the run [s]
    """
    found = (_aimed(fault, each, reach, seconds) for each in fault.effects)
    effects = tuple(effect for effect in found if effect.targets)
    if not effects:
        raise fault.error("element", reach.nothing_of(each.element for each in fault.effects))
    _check_duration(fault, reach)
    active = Active(fault, effects, key, tuple(_rate(effect, reach) for effect in effects))
    trigger = fault.trigger
    if isinstance(trigger, AtDistance | When):
        try:
            active.watch = Watch(trigger, reach)
        except ParameterError as error:
            raise fault.error("trigger", str(error)) from None
    else:
        active.begin(_start(fault, key, seconds), seconds)
    return active


def _check_duration(fault: Fault, reach: Reach) -> None:
    step = getattr(reach.car, "step_time", 0.0)
    if fault.duration is not None and fault.duration < step:
        message = f"the fault lasts {fault.duration:g} s, less than a step of the car, {step:g} s; let it last longer"
        raise fault.error("duration", message)


def _aimed(fault: Fault, effect: Effect, reach: Reach, seconds: float) -> AimedEffect:
    try:
        targets = reach.targets(effect.element, effect.behaviour)
    except MisfitError as error:
        raise fault.error("behaviour", str(error), effect) from None
    except ParameterError as error:
        raise fault.error("element", str(error), effect) from None
    behaviour = resolved(fault, effect, targets[0].unit) if targets else effect.behaviour
    for target in targets:
        if target.role == SIGNAL and (wrong := _wrong_reading(behaviour, reach, target)):
            raise fault.error("behaviour", wrong, effect)
        if target.limits is not None and (wrong := _out_of_range(fault, behaviour, target, seconds)):
            raise fault.error("size", wrong, effect)
    return AimedEffect(behaviour, targets)


def _wrong_reading(behaviour: Behaviour, reach: Reach, target: Target) -> str:
    """Reason why a recorded channel cannot behave so, such as a bit flip without a quantum; "" if it can."""
    nothing = np.empty(0)
    try:
        behaviour.on_channel(nothing, nothing, nothing > 0.0, reach.sensors[target.name], Chance((0,), 0.0, 0.0))
    except ParameterError as error:
        return str(error)
    return ""


def _out_of_range(fault: Fault, behaviour: Behaviour, target: Target, seconds: float) -> str:
    """Message if a fault takes a parameter or the surroundings out of range, considered alone; "" if none does."""
    assert target.limits is not None
    core = behaviour.core
    # Samples suffice: ramps and drifts are extreme at their ends, a course at its corners.
    since = np.linspace(0.0, _longest(fault, seconds), 101)
    if isinstance(core, Course):
        since = np.union1d(since, [time for time in core.times if 0.0 <= time <= since[-1]])
    change = core.change(since, Chance((0,), 0.0, 0.0))
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
    return max(min(_lasts(fault) or seconds, seconds - start), 0.0)


def _lasts(fault: Fault) -> float | None:
    """Duration of a fault [s]; None until the end of the run."""
    return fault.duration or fault.behaviour.usual_duration


def _rate(effect: AimedEffect, reach: Reach) -> float:
    names = [target.name for target in effect.targets if target.role == SIGNAL]
    return reach.sensors[names[0]].rate if names else _LOOP_RATE


def _start(fault: Fault, key: tuple[int, ...], seconds: float) -> float:
    trigger: Any = fault.trigger
    if isinstance(trigger, Within):
        start, latest = float(np.random.default_rng(key).uniform(trigger.earliest, trigger.latest)), trigger.latest
    else:
        start = latest = trigger.time if isinstance(trigger, AtTime) else 0.0
    if not latest < seconds:
        raise fault.error(
            "trigger", f"the fault begins at {latest:g} s, but the run ends at {seconds:g} s; begin earlier"
        )
    return start
