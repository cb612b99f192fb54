"""Resistance, inductance and flux of a permanent-magnet motor from its currents, voltages and angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.methods.analysis.noise import white_noise
from tierod.methods.identification.experiment import UNKNOWN
from tierod.methods.identification.motor_recording import MotorRecording
from tierod.methods.identification.regression import Fit, Modulation, Rows, regress
from tierod.physics.pm_motor import resistance_at

_TURN = 1.5  # Largest electrical rotation within a window [rad]: a larger one would average out the rotating voltages
_LENGTHS = (12, 64)  # Smallest and largest length of a window [samples]
_QUIET = 2e-4
"""Share of noise in the power of a regressor below which its bias, of the same relative size, is negligible [-]."""
_ALIKE_PAST = 0.8
"""Correlation of a regressor with its past above which the past is the instrument [-]: then noise need not be white."""


class Equation(NamedTuple):
    """Voltage equation of one recording in windows, as complex values in the stator's axes, without means."""

    # regressors of resistance (R), inductance along (D) and across (Q) the flux, and flux along (F) and across (B) the
    # zero of the angle sensor
    columns: dict[str, np.ndarray]
    instruments: dict[str, np.ndarray]  # instrumental variables of the columns, with independent noise
    voltage: np.ndarray  # mean [V]
    arc: np.ndarray  # correction of the mean current within a step, per flux over inductance
    settling: np.ndarray  # correction of the mean current within a step, per resistance over inductance


