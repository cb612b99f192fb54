"""Identification of an inverter's voltage loss and knee current from recordings of its commands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.recording import Recording
from tierod.methods.identification.experiment import INTERVAL, UNKNOWN_BEFORE, Found
from tierod.methods.identification.motor_electrical import MotorRecording, motor_recording
from tierod.methods.identification.motor_mechanical import refuse_slips
from tierod.physics.motor import StatorVector, phase_signs

# Length of the windows of the voltage balance [s]: longer than the noise of a current, short against a turn
WINDOW = 2e-3
BLOCK = 50  # Number of consecutive windows whose residuals may be correlated: a tenth of a second
KNEES = (0.02, 50.0)  # Limits of the search for the knee current [A]
_STEP = 1e-3  # Step of the logarithm of the knee for its derivative


class InverterFit(NamedTuple):
    """Least squares of a motor behind an inverter."""

    loss: float  # voltage loss of a phase far above the knee [V]
    loss_deviation: float  # standard deviation of the loss [V]
    knee: float  # knee current [A]
    knee_deviation: float
    resistance: float  # resistance, inductance, flux: of the motor [ohm], [H], [V s]
    inductance: float
    flux: float
    unexplained: float  # root mean square residual over that of the command [-]
    without: float  # the same ratio for a model without loss


@dataclass(frozen=True)
class _Windows:
    fixed: np.ndarray
    command: np.ndarray
    parts: tuple[tuple[np.ndarray, int, float], ...]

    def signs(self, knee: float) -> np.ndarray:
        """Integral of the phase currents' signs over every window [s]."""
        found = []
        for current, length, step in self.parts:
            signs = phase_signs(StatorVector(current.real, current.imag), knee)
            found.append(step * _sums(signs.alpha + 1j * signs.beta, length))
        return np.concatenate(found)


def identify_inverter(recordings: Sequence[MotorRecording], pole_pairs: float) -> InverterFit:
    """Least-squares estimate of loss and knee from currents, commanded voltages and the motor's angle.

    The voltage balance over short windows is linear in everything except the knee: the other coefficients follow from
    each knee, and the knee minimises the residuals. Standard deviations allow for correlation over `BLOCK` windows.

    Source: lost_voltage of `tierod.physics.motor` in Reinelt et al., eqs (17), (18), integrated over a window.
    """
    from scipy.optimize import minimize_scalar

    windows = _windows(recordings, pole_pairs)
    low, high = np.log(KNEES)
    grid = np.linspace(low, high, 40)
    left = [_solved(windows, float(np.exp(at)))[1] for at in grid]
    best = int(np.argmin(left))
    between = (grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)])
    found = minimize_scalar(lambda at: _solved(windows, float(np.exp(at)))[1], bounds=between, method="bounded")
    knee = float(np.exp(found.x))
    values, power = _solved(windows, knee)
    deviations = _deviations(windows, knee, values)
    whole = float(np.sum(np.abs(windows.command) ** 2))
    _, bare = _least(windows.fixed, windows.command)
    return InverterFit(
        float(values[4]),
        float(deviations[4]),
        knee,
        float(deviations[5]),
        float(values[0]),
        float(values[1]),
        float(np.hypot(values[2], values[3])),
        float(np.sqrt(power / whole)),
        float(np.sqrt(bare / whole)),
    )


def _windows(recordings: Sequence[MotorRecording], pole_pairs: float) -> _Windows:
    fixed, command, parts = [], [], []
    for seen in recordings:
        length = max(round(WINDOW / seen.step), 1)
        count = (len(seen.time) - 1) // length
        edges = length * np.arange(count + 1)
        current = 0.5 * (seen.current[1:] + seen.current[:-1])[: count * length]
        rotor = np.exp(1j * pole_pairs * seen.angle[edges])
        turned = np.diff(rotor)
        columns = [seen.step * _sums(current, length), np.diff(seen.current[edges]), turned, 1j * turned]
        fixed.append(np.column_stack(columns))
        command.append(seen.step * _sums(seen.voltage[1:][: count * length], length))
        parts.append((current, length, seen.step))
    if not sum(map(len, command)):
        raise InputError("the recordings are too short to find an inverter's knee; record ten seconds of turning")
    return _Windows(np.vstack(fixed), np.concatenate(command), tuple(parts))


def _sums(values: np.ndarray, length: int) -> np.ndarray:
    return np.asarray(values.reshape(-1, length).sum(axis=1))


