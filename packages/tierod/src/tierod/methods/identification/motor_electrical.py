"""Recordings of a motor, and its resistance, inductance and flux from currents, voltages and angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.io.derive import complete
from tierod.methods.analysis.consistency import white_noise
from tierod.methods.identification.experiment import UNKNOWN, Fit, Modulation, Rows, regress
from tierod.physics.motor import resistance_at

SHORTEST = 0.2  # Shortest duration [s]
# Largest electrical rotation from sample to sample [rad]; with a larger one the direction becomes ambiguous
FASTEST = 0.5
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
    """A recording of a motor on the grid of its currents."""
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


_TURN = 1.5  # Largest electrical rotation within a window [rad]: a larger one would average out the rotating voltages
_LENGTHS = (12, 64)  # Smallest and largest length of a window [samples]
# Share of noise in the power of a regressor below which its bias, of the same relative size, is negligible [-]
_QUIET = 2e-4
# Correlation of a regressor with its past above which the past is the instrument [-]: then noise need not be white
_ALIKE_PAST = 0.8


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
    """The voltage equation of a recording."""
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


# Smallest difference of both inductances for a salient motor, in standard deviations and over the value
_SURE, _ALIKE = 4.0, 0.02
# Coefficients without and with saliency: resistance, inductances, flux along and across the sensor's zero
_PLAIN, _APART = ("R", "DQ", "F", "B"), ("R", "D", "Q", "F", "B")
_NAMES = ("motor_resistance", "motor_inductance", "motor_saliency", "motor_flux")


class Value(NamedTuple):
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

    Source: Reinelt et al., eqs (17), (18), integrated over a step, with inductances along and across the flux. Args:
    expected: resistance [ohm], inductance [H], flux [V s], as scales for large standard deviations.
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
