"""Test of a motor's voltage equation over a whole recording: as a balance, and without the angle sensor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Annotated, NamedTuple

import numpy as np

from tierod.methods.identification.regression import solved

WINDOW: Annotated[float, "s"] = 5e-3
"""Time over which the equation is integrated; at 400 rad/s electrical the rotor turns by 2 rad meanwhile."""

PART = 100
"""Windows per part; halves are cut between parts."""

MOST_PARTS = 1000
"""Largest number of parts; beyond, neighbours are merged."""

_CURRENT, _GAIN, _ROTOR, _SIGNS, _SALIENT, _VOLTAGE = 0, 2, 4, 6, 8, 12
"""Indices of the columns, each followed by its mirror image; the signs are zero where the voltages are measured."""

_TURNED = {(False, False): 0, (True, True): 1, (True, False): 2, (False, True): 3}
"""Which of the four saliency columns belongs to mirrored currents and a backward angle."""

_THIRD = 2.0 * math.pi / 3.0

AXES_SWAPPED: Annotated[float, "rad"] = 0.5 * math.pi
"""Rotation of a mirrored vector by which alpha and beta are exchanged."""

SLOWEST, FASTEST = 0.2, 1.7
"""Range of the change of flux over a window, in multiples of the flux; below it noise dominates, and a change of 2 is
half a turn."""

LEAST_TURNING = 100
"""Least number of windows, half a second of turning."""

FITS = 0.04
"""Share of the induced voltage up to which it may contradict its own rotation [-]; fault-free drives leave 0.008 to
0.021, a clipped current 0.075 and more, any other change of currents or voltages more than 0.13."""


class Reading(NamedTuple):
    """One hypothesis on how currents and angle must be read.

    Args:
        mirrored: currents with two phases swapped
        shifted: currents with their phases rotated by this angle [rad]
        backwards: an angle with reversed direction
    """

    mirrored: bool = False
    shifted: Annotated[float, "rad"] = 0.0
    backwards: bool = False


AS_RECORDED = Reading()
_PHASES = tuple(Reading(*each) for each in product((False, True), (0.0, _THIRD, -_THIRD), (False, True)))
READINGS = (*_PHASES, Reading(True, AXES_SWAPPED), Reading(True, AXES_SWAPPED, True))
"""All readings: the recorded one first, the last two with the stator's axes swapped."""


@dataclass(frozen=True)
class Balance:
    """Least-squares fit of the voltage for one reading.

    Args:
        reading: reading of currents and angle
        resistance: resistance [ohm]
        inductance: mean of the inductances along and across the flux [H]
        flux: flux of the magnets [V s]
        flux_direction: electrical direction of the flux, relative to that of the sensor [rad]
        unexplained: root mean square of the residual, as a share of the voltage's
        windows: number of windows
        change: change of the current over a window, root mean square [A]
        turn: turn of the rotor's direction over a window, root mean square, electrical [rad]
    """

    reading: Reading
    resistance: float
    inductance: float
    flux: float
    flux_direction: float
    unexplained: float
    windows: int
    change: float
    turn: float


@dataclass(frozen=True)
class AxisBalance:
    """Least-squares fit of the voltage with free inductances of both axes, whatever the vehicle file says.

    Args:
        resistance, flux: resistance [ohm] and flux of the magnets [V s]
        flux_direction: electrical direction of the flux, relative to that of the sensor [rad]
        along, across: inductances along and across the flux [H]
        change_along, change_across: change of each current over a window, root mean square [A]
        unexplained: root mean square of the residual, as a share of the voltage's
        windows: number of windows
    """

    resistance: float
    flux: float
    flux_direction: float
    along: float
    across: float
    change_along: float
    change_across: float
    unexplained: float
    windows: int


