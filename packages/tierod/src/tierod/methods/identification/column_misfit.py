"""Common mistakes in recordings of a bench, and a held parameter that does not fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.identification.bench_recording import BenchRecording
from tierod.methods.identification.experiment import Estimate, Experiment, Free
from tierod.methods.identification.maximum_likelihood import MaximumLikelihood

# Increase of the log-likelihood per sample with a mistake corrected, above which the mistake is reported [nat]:
# parameters with an error of 50 % cost at most this much, a wrong sign ten times as much while the column moves
MARGIN = 2.0


# Signs of motor torque and of the three outputs, by the reversed signals; all four reversed are a mere convention
_TURNED = {
    "motor_torque": (-1, 1, 1, 1),
    "motor_angle_mechanical": (1, 1, -1, 1),
    "driver_torque": (1, 1, 1, -1),
    "steering_wheel_angle": (1, -1, 1, 1),
    "motor_torque and motor_angle_mechanical": (-1, 1, -1, 1),
    "motor_torque and driver_torque": (-1, 1, 1, -1),
    "motor_torque and steering_wheel_angle": (-1, -1, 1, 1),
}


_FACTORS = (0.1, 0.5, 2.0, 10.0)  # Candidate factors of a wrong time base


def refuse_slips(recording: BenchRecording, search: MaximumLikelihood) -> None:
    """Refuse a recording that is far more likely with a reversed sign or another time base.

    Args: search: with the start of the search; its noises should be enlarged.
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
        # Wrong parameters are no such mistake: with far too much friction the simulated motor stands still. All starts
        # of the search must therefore be less likely too.
        bound = min(surprise(experiment, at) for at in search.places()) - MARGIN
    if found[name] < min(bound, slower[factor]):
        turned = "signs of " if " and " in name else "sign of "
        raise InputError(
            f"{experiment.name}: the {turned}{name} cannot be right: the recording fits the column only when it is "
            "reversed; correct it in the channel map (left is positive everywhere, for the motor too)"
        )
    if slower[factor] < bound:
        step = 1e3 * recording.sample_time
        raise InputError(
            f"{experiment.name}: the time base cannot be right: the column of this vehicle fits samples "
            f"{step * factor:.3g} ms apart far better than the {step:.3g} ms of the time stamps; check the time "
            "stamps, or inertia and stiffness of the vehicle file"
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


# Increase of the log-likelihood per sample with another value of a fixed parameter, above which the parameter is
# reported [nat]: as much as a tenth less noise of one output gives, and a thousand times the effect of chance in 10 s
HELD_MARGIN = 0.1
# Changes of the logarithm of a fixed parameter that are tried: factors from 0.4 to 2.5
_SHIFTS = (-0.9, -0.45, -0.2, 0.2, 0.45, 0.9)


class Misfit(NamedTuple):
    """A fixed parameter that contradicts the recordings."""

    name: str
    held: float
    likelier: float  # value near which the recordings are more likely
    gain: float  # increase of the log-likelihood per sample [nat]


def misfit(
    search: MaximumLikelihood, estimate: Estimate, experiments: Sequence[Experiment], held: Sequence[str]
) -> Misfit | None:
    """The fixed parameter whose change increases the likelihood most; None if no change is significant.

    The score (the slope of the likelihood by a fixed parameter) is unreliable far from the maximum, where a failed fit
    may have ended. Every fixed parameter is therefore set to other values, with the estimated noises and with the free
    parameters at the end and at the start of the search; the best ones are then fitted together with the others.
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
    """Smallest cost with one fixed parameter at other values; its name, place, and the search in which it is free."""
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


# Number of the most likely fixed parameters that are freed in turn; steps of each search, enough to rank them
_FITTED, _STEPS = 3, 10
