"""Bode plots of a column: full model, reduced models and measurements."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np

from tierod.core.content import Band, Chart, Lines, Panel
from tierod.models.linear import LinearSystem
from tierod_lab.papers.column.frequency_response import MeasuredResponse, decibels, frequency_response, phase

FREQUENCY = np.geomspace(0.5, 300.0, 400)
"""Frequencies of the curves [Hz]."""

DRAWN = ("mechanical, series", "mechanical, printed", "balanced", "balanced, without D")
"""Reductions that are drawn; the curves of the others coincide with one of these."""

_WORDS = {
    "steering_wheel_angle": ("angle of the steering wheel", "°/N·m", 180.0 / math.pi),
    "motor_angle_mechanical": ("angle of the motor", "°/N·m", 180.0 / math.pi),
    "driver_torque": ("torque of the bar", "N·m/N·m", 1.0),
}


def reduced_chart(
    name: str, title: str, systems: Mapping[str, LinearSystem], response: MeasuredResponse | None = None
) -> Chart:
    """Gain, phase and error of a column and its reductions, from the motor's torque to that of the bar.

    Args:
        name, title: of the chart
        systems: by name, the full one first; it is drawn as a solid line
        response: measured response, or None
    """
    words, unit, _ = _WORDS["driver_torque"]
    gains = {key: gain_of_bar(each, FREQUENCY) for key, each in systems.items()}
    whole, *reduced = gains
    sizes = [Lines(key, FREQUENCY, decibels(gain), dashed=key != whole) for key, gain in gains.items()]
    phases = [Lines(key, FREQUENCY, phase(gain), dashed=key != whole) for key, gain in gains.items()]
    size = np.abs(gains[whole])
    errors = [Lines(key, FREQUENCY, 100.0 * np.abs(gains[key] - gains[whole]) / size, dashed=True) for key in reduced]
    drawn = [*sizes, *_measured_gain(response, 1.0)] if response else sizes
    return Chart(
        name,
        title,
        f"From the motor's torque to the {words}. Dashed: with four states, which follow the column up to its first "
        "resonance, but not to that of the gear. Without its feedthrough (D) the balanced one is wrong by as much as "
        "D at all frequencies.",
        f"Bode plot from the motor's torque to the {words}, and the error of the reduced columns.",
        (
            Panel("Gain", "", f"dB of {unit}", tuple(drawn), logarithmic_along=True),
            Panel("Phase", "", "degrees", tuple(phases), logarithmic_along=True),
            Panel("Error", "frequency (Hz)", "% of the gain", tuple(errors), logarithmic=True, logarithmic_along=True),
        ),
    )


def measured_chart(
    chart: str, output: str, frequency: np.ndarray, model: np.ndarray, responses: Mapping[str, MeasuredResponse]
) -> Chart:
    """Measured responses from the motor's torque to one output, with that of the linear column and with coherence.

    Args:
        chart: name of the chart
        output: of the column
        frequency, model: frequencies [Hz] and complex gains of the linear column
        responses: measured responses by name
    """
    words, unit, factor = _WORDS[output]
    computed = phase(model)
    sizes: list[Lines | Band] = [Lines("linear column", frequency, decibels(model * factor))]
    angles = [Lines("linear column", frequency, computed)]
    for name, response in responses.items():
        sizes += _measured_gain(response, factor, name)
        near = np.interp(response.frequency, frequency, computed)
        angles.append(Lines(name, response.frequency, _turned(phase(_usable(response)), near)))
    shares = [Lines(name, each.frequency, each.coherence) for name, each in responses.items()]
    return Chart(
        chart,
        f"Measured: from the motor's torque to the {words}",
        "Measured by spectra averaged over pieces of the record (Welch), with the 95 % confidence band of the gain, "
        "where the coherence is 0.5 or more. Friction makes gain and coherence fall where the motor hardly overcomes "
        "it.",
        f"Measured and computed frequency response from the motor's torque to the {words}, with coherence.",
        (
            Panel("Gain", "", f"dB of {unit}", tuple(sizes), logarithmic_along=True),
            Panel("Phase", "", "degrees", tuple(angles), logarithmic_along=True),
            Panel(
                "Coherence",
                "frequency (Hz)",
                "share",
                tuple(shares),
                levels=(("shown above", 0.5),),
                logarithmic_along=True,
            ),
        ),
    )


def gain_of_bar(system: LinearSystem, frequency: np.ndarray) -> np.ndarray:
    """Complex gain from the motor's torque to that of the bar, at frequencies [Hz]."""
    return frequency_response(system, frequency).of("driver_torque", "motor_torque")


def _turned(angle: np.ndarray, near: np.ndarray) -> np.ndarray:
    """A phase shifted by the whole turns that bring it closest to another one [deg]."""
    known = np.isfinite(angle)
    return angle + 360.0 * np.round(np.median((near - angle)[known]) / 360.0) if known.any() else angle


def _usable(response: MeasuredResponse) -> np.ndarray:
    return np.where(response.usable(), response.gain, np.nan)


def _measured_gain(response: MeasuredResponse, factor: float, name: str = "measured") -> Iterable[Lines | Band]:
    low, high = (np.where(response.usable(), end * factor, np.nan) for end in response.band())
    yield Lines(name, response.frequency, decibels(_usable(response) * factor))
    yield Band(name, response.frequency, decibels(low), decibels(high))