class VoltageBalance:
    """Sums for u = R i + L di/dt + d(psi e^(j theta))/dt over windows that begin and end with a reading of the angle.

    Args:
        pole_pairs: electrical turns per turn of the shaft
        sample_time: sampling interval [s]
        apart: L_sd less L_sq, over their sum

    Vectors are complex numbers; the flux of a salient motor's current is L (i + apart e^(2j theta) conj(i)), with L the
    mean of both inductances. Source: Reinelt et al., eqs (17), (18), integrated over a window.
    """

    def __init__(self, pole_pairs: float, sample_time: float, apart: float = 0.0):
        self._pole_pairs, self._time, self._apart = pole_pairs, sample_time, apart
        self._parts: list[np.ndarray] = []
        self._windows: list[int] = []
        self._rest = np.zeros((4, 0), complex)

    def add(self, current: np.ndarray, voltage: np.ndarray, angle: np.ndarray, signs: np.ndarray) -> None:
        """Add the next piece.

        Args:
            current: current in stator coordinates [A], (n,)
            voltage: mean voltage over the sample that ends [V], (n,)
            angle: mechanical angle of the sensor; NaN where a sample has none [rad], (n,)
            signs: signs of the phase currents, where the inverter loses a voltage with them, else zeros (n,)
        """
        whole = np.concatenate([self._rest, np.vstack([current, voltage, angle, signs])], axis=1)
        readings = np.flatnonzero(np.isfinite(whole[2].real))
        if len(readings) < 2:
            self._rest = whole if len(readings) else whole[:, :0]
            return
        every = max(round(WINDOW / self._time / float(np.median(np.diff(readings)))), 1)
        edges = readings[::every]
        self._rest = whole[:, edges[-1] :]
        if len(edges) > 1:
            self._count(whole, edges)

    def _count(self, whole: np.ndarray, edges: np.ndarray) -> None:
        current, voltage, angle, signs = whole
        rotor = np.exp(1j * self._pole_pairs * angle.real[edges])
        steps = np.vstack([0.5 * (each[1:] + each[:-1]) for each in (current, signs)] + [voltage[1:]])
        sums = self._time * np.diff(np.pad(np.cumsum(np.nan_to_num(steps), axis=1), ((0, 0), (1, 0)))[:, edges], axis=1)
        missing = np.pad(np.cumsum(~np.isfinite(steps).all(axis=0)), (1, 0))[edges]
        gain = np.diff(current[edges])
        whole_windows = (np.diff(missing) == 0) & np.isfinite(gain)
        turned = np.diff(rotor)
        facing = np.diff(rotor**2 * np.conj(current[edges]))
        aside = np.diff(rotor**2 * current[edges])
        columns = [sums[0], gain, turned, sums[1], facing, aside]
        rows = np.vstack([side for each in columns for side in (each, np.conj(each))] + [sums[2]])[:, whole_windows]
        for start in range(0, rows.shape[1], PART):
            part = rows[:, start : start + PART]
            self._parts.append(np.conj(part) @ part.T)
            self._windows.append(part.shape[1])
        if len(self._parts) > MOST_PARTS:
            self._merge()

    def _merge(self) -> None:
        """Merge pairs of neighbouring parts, so that memory stays bounded over days of driving."""
        pairs = range(0, len(self._parts), 2)
        self._parts = [np.sum(self._parts[k : k + 2], axis=0) for k in pairs]
        self._windows = [sum(self._windows[k : k + 2]) for k in pairs]

    def over(self, reading: Reading, share: tuple[float, float] = (0.0, 1.0)) -> Balance | None:
        """The balance of one reading; None where the windows do not determine its coefficients.

        Args:
            reading: reading of currents and angle
            share: first and last share of the voltage's energy over the windows that count
        """
        gram, windows = self._sums(share)
        if not windows:
            return None
        balance = self._fitted(gram, reading, windows, 0.0)
        # Saliency depends on the flux direction, which a first fit without it gives.
        if balance is None or not self._apart:
            return balance
        return self._fitted(gram, reading, windows, balance.flux_direction)

    def axes(
        self, share: tuple[float, float] = (0.0, 1.0), known: tuple[float, float] | None = None
    ) -> AxisBalance | None:
        """The balance of the recording as it is with free inductances; None where the windows do not determine it.

        Args:
            share: first and last share of the voltage's energy over the windows that count
            known: inductances along and across the flux that are not free [H]
        """
        balance = self.over(AS_RECORDED, share)
        gram, windows = self._sums(share)
        if balance is None:
            return None
        zero, found = balance.flux_direction, None
        # The direction of the flux is that of a fit with the file's saliency at first.
        for _ in range(3):
            columns = self._axes_columns(zero, signs=gram[_SIGNS, _SIGNS].real > 0.0)
            target = np.zeros(_VOLTAGE + 1, complex)
            target[_VOLTAGE] = 1.0
            free = columns
            if known is not None:
                target, free = target - np.array(known) @ columns[:2], columns[2:]
            normal, right = (np.conj(free) @ gram @ free.T).real, (np.conj(free) @ gram @ target).real
            power = float((np.conj(target) @ gram @ target).real)
            found = solved(normal, right, power, windows, worst=1e6)
            if found is None:
                return None
            along, across, resistance, *flux = ((*(known or ()), *found.values.tolist()))[:5]
            zero = math.atan2(flux[1], flux[0])
        assert found is not None
        changes = [math.sqrt(float((np.conj(each) @ gram @ each).real) / windows) for each in columns[:2]]
        unexplained = math.sqrt(found.left / gram[_VOLTAGE, _VOLTAGE].real)
        size, (change_along, change_across) = math.hypot(*flux), changes
        return AxisBalance(resistance, size, zero, along, across, change_along, change_across, unexplained, windows)

    def _axes_columns(self, zero: float, signs: bool) -> np.ndarray:
        """Weights of the rows: one line each for the inductances along and across, R, flux along and across, signs."""
        columns = self._columns(AS_RECORDED, zero, signs)
        facing, mean = np.zeros((2, _VOLTAGE + 1), complex)
        facing[_SALIENT], mean[_GAIN] = 0.5 * np.exp(2j * zero), 0.5
        return np.vstack([mean + facing, mean - facing, columns[0], columns[2:]])

    def _sums(self, share: tuple[float, float]) -> tuple[np.ndarray, int]:
        """Sums over a share of the windows, and their number."""
        # By energy, since a motor that stands for half of the drive says nothing about it.
        energy = np.cumsum([part[_VOLTAGE, _VOLTAGE].real for part in self._parts])
        at = energy / max(energy.max(initial=0.0), 1e-12)
        counted = np.flatnonzero((at > share[0]) & (at <= share[1] + 1e-9))
        gram = np.sum([self._parts[k] for k in counted], axis=0) if len(counted) else np.zeros((0, 0))
        return gram, sum(self._windows[k] for k in counted)

    def _fitted(self, gram: np.ndarray, reading: Reading, windows: int, zero: float) -> Balance | None:
        """The balance with the saliency of a flux in this direction, electrical [rad]."""
        columns = self._columns(reading, zero, signs=gram[_SIGNS, _SIGNS].real > 0.0)
        normal = (np.conj(columns) @ gram @ columns.T).real
        right = (np.conj(columns) @ gram[:, _VOLTAGE]).real
        power = gram[_VOLTAGE, _VOLTAGE].real
        found = solved(normal, right, power, windows, worst=1e6)
        if found is None or not power > 0.0:
            return None
        resistance, inductance, along, across = found.values[:4].tolist()
        return Balance(
            reading,
            resistance,
            inductance,
            math.hypot(along, across),
            math.atan2(across, along),
            math.sqrt(found.left / power),
            windows,
            math.sqrt(gram[_GAIN, _GAIN].real / windows),
            math.sqrt(gram[_ROTOR, _ROTOR].real / windows),
        )

    def _columns(self, reading: Reading, zero: float, signs: bool) -> np.ndarray:
        """Weights of the rows for a reading: one line each for R, L, flux along, flux across, and signs."""
        side, turn = int(reading.mirrored), np.exp(1j * reading.shifted)
        rotor = _ROTOR + int(reading.backwards)
        weights = np.zeros((5 if signs else 4, _VOLTAGE + 1), complex)
        weights[0, _CURRENT + side] = weights[1, _GAIN + side] = turn
        facing = _SALIENT + _TURNED[reading.mirrored, reading.backwards]
        weights[1, facing] = self._apart * np.conj(turn) * np.exp(2j * zero)
        weights[2, rotor], weights[3, rotor] = 1.0, 1j
        if signs:
            weights[4, _SIGNS + side] = turn
        return weights

    def best(self) -> Balance | None:
        """The reading with the least residual, or the recorded one where another is no clear improvement."""
        found = [balance for balance in map(self.over, READINGS) if balance is not None]
        if not found:
            return None
        best = min(found, key=lambda each: each.unexplained)
        recorded = next((each for each in found if each.reading == AS_RECORDED), best)
        return best if best.unexplained < 0.5 * recorded.unexplained else recorded

    def halves(self, reading: Reading) -> tuple[Balance | None, Balance | None]:
        """The balances of one reading over the first and the second half of the windows."""
        return self.over(reading, (0.0, 0.5)), self.over(reading, (0.5, 1.0))


