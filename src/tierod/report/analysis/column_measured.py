"""The frequency response of a column from a recording of its bench, beside that of its model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tierod.analysis.frequency_response import frequency_response
from tierod.analysis.measured_response import MeasuredResponse, measured_response
from tierod.errors import InputError
from tierod.models.linear import LinearSystem
from tierod.recording import Recording

INPUTS = ("motor_torque", "motor_target_torque")
"""The torque of the motor, or what it was asked for."""

LOWEST = 0.5
"""Frequencies below are left out: there the free column drifts [Hz]."""

_GAP = 3.5
_MORE = 1.5
_FEWEST, _USUAL = 5, 200.0


@dataclass(frozen=True, eq=False)
class Measured:
    """Measured and computed responses from the motor's torque.

    Args:
        input: signal that was taken for the torque of the motor
        rate: at which the signals were compared [Hz]
        responses: measured, by output
        model: complex gain of the linear column at the same frequencies, by output
        remarks: what a reader must know
    """

    input: str
    rate: float
    responses: Mapping[str, MeasuredResponse]
    model: Mapping[str, np.ndarray]
    remarks: tuple[str, ...]

    def document(self) -> dict[str, Any]:
        """As data for JSON."""
        return {
            "input": self.input,
            "rate": self.rate,
            "responses": {
                name: {
                    "frequency": response.frequency.tolist(),
                    "gain": np.abs(response.gain).tolist(),
                    "phase": np.angle(response.gain).tolist(),
                    "relative_deviation": response.relative_deviation.tolist(),
                    "coherence": response.coherence.tolist(),
                    "model_gain": np.abs(self.model[name]).tolist(),
                    "model_phase": np.angle(self.model[name]).tolist(),
                }
                for name, response in self.responses.items()
            },
        }


def measured_column(recording: Recording, system: LinearSystem) -> Measured:
    """Responses from the motor's torque to every sensor that the recording has.

    Args:
        recording: with `motor_torque` or `motor_target_torque`, and at least one sensor of the column
        system: linear column

    Raises:
        InputError: no torque of the motor, one that does not move, no sensor, or hardly a frequency that they tell of
    """
    given = next((name for name in INPUTS if name in recording), None)
    outputs = [name for name in system.outputs if name in recording]
    if given is None or not outputs:
        lacking = " or ".join(INPUTS) if given is None else " or ".join(system.outputs)
        raise InputError(f"the recording has no {lacking}, which a frequency response needs; give a channel map")
    rate = min(_rate(recording, name) for name in (given, *outputs))
    aligned = recording.align((given, *outputs), rate, "linear", maximum_age=_GAP / rate)
    torque = aligned.values[:, 0]
    if not np.nanmax(np.abs(torque), initial=0.0) > 0.0 or np.nanstd(torque) == 0.0:
        raise InputError(f"{given} of the recording does not move; a frequency response needs a sweep or noise")
    responses = {
        name: measured_response(torque, aligned.values[:, column + 1], rate) for column, name in enumerate(outputs)
    }
    highest = min(_MORE * max(_highest(each) for each in responses.values()), 0.4 * rate)
    responses = {name: each.between(LOWEST, highest) for name, each in responses.items()}
    frequency = next(iter(responses.values())).frequency
    if len(frequency) < _FEWEST:
        raise InputError(
            f"the recording tells of hardly a frequency above {LOWEST:g} Hz: its signals come at {rate:.4g} Hz, or do "
            f"not follow the motor; record at {_USUAL:g} Hz or more, and sweep the motor's torque"
        )
    model = frequency_response(system, frequency)
    return Measured(
        given,
        rate,
        responses,
        {name: model.of(name, "motor_torque") for name in outputs},
        _remarks(given, responses),
    )


def _highest(response: MeasuredResponse) -> float:
    """The highest frequency at which the response means something [Hz]."""
    return float(max(response.frequency[response.usable()], default=np.inf))


def _rate(recording: Recording, name: str) -> float:
    steps = np.diff(recording[name].time)
    steps = steps[steps > 0.0]
    if not len(steps):
        raise InputError(f"{name} of the recording has no two samples; a frequency response needs minutes of them")
    return float(round(1.0 / float(np.median(steps)), 6))


def _remarks(given: str, responses: Mapping[str, MeasuredResponse]) -> tuple[str, ...]:
    remarks = []
    if given != "motor_torque":
        remarks.append("The torque that the motor was asked for stands for the one it gave.")
    poor = [name for name, each in responses.items() if np.mean(each.usable()) < 0.2]
    if poor:
        remarks.append(
            f"{', '.join(poor)} hardly follows the motor's torque: coherence is below 0.5 at most frequencies. Sweep "
            "with more torque, or check that hands are off and the wheel is free."
        )
    return tuple(remarks)
