"""Frequency response of a bench against the linear column, Figure 5 of the paper, and the effect of friction."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.claims import Claim, at_least, at_most, between
from tierod.core.content import Heading, Item, Table
from tierod.core.graph import scan
from tierod.models.column_observation import linear_column
from tierod.models.linear import LinearSystem, sampled
from tierod.models.steering_column import SteeringColumn
from tierod_lab.ground.cars.column_bench import Acting, BenchPorts, ColumnBench
from tierod_lab.ground.courses.bench import BenchSweep
from tierod_lab.ground.parts import NO_FAULT
from tierod_lab.papers.column.analysis import vibrations
from tierod_lab.papers.column.bode import measured_chart
from tierod_lab.papers.column.frequency_response import (
    MeasuredResponse,
    decibels,
    frequency_response,
    measured_response,
    phase,
)
from tierod_lab.papers.column.parameter_sets import SETS
from tierod_lab.papers.column.reported import FREQUENCY, SEEDS
from tierod_lab.papers.column.swept_bench import NOISE
from tierod_lab.studies.effort import Effort

BAR = "driver_torque"
"""Name of the measured output, the torque of the torsion bar."""
LOWEST, HIGHEST = 1.0, 150.0
"""Lowest and highest frequency at which the responses are compared [Hz]."""
SHAKEN, SWEPT = 1.0, 0.5
"""Lowest frequencies of excitation by noise and by sweeps [Hz]."""
AMPLITUDES = (0.12, 0.2, 0.4, 1.0)
"""Amplitudes of the sweeps at the motor, whose friction is 0.1 N·m [N·m]."""
_STEP, _PIECE = 1e-3, 8.0
"""Sampling interval, and length of the segments over which spectra are averaged [s]."""


@dataclass(frozen=True)
class Run:
    """One test on the bench: torque of the motor, and measured torque of the torsion bar [N m]."""

    motor_torque: np.ndarray
    bar_torque: np.ndarray

    def response(self) -> MeasuredResponse:
        """Measured frequency response from motor torque to torque of the torsion bar."""
        return measured_response(self.motor_torque, self.bar_torque, 1.0 / _STEP, _PIECE).between(LOWEST, HIGHEST)


def items(effort: Effort) -> Iterator[Item]:
    seconds = 60.0 if effort.quick else 240.0
    yield Heading(
        "Frequency response",
        (
            "The paper compares the Bode plot of the linear column with spectra of a bench that its motor sweeps "
            "(Figure 5). Here the bench is simulated, with friction of 0.1 N·m at the motor or without any, "
            "sensors with noise, the wheel free. Spectra are averaged over pieces of the record; coherence "
            "is how much of the bar's torque follows the motor's linearly, and the band what chance leaves open.",
        ),
    )
    column = sampled(linear_column(SteeringColumn, SETS["S1"]), _STEP)
    bare = replace(ColumnBench(), friction=replace(ColumnBench().friction, level=0.0))
    noise = _shaken(bare, 1.0, seconds, SEEDS.of(FREQUENCY, 2)[0])
    sweeps = {
        amplitude: _swept(ColumnBench(), amplitude, seconds, SEEDS.of(FREQUENCY, 2)[1]) for amplitude in AMPLITUDES
    }
    yield from _without_friction(column, noise.response(), seconds)
    responses = {f"sweep of {amplitude:g} N·m": run.response() for amplitude, run in sweeps.items()}
    yield from _figure_5(column, {"noise, no friction": noise.response(), **responses})
    yield from _with_friction(column, {amplitude: run.response() for amplitude, run in sweeps.items()})


def _without_friction(column: LinearSystem, found: MeasuredResponse, seconds: float) -> Iterator[Item]:
    truth = _model(column, found.frequency)
    quiet = found.usable() & ~_near_the_gear(found.frequency)
    yield Claim(
        "frequency.band",
        "Without friction the measured gain is that of the linear column, within its band of 95 %.",
        "Raffone, Figure 5",
        None,
        _share_within(found, truth, quiet),
        at_least(0.9),
        "",
        f"Share of {np.count_nonzero(quiet)} frequencies from {LOWEST:g} to {HIGHEST:g} Hz, noise of 1 N·m for "
        f"{seconds:g} s. The ringing of the gear is left out: it lasts as long as a piece, which blurs it.",
        cause=f"Share below the first resonance "
        f"{_share_within(found, truth, quiet & (found.frequency < 11.0)):.2f}, at it (11 to 14 Hz) "
        f"{_share_within(found, truth, quiet & (np.abs(found.frequency - 12.5) <= 1.5)):.2f}, above "
        f"{_share_within(found, truth, quiet & (found.frequency > 14.0)):.2f}: gains are averaged over a band of "
        "frequencies, which lowers a peak. Longer pieces and narrower bands lessen it.",
    )
    yield Claim(
        "frequency.gain",
        "Without friction the measured gain is exact to half a decibel.",
        "tierod",
        None,
        float(np.sqrt(np.mean((decibels(found.gain) - decibels(truth))[quiet] ** 2))),
        at_most(0.5),
        "dB",
        "RMS over the same frequencies.",
    )
    yield Claim(
        "frequency.resonance",
        "The first resonance is found where the linear column has it.",
        "Raffone, Table 3",
        12.7,
        _peak(found),
        between(12.4, 13.0),
        "Hz",
        f"Largest measured gain below 40 Hz; the column: {_peak_of(column):.2f} Hz.",
    )


def _share_within(found: MeasuredResponse, truth: np.ndarray, chosen: np.ndarray) -> float:
    """Share of the chosen frequencies at which the true gain lies within the band of the measured gain."""
    low, high = found.band()
    return float(np.mean(((low <= np.abs(truth)) & (np.abs(truth) <= high))[chosen]))


def _figure_5(column: LinearSystem, responses: dict[str, MeasuredResponse]) -> Iterator[Item]:
    frequency = np.geomspace(LOWEST, HIGHEST, 400)
    shown = {name: each for name, each in responses.items() if "0.2 " not in name}
    yield measured_chart("column-figure-5", BAR, frequency, _model(column, frequency), shown)


def _with_friction(column: LinearSystem, found: dict[float, MeasuredResponse]) -> Iterator[Item]:
    low, high = (3.0, 6.0), (20.0, 28.0)
    rows = []
    for amplitude, response in found.items():
        errors = [_gain_error(column, response, band) for band in (low, high)]
        part = response.between(*low)
        rows.append(
            (
                f"{amplitude:g}",
                *(f"{error:+.1f}" for error in errors),
                f"{_phase_error(column, response, low):+.0f}",
                f"{_peak(response):.1f}",
                f"{_height(response):.1f}",
                f"{np.median(part.coherence):.3f}",
            )
        )
    header = (
        "sweep (N·m)",
        "3 to 6 Hz (dB)",
        "20 to 28 Hz (dB)",
        "3 to 6 Hz (°)",
        "peak (Hz)",
        "peak (dB)",
        "coherence",
    )
    yield Table(
        "Sweeps with friction of 0.1 N·m at the motor: gain and phase over those of the linear column, resonance",
        header,
        tuple(rows),
        f"Coherence from 3 to 6 Hz. The linear column peaks at {_peak_of(column):.1f} Hz with "
        f"{decibels(_model(column, np.array([_peak_of(column)])))[0]:.1f} dB. A sweep that hardly overcomes the "
        "friction finds a column with another gain and more damping: a frequency response is that of one amplitude.",
    )
    yield from _amplitude_claims({amplitude: abs(_gain_error(column, each, low)) for amplitude, each in found.items()})


def _amplitude_claims(misses: Mapping[float, float]) -> Iterator[Item]:
    """Claims on the errors of the gain [dB] by amplitude [N m]."""
    yield Claim(
        "frequency.strong-sweep",
        "A strong sweep gives the gain of the linear column also with friction.",
        "Raffone, Figure 5",
        "an interesting matching",
        misses[AMPLITUDES[-1]],
        at_most(1.0),
        "dB",
        f"Mean from 3 to 6 Hz, sweep of {AMPLITUDES[-1]:g} N·m against friction of 0.1 N·m.",
    )
    yield Claim(
        "frequency.weak-sweep",
        "With friction the response depends on the amplitude: a weak sweep has another gain.",
        "tierod",
        None,
        misses[AMPLITUDES[0]] - misses[AMPLITUDES[-1]],
        at_least(1.0),
        "dB",
        f"Error of the gain from 3 to 6 Hz with {AMPLITUDES[0]:g} N·m over that with {AMPLITUDES[-1]:g} N·m.",
    )


def _shaken(bench: ColumnBench, deviation: float, seconds: float, seed: int) -> Run:
    random = np.random.default_rng([seed, 5])
    return _run(bench, random.normal(0.0, deviation, round(seconds / _STEP)), random)


def _swept(bench: ColumnBench, amplitude: float, seconds: float, seed: int) -> Run:
    sweep = BenchSweep(amplitude=amplitude, settle=0.0, time=seconds, lowest=SWEPT, highest=40.0)
    torque = sweep.torque_at(np.arange(round(seconds / _STEP)) * _STEP)
    return _run(bench, torque, np.random.default_rng([seed, 6]))


def _run(bench: ColumnBench, torque: np.ndarray, random: np.random.Generator) -> Run:
    rows = np.zeros((len(torque), len(Acting._fields) - 1 + len(NO_FAULT)))
    rows[:, 0] = torque
    rows[:, len(Acting._fields) - 1 :] = list(BenchPorts(NO_FAULT).motor_torque)
    bar = scan(bench, rows)[BAR]
    return Run(torque, bar + random.normal(0.0, NOISE[BAR], len(bar)))


def _model(column: LinearSystem, frequency: np.ndarray) -> np.ndarray:
    return frequency_response(column, frequency, _STEP).of(BAR, "motor_torque")


def _near_the_gear(frequency: np.ndarray) -> np.ndarray:
    # The gear rings for as long as a segment of the spectrum, which smears its peak.
    fastest = abs(vibrations(linear_column(SteeringColumn, SETS["S1"]))[-1]) / (2.0 * math.pi)
    return np.abs(frequency / fastest - 1.0) < 0.1


def _gain_error(column: LinearSystem, found: MeasuredResponse, band: tuple[float, float]) -> float:
    part = found.between(*band)
    return float(np.mean(decibels(part.gain) - decibels(_model(column, part.frequency))))


def _phase_error(column: LinearSystem, found: MeasuredResponse, band: tuple[float, float]) -> float:
    part = found.between(*band)
    return float(np.mean(phase(part.gain / _model(column, part.frequency))))


def _peak(found: MeasuredResponse) -> float:
    part = found.between(LOWEST, 40.0)
    return float(part.frequency[np.argmax(np.where(part.usable(), np.abs(part.gain), 0.0))])


def _height(found: MeasuredResponse) -> float:
    part = found.between(LOWEST, 40.0)
    return float(decibels(part.gain[part.usable()]).max())


def _peak_of(column: LinearSystem) -> float:
    frequency = np.linspace(5.0, 50.0, 4501)
    return float(frequency[np.argmax(np.abs(_model(column, frequency)))])