def _least(columns: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, float]:
    """Real least-squares coefficients and the residual sum of squares; rows with missing values are left out."""
    rows, side = _real(columns, right)
    values, *_ = np.linalg.lstsq(rows, side, rcond=None)
    return values, float(np.sum((side - rows @ values) ** 2))


def _real(columns: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    whole = np.isfinite(columns).all(axis=1) & np.isfinite(right)
    kept, side = columns[whole], right[whole]
    return np.stack([kept.real, kept.imag], axis=1).reshape(-1, columns.shape[1]), np.stack(
        [side.real, side.imag], axis=1
    ).ravel()


def _solved(windows: _Windows, knee: float) -> tuple[np.ndarray, float]:
    return _least(np.column_stack([windows.fixed, windows.signs(knee)]), windows.command)


def _deviations(windows: _Windows, knee: float, values: np.ndarray) -> np.ndarray:
    bend = (windows.signs(knee * np.exp(_STEP)) - windows.signs(knee * np.exp(-_STEP))) / (2.0 * _STEP)
    columns = np.column_stack([windows.fixed, windows.signs(knee), values[4] * bend])
    rows, side = _real(columns, windows.command)
    left = side - rows[:, :5] @ values
    inverse = np.linalg.pinv(rows.T @ rows)
    scores = rows * left[:, None]
    starts = np.arange(0, len(scores), 2 * BLOCK)  # two rows for each window, the real and the imaginary one
    blocks = np.add.reduceat(scores, starts, axis=0)
    return np.sqrt(np.diag(inverse @ (blocks.T @ blocks) @ inverse))


NAMES = ("inverter_voltage_loss", "inverter_knee_current")  # Names of the parameters in a vehicle file
SEEN = 4.0  # Smallest significant loss, in standard deviations
# Residual with a loss over that without, above which no loss is found [-]; a knee above all currents is a resistor
WORTH = 0.95
VAGUE = 0.3  # Standard deviation of the knee's logarithm above which the knee is not identified
UNEXPLAINED = 0.1  # Largest unexplained share of the command [-]: a fault-free bench has 0.01 to 0.02


@dataclass(frozen=True)
class InverterIdentification:
    found: tuple[Found, ...]
    fit: InverterFit
    remarks: tuple[str, ...]

    @property
    def doubt(self) -> str:
        """Reason why the values should not be used; empty if they may be used."""
        fit = self.fit
        if fit.loss < SEEN * fit.loss_deviation or fit.unexplained > WORTH * fit.without:
            return "the commands show no loss of an inverter; they may be measured voltages"
        if fit.unexplained > UNEXPLAINED:
            return f"motor and inverter leave {100.0 * fit.unexplained:.0f} % of the commands unexplained"
        if fit.knee_deviation > VAGUE:
            return "the currents do not identify the knee; record small currents of all phases while the motor turns"
        return ""


def identified_inverter(
    recordings: Mapping[str, Recording],
    pole_pairs: float,
    free: Sequence[str] = (),
    before: Mapping[str, tuple[float, float | None]] | None = None,
    expected: tuple[float, float, float] | None = None,
) -> InverterIdentification:
    """Loss and knee of an inverter from recordings of its commands.

    Args: free: those of `NAMES` to be identified; both by default; expected: resistance [ohm], inductance [H] and flux
    [V s] of the motor, to detect wrong signs, phases and pole pairs; None for no such check.
    """
    for name in free:
        if name not in NAMES:
            raise ParameterError(f"'{name}' is not a parameter of an inverter{nearest(name, NAMES)}")
    seen = [motor_recording(name, each, pole_pairs, commanded=True) for name, each in recordings.items()]
    if expected is not None:
        for each in seen:
            refuse_slips(each, pole_pairs, expected)
    fit = identify_inverter(seen, pole_pairs)
    known = [(before or {}).get(name, UNKNOWN_BEFORE) for name in NAMES]
    low, high = (fit.knee * float(np.exp(sign * INTERVAL * fit.knee_deviation)) for sign in (-1.0, 1.0))
    both = (
        Found.normal(NAMES[0], known[0], fit.loss, fit.loss_deviation, "least squares"),
        Found(NAMES[1], *known[1], fit.knee, fit.knee * fit.knee_deviation, low, high, "least squares"),
    )
    found = tuple(each for each in both if not free or each.name in free)
    remark = (
        f"with the loss {100.0 * fit.unexplained:.2g} % of the commands remain unexplained, without it "
        f"{100.0 * fit.without:.2g} %"
    )
    return InverterIdentification(found, fit, (remark,))