def equation(seen: MotorRecording, pole_pairs: float, warm: bool) -> Equation:
    """The voltage equation of a recording.

    Args:
        warm: whether the resistance is referred to 20 degrees Celsius by the recorded temperature
    """
    angle = pole_pairs * seen.angle
    turning = float(np.nanpercentile(np.abs(np.diff(angle)), 95.0))
    length = int(np.clip(_TURN / max(turning, 1e-9), *_LENGTHS))
    window = Modulation(length, max(length // 4, 1), seen.step)
    rotor = np.exp(1j * angle)
    own = seen.current / rotor
    mean = 0.5 * (seen.current[1:] + seen.current[:-1])
    rise = np.ones(len(seen.time))
    if warm and seen.temperature is not None:
        rise = resistance_at(seen.temperature, 1.0)
    columns = {
        "R": window.between(rise[1:] * mean),
        "D": window.growth(own.real * rotor),
        "Q": window.growth(1j * own.imag * rotor),
        "F": window.growth(rotor),
        "B": window.growth(1j * rotor),
    }
    # The mean current of a step differs from the mean of its ends by step^2 / 12 of its second derivative, of which one
    # part is due to the rotating flux (arc) and one to the decay of the current (settling).
    arc = window.between(-(np.diff(angle) ** 2) / 12.0 * rise[1:] * np.exp(0.5j * (angle[1:] + angle[:-1])))
    settling = window.between(seen.step / 12.0 * rise[1:] ** 2 * np.diff(seen.current))
    voltage, middle = window.between(seen.voltage[1:]), window.mean(angle)
    earlier = length // window.stride + 2
    turn = np.exp(1j * (middle[earlier:] - middle[:-earlier]))
    instruments = _instruments(columns, turn, _quiet(columns, window, seen, pole_pairs))
    columns = {name: values[earlier:] for name, values in columns.items()}
    voltage, arc, settling = voltage[earlier:], arc[earlier:], settling[earlier:]
    known = np.isfinite(voltage + sum(columns.values()) + sum(instruments.values()))

    def kept(values: np.ndarray) -> np.ndarray:
        # Without the mean, since offsets of voltages and currents are constant in the stator's axes.
        return np.asarray(values[known] - values[known].mean())

    return Equation(
        {name: kept(each) for name, each in columns.items()},
        {name: kept(each) for name, each in instruments.items()},
        kept(voltage),
        kept(arc),
        kept(settling),
    )


def _instruments(columns: dict[str, np.ndarray], turn: np.ndarray, quiet: dict[str, bool]) -> dict[str, np.ndarray]:
    """Instruments: each column one window earlier, rotated; or itself if it has little noise and correlates little."""
    found, earlier = {}, len(next(iter(columns.values()))) - len(turn)
    for name, values in columns.items():
        past = values[:-earlier] * turn
        alike = _likeness(values[earlier:], past)
        found[name] = values[earlier:] if quiet[name] and alike < _ALIKE_PAST else past
    return found


def _likeness(values: np.ndarray, others: np.ndarray) -> float:
    """Real part of the correlation of two complex signals; missing samples are left out."""
    known = np.isfinite(values + others)
    first, second = values[known], others[known]
    size = float(np.linalg.norm(first) * np.linalg.norm(second))
    return float(np.real(np.vdot(first, second))) / size if size else 0.0


def _quiet(
    columns: dict[str, np.ndarray], window: Modulation, seen: MotorRecording, pole_pairs: float
) -> dict[str, bool]:
    current = max(white_noise(seen.current.real), white_noise(seen.current.imag))
    mean, growth = window.gain
    # A slowly sampled angle is interpolated, so that its noise has to be taken from the samples themselves.
    step = seen.angle_step or seen.step
    readings = Modulation(max(round(window.length * seen.step / step), 2), 1, step)
    noise = white_noise(seen.angle) if seen.angle_noise is None else seen.angle_noise
    turning = pole_pairs * noise * readings.gain[1]
    noises = {"R": np.sqrt(2.0) * mean * current, "D": growth * current, "Q": growth * current}
    noises |= {"F": turning, "B": turning}
    return {name: bool(noises[name] ** 2 < _QUIET * np.nanvar(each)) for name, each in columns.items()}


_SURE, _ALIKE = 4.0, 0.02
"""Smallest difference of both inductances for a salient motor, in standard deviations and over the value."""
_PLAIN, _APART = ("R", "DQ", "F", "B"), ("R", "D", "Q", "F", "B")
"""Coefficients without and with saliency: resistance, inductances, flux along and across the sensor's zero."""
_NAMES = ("motor_resistance", "motor_inductance", "motor_saliency", "motor_flux")


class Value(NamedTuple):
    """A value and its standard deviation."""

    value: float
    deviation: float


@dataclass(frozen=True)
class Electrical:
    """Parameters from currents and voltages."""

    resistance: Value  # of a phase [ohm]; at 20 degrees Celsius if the temperature was recorded
    inductance: Value  # of a phase [H]; along the flux for a salient motor
    inductance_q: Value | None  # across the flux [H]; None without saliency
    flux: Value  # linkage of the magnets at their temperature [V s]
    zero: Value  # electrical angle of the flux where the sensor reads zero [rad]
    along: bool  # whether the current along the flux identifies its inductance
    blind: tuple[str, ...]  # names of parameters that these recordings do not identify or separate
    unexplained: float  # root mean square residual over that of the voltage [-]
    voltage: float  # root mean square of the voltage, without its mean [V]
    warm: bool  # whether the resistance is that at 20 degrees Celsius


def identify_electrical(
    recordings: Sequence[MotorRecording], pole_pairs: float, expected: tuple[float, float, float]
) -> Electrical:
    """Resistance, inductance, flux, and zero of the angle sensor, by regression with instrumental variables.

    The voltage equation in the stator's axes is linear in all of them and needs no Park transform: the mean voltage
    over a step is the resistance times the mean current plus the change of the flux. It is averaged over sliding
    windows. Instruments are the windows one length earlier, rotated with the rotor: their noise is independent even in
    closed loop. A regressor with negligible noise that hardly correlates with its past, as for a step, is its own
    instrument.

    Args:
        expected: resistance [ohm], inductance [H], flux [V s], as scales for large standard deviations

    Source: Reinelt et al., eqs (17), (18), integrated over a step, with inductances along and across the flux.
    """
    warm = all(each.temperature is not None for each in recordings)
    parts = [equation(each, pole_pairs, warm) for each in recordings]
    plain, plain_share = _fitted(parts, _PLAIN, expected)
    apart, apart_share = _fitted(parts, _APART, expected)
    along = bool(apart.deviations[1] < UNKNOWN * expected[1])
    salient = along and _differ(apart)
    fit, share, kinds = (apart, apart_share, _APART) if salient else (plain, plain_share, _PLAIN)
    deviations, flux = fit.deviations, float(np.hypot(*fit.values[-2:]))
    names = _NAMES if salient else (*_NAMES[:2], _NAMES[3])
    sizes = _sizes(kinds, expected)
    return Electrical(
        Value(float(fit.values[0]), float(deviations[0])),
        Value(float(fit.values[1]), float(deviations[1])),
        Value(float(fit.values[2]), float(deviations[2])) if salient else None,
        Value(flux, float(deviations[-2])),
        Value(float(np.arctan2(fit.values[-1], fit.values[-2])), float(deviations[-1] / max(flux, 1e-12))),
        along,
        tuple(n for n, d, s in zip(names, deviations, sizes, strict=False) if not d < UNKNOWN * s),
        share,
        _spread(parts),
        warm,
    )


def electrical_fit(
    recordings: Sequence[MotorRecording], pole_pairs: float, expected: tuple[float, float, float]
) -> tuple[Fit, float]:
    """Fit of resistance, inductance, and flux along and across the sensor's zero; unexplained share of the voltage."""
    return _fitted([equation(each, pole_pairs, False) for each in recordings], _PLAIN, expected)


def held_fit(
    recordings: Sequence[MotorRecording], pole_pairs: float, expected: tuple[float, float, float]
) -> tuple[Fit, float]:
    """Fit of resistance and flux, with the expected inductance and no correction of the sensor's zero."""
    parts = [equation(each, pole_pairs, False) for each in recordings]
    less = [
        part._replace(voltage=part.voltage - expected[1] * (part.columns["D"] + part.columns["Q"])) for part in parts
    ]
    return _fitted(less, ("R", "F"), expected)


def _differ(apart: Fit) -> bool:
    spread = apart.covariance
    variance = spread[1, 1] + spread[2, 2] - 2.0 * spread[1, 2]
    difference = abs(apart.values[2] - apart.values[1])
    return bool(difference > max(_SURE * np.sqrt(variance), _ALIKE * abs(apart.values[1])))


def _sizes(kinds: Sequence[str], expected: tuple[float, float, float]) -> np.ndarray:
    of_kind = {"R": expected[0], "F": expected[2], "B": expected[2]}
    return np.array([of_kind.get(kind, expected[1]) for kind in kinds])


def _fitted(parts: Sequence[Equation], kinds: Sequence[str], expected: tuple[float, float, float]) -> tuple[Fit, float]:
    """Fit with the correction of the mean currents, whose effect adds to the covariance; unexplained share."""
    rows = [
        Rows(part.voltage, *(np.column_stack([sum(of[k] for k in kind) for kind in kinds]) for of in part[:2]))
        for part in parts
    ]
    straight = regress(rows)
    known = straight.deviations < UNKNOWN * _sizes(kinds, expected)
    # `regress` sets an unidentified coefficient to zero; an inductance of zero would bias the others.
    if "DQ" in kinds and not np.isfinite(straight.deviations[1]):
        rows = [row._replace(target=row.target - expected[1] * row.regressors[:, 1]) for row in rows]
        straight = regress(rows)
    values = dict(zip(kinds, straight.values, strict=True)) if np.all(known[[0, 1, kinds.index("F")]]) else {}
    inductance = values.get(kinds[1], expected[1]) if kinds[1] != "F" else expected[1]
    arc, settling = values.get("F", expected[2]) / inductance, values.get("R", expected[0]) / inductance
    bent = regress(rows, [_only_first(arc * part.arc + settling * part.settling, len(kinds)) for part in parts])
    change = bent.values - straight.values
    fit = bent._replace(covariance=bent.covariance + np.outer(change, change))
    return fit, fit.residual / _spread(parts)


def _only_first(values: np.ndarray, count: int) -> np.ndarray:
    return np.column_stack([values, *[np.zeros_like(values)] * (count - 1)])


def _spread(parts: Sequence[Equation]) -> float:
    return float(np.sqrt(np.mean(np.concatenate([np.abs(part.voltage) ** 2 for part in parts]))))
