"""Recordings of a permanent-magnet motor, checked and resampled to one time grid for identification."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.io.derive import complete
from tierod.methods.analysis.noise import white_noise

SHORTEST = 0.2  # Shortest duration [s]
FASTEST = 0.5
"""Largest electrical rotation from sample to sample [rad]; with a larger one the direction becomes ambiguous."""
_FEW = 50  # Number of samples of a torque above which it is used
_FEWEST = 200  # Smallest number of samples for a regression over windows
_MISSING = 0.2  # Largest share of missing samples [-]


_CURRENT = ("motor_current_alpha", "motor_current_beta")
_PHASES = ("motor_current_a", "motor_current_b", "motor_current_c")
_VOLTAGE = ("motor_voltage_alpha", "motor_voltage_beta")
_COMMAND = ("motor_target_voltage_alpha", "motor_target_voltage_beta")


@dataclass(frozen=True, eq=False)
class MotorRecording:
    """A recording prepared for identification; vectors in the stator's axes as complex numbers, missing samples NaN."""

    name: str
    step: float  # sampling interval [s]
    time: np.ndarray  # of the grid [s], (n,)
    current: np.ndarray  # at the samples [A], (n,)
    voltage: np.ndarray  # mean over the step that ends at a sample [V], (n,)
    angle: np.ndarray  # of the shaft, unwrapped [rad], (n,)
    temperature: np.ndarray | None = None  # of the winding [K], (n,), or None
    load: np.ndarray | None = None  # measured torque that opposes the shaft [N m], (n,), or None
    # times [s] and measured torque of the motor [N m], (k,) each, or None
    torque: tuple[np.ndarray, np.ndarray] | None = None
    # standard deviation of the measured angle [rad]; None if `angle` was not interpolated
    angle_noise: float | None = None
    angle_step: float | None = None  # sampling interval of the measured angle [s]; None if `angle` was not interpolated
    # root mean square of the sum of the phase currents over that of a phase; 0 if not all are recorded
    phase_sum: float = 0.0


def motor_recording(name: str, recording: Recording, pole_pairs: float, commanded: bool = False) -> MotorRecording:
    """A recording of a motor on the grid of its currents.

    Args:
        recording: with currents and voltages in the stator's axes or of the phases, and the motor's angle
        commanded: whether the commands of the inverter are used as voltages

    Raises:
        InputError: channels are missing, constant or too slow, or the recording is too short
    """
    currents, voltages = _CURRENT, _COMMAND if commanded else _VOLTAGE
    recording = complete(recording, (*currents, *voltages))
    _require_channels(name, recording, currents, voltages)
    electrical = "motor_angle_mechanical" not in recording
    angle = "motor_angle_electrical" if electrical else "motor_angle_mechanical"
    if angle not in recording:
        raise InputError(
            f"{name} lacks the motor's angle; name motor_angle_mechanical or motor_angle_electrical in a channel map, "
            "or record it"
        )
    step = _step(name, recording, currents)
    start, stop = _common(name, recording, (*currents, *voltages, angle))
    count = int((stop - start) / step + 1e-6) + 1
    recording.require_grid(1.0 / step, start, count)
    grid = start + step * np.arange(count)
    if len(grid) < _FEWEST:
        raise InputError(
            f"{name} holds {len(grid)} samples of the currents; record at least {_FEWEST}, at the rate of "
            "the modulation"
        )
    current = _vector(recording, currents, grid, step)
    voltage = _vector(recording, voltages, grid, step)
    share = 1.0 / pole_pairs if electrical else 1.0
    turned, noise, slower = _angle(recording[angle].time, recording[angle].values, grid)
    turned, noise = share * turned, share * noise
    _require(name, current, voltage, turned, pole_pairs)
    warmth, load = (_interpolated(recording, each, grid) for each in ("motor_temperature", "load_torque"))
    torque = None
    if "motor_torque" in recording:
        channel = recording["motor_torque"].sliced(float(grid[0]), float(grid[-1]))
        torque = (channel.time, channel.values) if len(channel.time) > _FEW else None
    rest = (warmth, load, torque, noise, max(slower, step), _phase_sum(recording))
    return MotorRecording(name, step, grid, current, voltage, turned, *rest)


