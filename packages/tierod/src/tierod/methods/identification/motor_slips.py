"""Detection of common mistakes in recordings of a motor: signs, phases, pole pairs, timing of voltages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.identification.motor_electrical import MotorRecording, electrical_fit, held_fit

_MOST = 30_000  # Number of samples from the middle of a recording that are checked
# Unexplained share of the voltage above which mistakes are tried, since swapped currents of a fast motor leave only a
# fifth; share above which the recording is wrong in any case; residual with a mistake corrected over that without,
# below which the mistake is reported [-]
_LOOKED_INTO, _UNEXPLAINED, _BETTER = 0.05, 0.25, 0.4
_SURE = 3.0  # Standard deviations by which a resistance must be negative to be reported
_POLE_PAIRS = range(1, 13)  # Candidate numbers of pole pairs
# Candidate delays of the voltages [samples], if they belong to the step after or about a sample
_LATE = (-1.0, -0.5, 0.5, 1.0)
# Residual with shifted voltages over that without, below which they are shifted [-]. The averaging of two samples by a
# shift of half a sample must not count as an improvement.
_IN_TIME = 0.9


class _Slip(NamedTuple):
    recording: MotorRecording
    words: str


def refuse_slips(seen: MotorRecording, pole_pairs: float, expected: tuple[float, float, float]) -> None:
    """Check that currents, voltages and angle are consistent.

    Args: expected: resistance [ohm], inductance [H] and flux [V s] of the vehicle file.
    """
    part = _middle(seen)
    fit, share = electrical_fit([part], pole_pairs, expected)
    if share > _LOOKED_INTO:
        found = [(electrical_fit([slip.recording], pole_pairs, expected), slip) for slip in _slips(part, pole_pairs)]
        (best, left), slip = min(found, key=lambda each: each[0][1])
        if left < _BETTER * share and best.values[0] > -_SURE * best.deviations[0]:
            raise InputError(
                f"{seen.name}: currents, voltages and angle do not fit each other ({100.0 * share:.0f} % of the "
                f"voltage remains unexplained); {slip.words}, and {100.0 * left:.0f} % remain"
            )
    if share > _UNEXPLAINED:
        return
    if fit.values[0] < -_SURE * fit.deviations[0]:
        raise InputError(_opposite(seen.name, fit.values[0], fit.deviations[0], ""))
    held, _ = held_fit([part], pole_pairs, expected)
    unsure = not fit.deviations[0] < 0.25 * expected[0]
    if unsure and held.values[0] < -_SURE * held.deviations[0]:
        note = ", with the inductance of the vehicle file and the angle as recorded"
        raise InputError(_opposite(seen.name, held.values[0], held.deviations[0], note))


def in_time(
    seen: MotorRecording, pole_pairs: float, expected: tuple[float, float, float]
) -> tuple[MotorRecording, str]:
    """The recording with its voltages shifted to the right steps, and a remark; empty if they are not shifted.

    Args: expected: resistance [ohm], inductance [H] and flux [V s] of the vehicle file.
    """
    part = _middle(seen)

    def left(samples: float) -> float:
        return electrical_fit([_moved(part, samples)], pole_pairs, expected)[1]

    best = min(_LATE, key=left)
    if not left(best) < _IN_TIME * left(0.0):
        return seen, ""
    words = f"{abs(best):g} samples {'late' if best > 0.0 else 'early'}"
    return _moved(seen, best), (
        f"{seen.name}: the voltages are {words} and are shifted: a sample should hold their mean over the step that "
        "ends there; half a step changes the inductance by some per cent"
    )


def _moved(seen: MotorRecording, samples: float) -> MotorRecording:
    whole = int(np.floor(samples))
    padded = np.concatenate([[np.nan], seen.voltage, [np.nan, np.nan]])
    first = 1 + np.arange(len(seen.voltage)) + whole
    share = samples - whole
    ahead = padded[first + 1] if share else 0.0
    return replace(seen, voltage=(1.0 - share) * padded[first] + share * ahead)


def _opposite(name: str, value: float, deviation: float, note: str) -> str:
    return (
        f"{name}: the resistance is estimated at {value:.3g} ± {deviation:.2g} ohm{note}: the currents are counted "
        "positive out of the motor; give both of them 'sign = -1' in a channel map"
    )


def _middle(seen: MotorRecording) -> MotorRecording:
    start = max((len(seen.time) - _MOST) // 2, 0)
    part = slice(start, start + _MOST)

    def cut(values: np.ndarray | None) -> np.ndarray | None:
        return None if values is None else values[part]

    return replace(
        seen,
        time=seen.time[part],
        current=seen.current[part],
        voltage=seen.voltage[part],
        angle=seen.angle[part],
        temperature=cut(seen.temperature),
        load=None,
        torque=None,
    )


def _slips(seen: MotorRecording, pole_pairs: float) -> Iterator[_Slip]:
    both = replace(seen, current=np.conj(seen.current), voltage=np.conj(seen.voltage))
    yield _Slip(both, "the angle turns opposite to currents and voltages: change its sign, or swap two phases of both")
    yield _Slip(replace(seen, current=np.conj(seen.current)), "with two phases of the currents swapped they do")
    yield _Slip(replace(seen, voltage=np.conj(seen.voltage)), "with two phases of the voltages swapped they do")
    turned = replace(seen, current=1j * np.conj(seen.current))
    yield _Slip(turned, "with alpha and beta of the currents exchanged they do")
    turned = replace(seen, voltage=1j * np.conj(seen.voltage))
    yield _Slip(turned, "with alpha and beta of the voltages exchanged they do")
    yield _Slip(replace(seen, current=-seen.current), "with the currents counted the other way they do")
    for number in _POLE_PAIRS:
        if number == pole_pairs:
            continue
        if number == 1:
            words = "the angle is the electrical one: name it motor_angle_electrical, or check motor_pole_pairs (1?)"
        else:
            words = f"with motor_pole_pairs = {number} instead of {pole_pairs:g} they do"
        yield _Slip(replace(seen, angle=seen.angle * number / pole_pairs), words)