class InducedVoltage:
    """Comparison of the rotation of the voltage induced by the magnets with its magnitude.

    The change of the flux over a window is the chord 2 psi sin(turn / 2), and successive chords rotate as the rotor
    does: magnitude and rotation of the induced voltage must give the same speed, independent of the sensor.

    Args:
        resistance: resistance [ohm]
        inductance: inductance across the flux [H]
        flux: flux of the magnets [V s]
        sample_time: sampling interval [s]
        apart: inductance along the flux less that across [H]: current along the flux then adds to the flux of the
            magnets, as the active flux psi + (L_sd - L_sq) i_sd

    Source: Reinelt et al., eqs (17), (18), integrated over a window; active flux: Boldea, Paicu, Andreescu, IEEE Trans.
    Power Electronics 23 (2008) 2612.
    """

    def __init__(self, resistance: float, inductance: float, flux: float, sample_time: float, apart: float = 0.0):
        self._resistance, self._inductance, self._flux, self._time = resistance, inductance, flux, sample_time
        self._salient, self._edges = apart, np.zeros(0, complex)
        self._window = max(round(WINDOW / sample_time), 1)
        self._rest = np.zeros((2, 0), complex)
        self._chords = np.zeros(0, complex)
        self._windows, self._apart, self._power = 0, 0.0, 0.0

    def add(self, current: np.ndarray, voltage: np.ndarray) -> None:
        """Add the next piece: complex vectors in stator coordinates, current [A] and voltage [V], (n,) each."""
        whole = np.concatenate([self._rest, np.vstack([current, voltage])], axis=1)
        count = (whole.shape[1] - 1) // self._window
        if count < 1:
            self._rest = whole
            return
        end = count * self._window
        self._rest = whole[:, end:]
        i, u = whole[:, : end + 1]
        between = 0.5 * (i[1:] + i[:-1])
        induced = ((u[1:] - self._resistance * between) * self._time).reshape(count, self._window).sum(axis=1)
        chords = np.concatenate([self._chords, induced - self._inductance * np.diff(i[:: self._window])])
        edges = np.concatenate([self._edges, i[:: self._window][1 if len(self._edges) else 0 :]])
        kept = 4 if self._salient else 2
        self._chords, self._edges = chords[-kept:], edges[-kept - 1 :]
        self._compare(self._of_magnets(chords, edges) if self._salient else chords)

    def _of_magnets(self, chords: np.ndarray, edges: np.ndarray) -> np.ndarray:
        """Chords of the magnets' flux alone, one less at both ends; the active flux is normal to its own change.

        Args:
            chords: chords of the active flux (n,)
            edges: currents between them (n + 1,)
        """
        units = chords / np.maximum(np.abs(chords), 1e-12)
        across, turning = units[1:] + units[:-1], np.angle(chords[1:] * np.conj(chords[:-1]))
        rotor = -1j * np.sign(turning) * across / np.maximum(np.abs(across), 1e-12)
        along = (edges[1:-1] * np.conj(rotor)).real
        return np.asarray(chords[1:-1] - np.diff(self._salient * along * rotor))

    def _compare(self, chords: np.ndarray) -> None:
        """Compare the magnitude of every chord with the rotation between its neighbours."""
        if len(chords) < 3:
            return
        turns = np.angle(chords[1:] * np.conj(chords[:-1]))
        size, turn = np.abs(chords[1:-1]), 0.5 * (turns[1:] + turns[:-1])
        counts = np.isfinite(turn) & (size > SLOWEST * self._flux) & (size < FASTEST * self._flux)
        apart = size[counts] - 2.0 * self._flux * np.abs(np.sin(0.5 * turn[counts]))
        self._windows += int(counts.sum())
        self._apart += float(apart @ apart)
        self._power += float(size[counts] @ size[counts])

    def share(self) -> float:
        """Share of the induced voltage that contradicts its rotation; NaN where the motor hardly turned."""
        return math.sqrt(self._apart / self._power) if self._windows >= LEAST_TURNING else math.nan
