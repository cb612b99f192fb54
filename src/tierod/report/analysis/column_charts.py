"""Bode plots of a column: whole, reduced and measured."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from tierod.analysis.column import ColumnAnalysis
from tierod.analysis.frequency_response import decibels, frequency_response, phase
from tierod.analysis.measured_response import MeasuredResponse
from tierod.models.linear import LinearSystem
from tierod.report.analysis.column_measured import Measured
from tierod.studies.content import Band, Chart, Lines, Panel

FREQUENCY = np.geomspace(0.5, 300.0, 400)
"""Of the curves [Hz]."""

_WORDS = {
    "steering_wheel_angle": ("angle of the steering wheel", "°/N·m", 180.0 / math.pi),
    "motor_angle_mechanical": ("angle of the motor", "°/N·m", 180.0 / math.pi),
    "driver_torque": ("torque of the bar", "N·m/N·m", 1.0),
}
_DRAWN = ("mechanical, series", "mechanical, printed", "balanced", "balanced, without D")


def bode_chart(found: ColumnAnalysis, measured: Measured | None) -> Chart:
    """From the motor's torque to that of the bar: the column, what is left of it with four states, and as measured."""
    systems = {"whole column": found.system} | {row.name: row.system for row in found.reductions if row.name in _DRAWN}
    response = measured.responses.get("driver_torque") if measured else None
    return bode("bode-reduced", "The column and its reductions", systems, response)


def measured_charts(measured: Measured) -> list[Chart]:
    """Measured and computed response of every sensor, with coherence."""
    return [_compared(name, measured.responses[name], measured.model[name]) for name in measured.responses]


def bode(name: str, title: str, systems: dict[str, LinearSystem], response: MeasuredResponse | None = None) -> Chart:
    """Gain, phase and error of several columns from the motor's torque to that of the bar.

    Args:
        name, title: of the chart
        systems: by name, the whole one first; it is drawn solid
        response: measured; None for none
    """
    words, unit, _ = _WORDS["driver_torque"]
    gains = {
        key: frequency_response(each, FREQUENCY).of("driver_torque", "motor_torque") for key, each in systems.items()
    }
    whole = next(iter(gains.values()))
    sizes = [Lines(key, FREQUENCY, decibels(gain), dashed=k > 0) for k, (key, gain) in enumerate(gains.items())]
    phases = [Lines(key, FREQUENCY, phase(gain), dashed=k > 0) for k, (key, gain) in enumerate(gains.items())]
    errors = [
        Lines(key, FREQUENCY, 100.0 * np.abs(gain - whole) / np.abs(whole), dashed=True)
        for k, (key, gain) in enumerate(gains.items())
        if k > 0
    ]
    drawn = [*sizes, *_measured_gain(response, 1.0)] if response else sizes
    return Chart(
        name,
        title,
        f"From the motor's torque to the {words}. Dashed: with four states, which follow the column up to its first "
        "resonance and not to that of the gear. Without its direct way (D) the balanced one is wrong by as much as D "
        "at all frequencies.",
        f"Bode plot from the motor's torque to the {words}, and how far the reduced columns are off.",
        (
            Panel("Gain", "", f"dB of {unit}", tuple(drawn), logarithmic_along=True),
            Panel("Phase", "", "degrees", tuple(phases), logarithmic_along=True),
            Panel("Error", "frequency (Hz)", "% of the gain", tuple(errors), logarithmic=True, logarithmic_along=True),
        ),
    )


def _compared(name: str, response: MeasuredResponse, model: np.ndarray) -> Chart:
    words, unit, factor = _WORDS[name]
    angle, computed = phase(_usable(response)), phase(model)
    angle = angle + 360.0 * np.round(np.nanmedian(computed - angle) / 360.0) if np.isfinite(angle).any() else angle
    frequency = response.frequency
    return Chart(
        f"measured-{name.replace('_', '-')}",
        f"Measured: from the motor's torque to the {words}",
        "Measured by spectra averaged over pieces of 2 s (Welch), with the band that holds the gain with 95 % "
        "confidence, where the coherence is 0.5 or more. Friction makes gain and coherence fall where the motor hardly "
        "overcomes it; the band tells of chance, not of that.",
        f"Measured and computed frequency response from the motor's torque to the {words}, with coherence.",
        (
            Panel(
                "Gain",
                "",
                f"dB of {unit}",
                (Lines("linear column", frequency, decibels(model * factor)), *_measured_gain(response, factor)),
                logarithmic_along=True,
            ),
            Panel(
                "Phase",
                "",
                "degrees",
                (Lines("linear column", frequency, computed), Lines("measured", frequency, angle)),
                logarithmic_along=True,
            ),
            Panel(
                "Coherence",
                "frequency (Hz)",
                "",
                (Lines("measured", frequency, response.coherence),),
                levels=(("shown above", 0.5),),
                logarithmic_along=True,
            ),
        ),
    )


def _usable(response: MeasuredResponse) -> np.ndarray:
    return np.where(response.usable(), response.gain, np.nan)


def _measured_gain(response: MeasuredResponse, factor: float) -> Iterable[Lines | Band]:
    """The measured size where it means something, with its band."""
    low, high = (np.where(response.usable(), end * factor, np.nan) for end in response.band())
    yield Lines("measured", response.frequency, decibels(_usable(response) * factor))
    yield Band("measured", response.frequency, decibels(low), decibels(high))
