"""Slips that a recording itself betrays: a sign the wrong way round, a time base that is off by a factor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.identification.bench_recording import BenchRecording
from tierod.methods.identification.experiment import Experiment
from tierod.methods.identification.maximum_likelihood import MaximumLikelihood

MARGIN = 2.0
"""Natural logarithm, per sample, by which a recording has to be likelier with a slip put right before the slip is
believed: parameters wrong by half cost as much at most, a wrong sign costs ten times as much where the column moves."""

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
