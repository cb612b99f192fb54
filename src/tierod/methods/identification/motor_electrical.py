"""Resistance, inductance and flux of a permanent-magnet motor from its currents, voltages and angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.methods.identification.identifiability import UNKNOWN
from tierod.methods.identification.motor_equation import Equation, equation
from tierod.methods.identification.motor_recording import MotorRecording
from tierod.methods.identification.motor_regression import Fit, Rows, regress

_SURE, _ALIKE = 4.0, 0.02
"""Standard deviations, and share of the value, by which the inductances must differ to be told apart."""
_PLAIN, _APART = ("R", "DQ", "F", "B"), ("R", "D", "Q", "F", "B")
"""Coefficients: resistance, inductance along and across the flux or one, flux along and beside the sensor's zero."""
_NAMES = ("motor_resistance", "motor_inductance", "motor_saliency", "motor_flux")


class Value(NamedTuple):
    """A number and its standard deviation."""

    value: float
    deviation: float


@dataclass(frozen=True)
class Electrical:
    """What currents and voltages tell.

    Args:
        resistance: of a phase [ohm]; at 20 degrees where the temperature was recorded
        inductance: of a phase [H]; along the flux where they are told apart
        inductance_q: across the flux [H], or None where they are not told apart
        flux: linkage of the magnets, as warm as they were [V s]
        zero: electrical angle of the flux where the sensor says zero [rad]
        along: whether current along the flux tells its inductance
        blind: names of parameters that these recordings do not tell, or not apart
        unexplained: root mean square of what is left over of that of the voltage
        voltage: root mean square of the voltage, without its mean [V]
        warm: whether the resistance is that at 20 degrees
    """

    resistance: Value
    inductance: Value
    inductance_q: Value | None
    flux: Value
    zero: Value
    along: bool
    blind: tuple[str, ...]
    unexplained: float
    voltage: float
    warm: bool


def identify_electrical(
    recordings: Sequence[MotorRecording], pole_pairs: float, expected: tuple[float, float, float]
) -> Electrical:
    """Resistance, inductance, flux, and the zero of the angle sensor.

    The voltage's equation in the stator's axes is linear in all of them and needs no Park transform: the mean voltage
    over a step is the resistance times the mean current and what the flux gained. Windows slide along it.
    Instruments are the windows one length earlier, turned on with the rotor: their noise is another one even in a
    closed loop. Where the past tells too little, as of a step, a regressor without noise worth mention is its own.

    Args:
        recordings: of one motor
        pole_pairs: electrical turns per turn of the shaft
        expected: resistance [ohm], inductance [H], flux [V s] in whose parts a deviation counts as large

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
    """Resistance, inductance, and flux along and across the sensor's zero; the share of the voltage that is left over.

    Args:
        recordings, pole_pairs, expected: as of `identify_electrical`
    """
    return _fitted([equation(each, pole_pairs, False) for each in recordings], _PLAIN, expected)


def held_fit(
    recordings: Sequence[MotorRecording], pole_pairs: float, expected: tuple[float, float, float]
) -> tuple[Fit, float]:
    """Resistance and flux, with the inductance that is expected and the zero of the sensor as it is.

    Args:
        recordings, pole_pairs, expected: as of `identify_electrical`
    """
    parts = [equation(each, pole_pairs, False) for each in recordings]
    less = [
        part._replace(voltage=part.voltage - expected[1] * (part.columns["D"] + part.columns["Q"])) for part in parts
    ]
    return _fitted(less, ("R", "F"), expected)


def _differ(apart: Fit) -> bool:
    """Whether the inductances along and across the flux do."""
    spread = apart.covariance
    variance = spread[1, 1] + spread[2, 2] - 2.0 * spread[1, 2]
    difference = abs(apart.values[2] - apart.values[1])
    return bool(difference > max(_SURE * np.sqrt(variance), _ALIKE * abs(apart.values[1])))


def _sizes(kinds: Sequence[str], expected: tuple[float, float, float]) -> np.ndarray:
    """In whose parts the deviations of coefficients count as large."""
    of_kind = {"R": expected[0], "F": expected[2], "B": expected[2]}
    return np.array([of_kind.get(kind, expected[1]) for kind in kinds])


def _fitted(parts: Sequence[Equation], kinds: Sequence[str], expected: tuple[float, float, float]) -> tuple[Fit, float]:
    """The fit with currents that bend in a step, as unsure as what that changes; the share left over."""
    rows = [
        Rows(part.voltage, *(np.column_stack([sum(of[k] for k in kind) for kind in kinds]) for of in part[:2]))
        for part in parts
    ]
    straight = regress(rows)
    told = straight.deviations < UNKNOWN * _sizes(kinds, expected)
    if "DQ" in kinds and not np.isfinite(straight.deviations[1]):
        rows = [row._replace(target=row.target - expected[1] * row.regressors[:, 1]) for row in rows]
        straight = regress(rows)
    values = dict(zip(kinds, straight.values, strict=True)) if np.all(told[[0, 1, kinds.index("F")]]) else {}
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
