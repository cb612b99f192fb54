"""The voltage's equation of a permanent-magnet motor over windows of a recording: columns, instruments, voltage."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.methods.identification.fit_quality import white_noise
from tierod.methods.identification.modulation import Modulation
from tierod.methods.identification.motor_recording import MotorRecording
from tierod.physics.pm_motor import resistance_at

_TURN = 1.5
"""Electrical angle that the rotor may turn within a window [rad]: more would average the turning voltages away."""
_LENGTHS = (12, 64)
"""Least and greatest length of a window, in samples."""
_QUIET = 2e-4
"""Share of noise in the power of a regressor that biases its coefficient by no more than that."""
_ALIKE_PAST = 0.8
"""Correlation of a regressor with its past from which that is the instrument, as noise need not be white then."""


class Equation(NamedTuple):
    """One recording over its windows, complex, in the stator's axes, without means.

    Args:
        columns: voltage per resistance (R), per inductance along (D) and across (Q) the flux, per flux along (F) and
            across (B) the zero of the angle sensor
        instruments: the same with noise of their own
        voltage: mean [V]
        arc: change of the mean current in a step, per flux over inductance
        settling: likewise, per resistance over inductance
    """

    columns: dict[str, np.ndarray]
    instruments: dict[str, np.ndarray]
    voltage: np.ndarray
    arc: np.ndarray
    settling: np.ndarray


def equation(seen: MotorRecording, pole_pairs: float, warm: bool) -> Equation:
    """The voltage's equation of a recording.

    Args:
        seen: the recording
        pole_pairs: electrical turns per turn of the shaft
        warm: whether the resistance is that at 20 degrees, by the recorded temperature
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
    # The mean current of a step differs from that of both ends by a twelfth of its second derivative: the magnets turn
    # on an arc, times flux over inductance, and the current settles, times resistance over inductance.
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
        # Without its mean: an offset of voltage or current stands in the stator's axes.
        return values[known] - values[known].mean()

    return Equation(
        {name: kept(each) for name, each in columns.items()},
        {name: kept(each) for name, each in instruments.items()},
        kept(voltage),
        kept(arc),
        kept(settling),
    )


def _instruments(columns: dict[str, np.ndarray], turn: np.ndarray, quiet: dict[str, bool]) -> dict[str, np.ndarray]:
    """Every column as it was earlier, turned on; itself where it is quiet and its past tells too little."""
    found, earlier = {}, len(next(iter(columns.values()))) - len(turn)
    for name, values in columns.items():
        past = values[:-earlier] * turn
        alike = _likeness(values[earlier:], past)
        found[name] = values[earlier:] if quiet[name] and alike < _ALIKE_PAST else past
    return found


def _likeness(values: np.ndarray, others: np.ndarray) -> float:
    """Correlation of two complex signals; missing samples are left out."""
    known = np.isfinite(values + others)
    first, second = values[known], others[known]
    size = float(np.linalg.norm(first) * np.linalg.norm(second))
    return float(np.real(np.vdot(first, second))) / size if size else 0.0


def _quiet(
    columns: dict[str, np.ndarray], window: Modulation, seen: MotorRecording, pole_pairs: float
) -> dict[str, bool]:
    """Columns in which noise has so small a share that they are their own instruments."""
    current = max(white_noise(seen.current.real), white_noise(seen.current.imag))
    mean, growth = window.gain
    # Between slow readings of the angle there is a line: its noise has to be told from the readings themselves.
    step = seen.angle_step or seen.step
    readings = Modulation(max(round(window.length * seen.step / step), 2), 1, step)
    noise = white_noise(seen.angle) if seen.angle_noise is None else seen.angle_noise
    turning = pole_pairs * noise * readings.gain[1]
    noises = {"R": np.sqrt(2.0) * mean * current, "D": growth * current, "Q": growth * current}
    noises |= {"F": turning, "B": turning}
    return {name: bool(noises[name] ** 2 < _QUIET * np.nanvar(each)) for name, each in columns.items()}