def _require_channels(name: str, recording: Recording, *vectors: tuple[str, str]) -> None:
    for channels in vectors:
        missing = " and ".join(each for each in channels if each not in recording)
        if missing:
            raise InputError(
                f"{name} lacks {missing}; the identification of a motor needs currents and voltages in the stator's "
                "axes, or of the phases, and the motor's angle: name them in a channel map, or record them"
            )


def _step(name: str, recording: Recording, currents: tuple[str, ...]) -> float:
    time = recording[currents[0]].time
    step = float(np.median(np.diff(time))) if len(time) > 2 else 0.0
    if not step > 0.0:
        raise InputError(f"{name}: '{currents[0]}' has {len(time)} samples; record at least {SHORTEST:g} s")
    return step


def _common(name: str, recording: Recording, channels: tuple[str, ...]) -> tuple[float, float]:
    for each in channels:
        if not len(recording[each].time):
            raise InputError(f"{name}: '{each}' holds no samples; check the recording and the channel map")
    start = max(float(recording[each].time[0]) for each in channels)
    stop = min(float(recording[each].time[-1]) for each in channels)
    if stop - start < SHORTEST:
        raise InputError(
            f"{name} holds {max(stop - start, 0.0):.3g} s in which all channels are present; record at least "
            f"{SHORTEST:g} s, at best 10 s or more to and fro"
        )
    return start, stop


def _vector(recording: Recording, channels: tuple[str, ...], grid: np.ndarray, step: float) -> np.ndarray:
    aligned = recording.align(channels, 1.0 / step, "hold", 0.6 * step, float(grid[0]), float(grid[-1]) + 0.5 * step)
    alpha, beta = aligned.values[: len(grid)].T
    return np.asarray(alpha + 1j * beta)


def _phase_sum(recording: Recording) -> float:
    """Root mean square of the sum of the phase currents over that of a phase [-]."""
    phases = [recording[name].values for name in _PHASES if name in recording]
    if len(phases) < len(_PHASES) or len({len(each) for each in phases}) > 1:
        return 0.0
    size = float(np.sqrt(np.nanmean(np.square(phases))))
    return float(np.sqrt(np.nanmean(np.square(np.sum(phases, axis=0))))) / size if size > 0.0 else 0.0


def _angle(time: np.ndarray, values: np.ndarray, grid: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Unwrapped angle on the grid, standard deviation of its noise, and its own sampling interval [s]."""
    known = np.isfinite(values)
    time, values = time[known], np.unwrap(values[known])
    step = float(np.median(np.diff(time)))
    after = np.clip(np.searchsorted(time, grid), 1, len(time) - 1)
    gap = time[after] - time[after - 1]
    return np.where(gap <= 3.0 * step, np.interp(grid, time, values), np.nan), white_noise(values), step


def _interpolated(recording: Recording, name: str, grid: np.ndarray) -> np.ndarray | None:
    if name not in recording:
        return None
    channel = recording[name]
    known = np.isfinite(channel.values)
    if known.mean() < 1.0 - _MISSING or known.sum() < 2:
        return None
    return np.asarray(np.interp(grid, channel.time[known], channel.values[known]))


def _require(name: str, current: np.ndarray, voltage: np.ndarray, angle: np.ndarray, pole_pairs: float) -> None:
    known = np.isfinite(current) & np.isfinite(voltage) & np.isfinite(angle)
    if known.mean() < 1.0 - _MISSING:
        raise InputError(
            f"{name}: {100.0 * (1.0 - known.mean()):.3g} % of the samples of currents, voltages and angle are missing "
            "on a common grid; record currents and voltages at one rate, that of the modulation"
        )
    for what, values in (("currents", current), ("voltages", voltage)):
        if np.nanstd(values) == 0.0:
            raise InputError(f"{name}: the {what} are constant throughout; check the channel map")
    fastest = pole_pairs * float(np.nanpercentile(np.abs(np.diff(angle)), 99.0))
    if fastest > FASTEST:
        raise InputError(
            f"{name}: the rotor turns by {fastest:.2g} rad electrical from sample to sample; record faster, and check "
            "motor_pole_pairs and whether the angle is the mechanical one"
        )
