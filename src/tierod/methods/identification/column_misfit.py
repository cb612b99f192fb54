"""Misfits between recordings of a column and its vehicle file: a sign, the time base, a held parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.identification.bench_recording import BenchRecording
from tierod.methods.identification.experiment import Estimate, Experiment, Free
from tierod.methods.identification.maximum_likelihood import MaximumLikelihood

MARGIN = 2.0
"""Natural logarithm, per sample, by which a recording has to be likelier with a slip put right before the slip is
assumed: parameters wrong by half cost as much at most, a wrong sign costs ten times as much where the column moves."""

_TURNED = {
    "motor_torque": (-1, 1, 1, 1),
    "motor_angle_mechanical": (1, 1, -1, 1),
    "driver_torque": (1, 1, 1, -1),
    "steering_wheel_angle": (1, -1, 1, 1),
    "motor_torque and motor_angle_mechanical": (-1, 1, -1, 1),
    "motor_torque and driver_torque": (-1, 1, 1, -1),
    "motor_torque and steering_wheel_angle": (-1, -1, 1, 1),
}
"""Signs of motor torque and of the three outputs, by what is turned; all four turned is no slip but a convention."""
_FACTORS = (0.1, 0.5, 2.0, 10.0)


def refuse_slips(recording: BenchRecording, search: MaximumLikelihood) -> None:
    """Refuse a recording that would be far likelier with a sign turned or another time base.

    Args:
        recording: to be looked at
        search: where the search starts; its noises should be wide

    Raises:
        InputError: the slip is named, and what to do
    """
    experiment, place = recording.experiment, search.start()

    def surprise(changed: Experiment, at: np.ndarray = place) -> float:
        return search.cost(at, [changed]) / len(changed.inputs)

    found = {
        name: surprise(_turned(experiment, signs))
        for name, signs in _TURNED.items()
        if not (recording.locked and "steering_wheel_angle" in name)
    }
    slower = {factor: surprise(_slower(experiment, factor)) for factor in _FACTORS}
    name, factor = min(found, key=found.__getitem__), min(slower, key=slower.__getitem__)
    bound = surprise(experiment) - MARGIN
    if min(found[name], slower[factor]) < bound:
        # Rough parameters are no slip: friction far too high holds a motor that in truth turns.
        bound = min(surprise(experiment, at) for at in search.places()) - MARGIN
    if found[name] < min(bound, slower[factor]):
        turned = "signs of " if " and " in name else "sign of "
        raise InputError(
            f"{experiment.name}: the {turned}{name} cannot be right: turned round, the recording fits the column, as "
            "it is it does not; correct it in the channel map (left is positive everywhere, for the motor too)"
        )
    if slower[factor] < bound:
        step = 1e3 * recording.sample_time
        raise InputError(
            f"{experiment.name}: the time base cannot be right: the column of this vehicle fits samples "
            f"{step * factor:.3g} ms apart far better than the {step:.3g} ms that the stamps say; check the stamps, or "
            "inertia and stiffness of the vehicle file"
        )


def _turned(experiment: Experiment, signs: Sequence[int]) -> Experiment:
    motor, wheel, rotor, bar = signs
    by_state = np.array([wheel, rotor, bar, wheel, rotor, bar, 1.0])
    return replace(
        experiment,
        inputs=experiment.inputs * motor,
        measured=experiment.measured * np.array([wheel, rotor, bar]),
        initial_mean=tuple((np.array(experiment.initial_mean) * by_state).tolist()),
    )


def _slower(experiment: Experiment, factor: float) -> Experiment:
    setting = {**experiment.setting, "sample_time": experiment.setting["sample_time"] * factor}
    return replace(experiment, setting=setting)


HELD_MARGIN = 0.1
"""Natural logarithm, per sample, by which recordings have to be likelier with a held parameter at another value before
the parameter is named: what a tenth less noise in one output makes, and a thousand times what chance makes in 10 s."""
_SHIFTS = (-0.9, -0.45, -0.2, 0.2, 0.45, 0.9)
"""Of the logarithm: factors from 0.4 to 2.5."""
_FITTED, _STEPS = 3, 10
"""Parameters that are looked for beside the others, the likeliest, and steps of each search: enough to rank them."""


class Misfit(NamedTuple):
    """A held parameter that does not fit.

    Args:
        name: of the parameter
        held: value at which it was held
        likelier: value near which the recordings are likelier
        gain: natural logarithm of how much, per sample
    """

    name: str
    held: float
    likelier: float
    gain: float


def misfit(
    search: MaximumLikelihood, estimate: Estimate, experiments: Sequence[Experiment], held: Sequence[str]
) -> Misfit | None:
    """The held parameter of which another value makes the recordings likelier by most; None where none does by much.

    The score, the slope of the likelihood by a held parameter, is no guide as far away as a fit that failed may be. So
    every held parameter is put to other values, with the noises that were found and with the free parameters where the
    search ended and where it began; those that do best are then looked for beside the others.

    Args:
        search: that led to the estimate
        estimate: where it ended
        experiments: that were fitted
        held: parameters that may be wrong, all positive
    """
    samples = sum(len(each.inputs) for each in experiments)
    tried = [_best(search, estimate, experiments, name) for name in held if name not in estimate.names]
    found = []
    for _, name, place, wider in sorted(tried, key=lambda each: each[0])[:_FITTED]:
        fitted = wider.fit(experiments, place)
        gain = (estimate.cost - fitted.cost) / samples
        found.append(Misfit(name, float(getattr(search.parameters, name)), fitted[name], gain))
    worst = max(found, key=lambda each: each.gain, default=None)
    return worst if worst and worst.gain > HELD_MARGIN else None


def _best(
    search: MaximumLikelihood, estimate: Estimate, experiments: Sequence[Experiment], name: str
) -> tuple[float, str, np.ndarray, MaximumLikelihood]:
    """The least cost with one held parameter at other values; name, place, and the search in which it is free."""
    free = (*search.free, Free(name))
    wider = replace(search, free=free, starts=(), most_steps=_STEPS, begin_again=0)
    end, count = wider.place_of(estimate), len(free)
    places = []
    for place in (end, np.concatenate([wider.start()[:count], end[count:]])):
        for shift in _SHIFTS:
            moved = place.copy()
            moved[count - 1] += shift
            places.append(moved)
    costs = [wider.cost(place, experiments) for place in places]
    least = int(np.argmin(costs))
    return costs[least], name, places[least], wider
