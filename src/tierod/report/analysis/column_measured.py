"""Frequency response of a column from a test-bench recording, compared with that of its model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tierod.core.content import Table
from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.methods.analysis.frequency_response import MeasuredResponse, frequency_response, measured_response
from tierod.models.linear import LinearSystem
from tierod.report.display import number, words

INPUTS = ("motor_torque", "motor_target_torque")
"""Motor torque, or the target torque if the former is missing."""

LOWEST = 0.5
"""Lowest frequency that is evaluated; below it the free column drifts [Hz]."""

MOST_APART = 6.0
"""Root-mean-square difference between measured and computed gain, over the frequencies at which a sensor follows the
motor, above which a recording does not fit the model [dB], a factor of two: sweeps and sines on a bench with friction
differ by 2 to 4 dB; friction alone, a locked wheel or a drive in a car by 8 to 15 dB."""

_GAP = 3.5
_MORE = 1.5
_FEWEST, _USUAL = 5, 200.0


class Difference(NamedTuple):
    """Difference between measured and modelled response, at the frequencies at which the sensor follows the motor.

    Args:
        share: share of the frequencies at which the sensor follows the motor
        lowest, highest: these frequencies [Hz]; NaN if there are none, as for all further fields
        apart: root-mean-square ratio of measured to computed gain over these frequencies [dB]
        most: largest ratio, with its sign [dB]
        where: frequency of the largest ratio [Hz]
    """

    share: float
    lowest: float
    highest: float
    apart: float
    most: float
    where: float


def difference(response: MeasuredResponse, model: np.ndarray) -> Difference:
    """Difference between a measured response and complex gains of the model at the same frequencies."""
    usable = response.usable() & (np.abs(response.gain) > 0.0) & (np.abs(model) > 0.0)
    frequency = response.frequency[usable]
    if not len(frequency):
        return Difference(0.0, *[np.nan] * 5)
    apart = 20.0 * np.log10(np.abs(response.gain[usable]) / np.abs(model[usable]))
    most = int(np.argmax(np.abs(apart)))
    return Difference(
        float(np.mean(usable)),
        float(frequency[0]),
        float(frequency[-1]),
        float(np.sqrt(np.mean(apart**2))),
        float(apart[most]),
        float(frequency[most]),
    )


@dataclass(frozen=True, eq=False)
class Measured:
    """Measured and computed responses to the motor torque.

    Args:
        input: signal used as motor torque
        rate: common sampling rate of the signals [Hz]
        responses: measured responses, by output
        model: complex gain of the linear column at the same frequencies, by output
        remarks: notices for a reader
        differences: between measured and computed response, by output
    """

    input: str
    rate: float
    responses: Mapping[str, MeasuredResponse]
    model: Mapping[str, np.ndarray]
    remarks: tuple[str, ...]
    differences: Mapping[str, Difference]

    @property
    def fits(self) -> bool:
        """Whether the recording shows the response of the column, and the model agrees with it."""
        return _informative(self.differences, self.responses) and not _apart(self.differences, self.responses)

    def table(self) -> Table:
        """Differences of measured and computed responses, by sensor."""
        rows = tuple(
            (
                words(name),
                f"{100.0 * each.share:.0f} %",
                *(number(value, 3) for value in (each.lowest, each.highest)),
                *(number(value, 2) for value in (each.apart, each.most)),
                number(each.where, 3),
            )
            for name, each in self.differences.items()
        )
        header = (
            "sensor",
            "follows",
            "from (Hz)",
            "to (Hz)",
            "difference, root mean square (dB)",
            "largest difference (dB)",
            "at (Hz)",
        )
        note = (
            "Follows: share of the frequencies at which the sensor follows the motor's torque, with a coherence of 0.5 "
            f"or more; the other columns refer to these. From {MOST_APART:g} dB on, the recording does not fit the "
            "model. Friction "
            "lowers the measured gain."
        )
        return Table("Measured over computed gain", header, rows, note)

    def document(self) -> dict[str, Any]:
        """The measurement as data for JSON."""
        return {
            "input": self.input,
            "rate": self.rate,
            "fits": self.fits,
            "differences": {
                name: {
                    "share": each.share,
                    "frequencies": [each.lowest, each.highest],
                    "root_mean_square_db": each.apart,
                    "largest_db": each.most,
                    "largest_at": each.where,
                }
                for name, each in self.differences.items()
            },
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
    """Measured responses from the motor torque to every sensor in the recording.

    Args:
        recording: with `motor_torque` or `motor_target_torque`, and at least one sensor of the column
        system: linear model of the column

    Raises:
        InputError: there is no motor torque, it is constant, there is no sensor, or too few frequencies are resolved
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
            f"the recording hardly resolves frequencies above {LOWEST:g} Hz: its signals come at {rate:.4g} Hz, or do "
            f"not follow the motor; record at {_USUAL:g} Hz or more, and sweep the motor's torque"
        )
    whole = frequency_response(system, frequency)
    model = {name: whole.of(name, "motor_torque") for name in outputs}
    differences = {name: difference(each, model[name]) for name, each in responses.items()}
    return Measured(given, rate, responses, model, _remarks(given, responses, differences), differences)


def _known(name: str, differences: Mapping[str, Difference], responses: Mapping[str, MeasuredResponse]) -> bool:
    # The product is a whole number up to rounding errors.
    return differences[name].share * len(responses[name].frequency) > _FEWEST - 0.5


def _informative(differences: Mapping[str, Difference], responses: Mapping[str, MeasuredResponse]) -> bool:
    """Whether any sensor follows the motor at enough frequencies."""
    return any(_known(name, differences, responses) for name in differences)


def _apart(differences: Mapping[str, Difference], responses: Mapping[str, MeasuredResponse]) -> list[str]:
    """Sensors whose response does not fit the model."""
    return [
        name for name, each in differences.items() if _known(name, differences, responses) and each.apart > MOST_APART
    ]


def _highest(response: MeasuredResponse) -> float:
    """Highest frequency with a usable response [Hz]."""
    return float(max(response.frequency[response.usable()], default=np.inf))


def _rate(recording: Recording, name: str) -> float:
    steps = np.diff(recording[name].time)
    steps = steps[steps > 0.0]
    if not len(steps):
        raise InputError(
            f"{name} of the recording has fewer than two samples; a frequency response needs minutes of them"
        )
    return float(round(1.0 / float(np.median(steps)), 6))


def _remarks(
    given: str, responses: Mapping[str, MeasuredResponse], differences: Mapping[str, Difference]
) -> tuple[str, ...]:
    remarks = []
    apart = _apart(differences, responses)
    if apart:
        sizes = ", ".join(f"{words(name).lower()} {differences[name].apart:.0f} dB" for name in apart)
        remarks.append(
            f"The recording does not fit the model: measured and computed gain are {sizes} apart (root mean square). "
            "Check that it is of this column, alone on its bench, with a free wheel that is not touched, and moved "
            "by several times its friction."
        )
    elif not _informative(differences, responses):
        remarks.append("The recording cannot be compared with the model: no sensor follows the motor's torque.")
    if given != "motor_torque":
        remarks.append("The requested motor torque is used in place of the actual one.")
    poor = [name for name, each in responses.items() if np.mean(each.usable()) < 0.2]
    if poor:
        remarks.append(
            f"{', '.join(poor)} hardly follows the motor's torque: coherence is below 0.5 at most frequencies. Sweep "
            "with more torque, or check that hands are off and the wheel is free."
        )
    return tuple(remarks)
