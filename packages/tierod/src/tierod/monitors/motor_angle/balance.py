"""Voltage balance of a motor over a recording, and errors of the recording that it shows by name."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from math import nan
from typing import Annotated, NamedTuple

import numpy as np

from tierod.methods.identification.experiment import solved
from tierod.models.stator_frame_motor import SampledMotorParameters

# Time over which the equation is integrated; at 400 rad/s electrical the rotor turns by 2 rad meanwhile.
WINDOW: Annotated[float, "s"] = 5e-3
PART = 100  # windows per part; halves are cut between parts
MOST_PARTS = 1000  # largest number of parts; beyond, neighbours are merged
# Indices of the columns, each followed by its mirror image; the signs are zero where the voltages are measured.
_CURRENT, _GAIN, _ROTOR, _SIGNS, _SALIENT, _VOLTAGE = 0, 2, 4, 6, 8, 12
# Which of the four saliency columns belongs to mirrored currents and a backward angle.
_TURNED = {(False, False): 0, (True, True): 1, (True, False): 2, (False, True): 3}

_THIRD = 2.0 * math.pi / 3.0

# Rotation of a mirrored vector by which alpha and beta are exchanged.
AXES_SWAPPED: Annotated[float, "rad"] = 0.5 * math.pi
# Range of the change of flux over a window, in multiples of the flux; below it noise dominates, and a change of 2 is
# half a turn.
SLOWEST, FASTEST = 0.2, 1.7
LEAST_TURNING = 100  # least number of windows, half a second of turning
# Share of the induced voltage up to which it may contradict its own rotation [-]; fault-free drives leave 0.008 to
# 0.021, a clipped current 0.075 and more, any other change of currents or voltages more than 0.13.
FITS = 0.04


class Reading(NamedTuple):
    """One hypothesis on how currents and angle must be read."""

    mirrored: bool = False  # currents with two phases swapped
    shifted: Annotated[float, "rad"] = 0.0  # currents with their phases rotated by this angle [rad]
    backwards: bool = False  # an angle with reversed direction


AS_RECORDED = Reading()
_PHASES = tuple(Reading(*each) for each in product((False, True), (0.0, _THIRD, -_THIRD), (False, True)))
# All readings: the recorded one first, the last two with the stator's axes swapped.
READINGS = (*_PHASES, Reading(True, AXES_SWAPPED), Reading(True, AXES_SWAPPED, True))


@dataclass(frozen=True)
class Balance:
    """Least-squares fit of the voltage for one reading."""

    reading: Reading  # reading of currents and angle
    resistance: float  # resistance [ohm]
    inductance: float  # mean of the inductances along and across the flux [H]
    flux: float  # flux of the magnets [V s]
    flux_direction: float  # electrical direction of the flux, relative to that of the sensor [rad]
    unexplained: float  # root mean square of the residual, as a share of the voltage's
    windows: int  # number of windows
    change: float  # change of the current over a window, root mean square [A]
    turn: float  # turn of the rotor's direction over a window, root mean square, electrical [rad]


@dataclass(frozen=True)
class AxisBalance:
    """Least-squares fit of the voltage with free inductances of both axes, whatever the vehicle file says."""

    # Resistance [ohm] and flux of the magnets [V s].
    resistance: float
    flux: float
    flux_direction: float  # electrical direction of the flux, relative to that of the sensor [rad]
    # Inductances along and across the flux [H].
    along: float
    across: float
    # Change of each current over a window, root mean square [A].
    change_along: float
    change_across: float
    unexplained: float  # root mean square of the residual, as a share of the voltage's
    windows: int  # number of windows


class VoltageBalance:
    """Sums for u = R i + L di/dt + d(psi e^(j theta))/dt over windows that begin and end with a reading of the angle.

    Vectors are complex numbers; the flux of a salient motor's current is L (i + apart e^(2j theta) conj(i)), with L the
    mean of both inductances. Source: Reinelt et al., eqs (17), (18), integrated over a window.
    """

    def __init__(self, pole_pairs: float, sample_time: float, apart: float = 0.0):
        self._pole_pairs, self._time, self._apart = pole_pairs, sample_time, apart
        self._parts: list[np.ndarray] = []
        self._windows: list[int] = []
        self._rest = np.zeros((4, 0), complex)

    def add(self, current: np.ndarray, voltage: np.ndarray, angle: np.ndarray, signs: np.ndarray) -> None:
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
        pairs = range(0, len(self._parts), 2)
        self._parts = [np.sum(self._parts[k : k + 2], axis=0) for k in pairs]
        self._windows = [sum(self._windows[k : k + 2]) for k in pairs]

    def over(self, reading: Reading, share: tuple[float, float] = (0.0, 1.0)) -> Balance | None:
        """The balance of one reading; None where the windows do not determine its coefficients."""
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
        """The balance of the recording as it is with free inductances; None where the windows do not determine it."""
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
        # By energy, since a motor that stands for half of the drive says nothing about it.
        energy = np.cumsum([part[_VOLTAGE, _VOLTAGE].real for part in self._parts])
        at = energy / max(energy.max(initial=0.0), 1e-12)
        counted = np.flatnonzero((at > share[0]) & (at <= share[1] + 1e-9))
        gram = np.sum([self._parts[k] for k in counted], axis=0) if len(counted) else np.zeros((0, 0))
        return gram, sum(self._windows[k] for k in counted)

    def _fitted(self, gram: np.ndarray, reading: Reading, windows: int, zero: float) -> Balance | None:
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
        apart: inductance along the flux less that across [H]: current along the flux then adds to the flux of
            the magnets, as the active flux psi + (L_sd - L_sq) i_sd

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
        """Chords of the magnets' flux alone, one less at both ends; the active flux is normal to its own change."""
        units = chords / np.maximum(np.abs(chords), 1e-12)
        across, turning = units[1:] + units[:-1], np.angle(chords[1:] * np.conj(chords[:-1]))
        rotor = -1j * np.sign(turning) * across / np.maximum(np.abs(across), 1e-12)
        along = (edges[1:-1] * np.conj(rotor)).real
        return np.asarray(chords[1:-1] - np.diff(self._salient * along * rotor))

    def _compare(self, chords: np.ndarray) -> None:
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


LEAST_WINDOWS = 100  # least number of windows, half a second of driving
# Largest unexplained share of the voltage for a valid reading; fault-free recordings leave 0.01 to 0.05, and one that
# changed during the drive, as with a fault, 0.2 and more.
CLEAN = 0.1
# Residual over that with the inductances of the vehicle file from which other ones explain a contradiction; a saliency
# of 1.5 that the file lacks leaves 0.1 to 0.7, a fault of the sensor 0.94 and more.
EXPLAINS = 0.8
# Factor of a resistance's change with temperature; a winding from -40 to 120 degrees has 0.76 to 1.4 of its resistance
# at 20.
WARMTH = 1.5
# Factor within which two scales count as equal; magnets from -40 to 120 degrees and a data sheet's inductance stay
# within it.
ALIKE = 1.15
# Least electrical turn over a window for the flux, root mean square [rad]; 25 times the noise of a sensor.
LEAST_TURN = 0.05
# Largest difference between the flux directions of a half and of the whole, electrical [rad]; an inductance that is
# wrong by half turns it by some 0.05, and a sensor whose angle leaps by more is itself faulty.
SAME_DIRECTION = 0.1
# Least change of the current over a window for the inductance, over the noise of the current; noise of both ends makes
# the inductance too small by 2 / 5^2 = 8 %, less than `ALIKE` allows. Those of each axis are freed from this error.
LEAST_CHANGE = 5.0


def misread(collected: VoltageBalance, p: SampledMotorParameters, current_noise: float) -> tuple[str, str] | None:
    """Cause and action of an error of the whole recording; None where there is none, or no reading explains it."""
    balance = collected.best()
    if balance is None or balance.windows < LEAST_WINDOWS or balance.turn < LEAST_TURN:
        return None
    axes = balance.reading == AS_RECORDED and other_inductances(collected, p, current_noise)
    if axes:
        return axes
    if balance.unexplained > CLEAN:
        return None
    if not all(_agrees(half, balance) for half in collected.halves(balance.reading)):
        return None
    return cause_of(balance, p, current_noise)


def _agrees(half: Balance | None, whole: Balance) -> bool:
    """Whether a half agrees with the whole; a change during the drive is a fault, not an error of the recording."""
    if half is None or abs(math.remainder(half.flux_direction - whole.flux_direction, math.tau)) > SAME_DIRECTION:
        return False
    return all(_near(getattr(half, name) / getattr(whole, name), 1.0) for name in ("resistance", "inductance", "flux"))


def cause_of(balance: Balance, p: SampledMotorParameters, current_noise: float) -> tuple[str, str] | None:
    """Cause and action from a balance; None where it is that of the motor in the vehicle file."""
    named = _phases(balance) or _sign(balance)
    return named if named or balance.change < LEAST_CHANGE * current_noise else _scale(balance, p)


def _phases(balance: Balance) -> tuple[str, str] | None:
    mirrored, shifted, backwards = balance.reading
    if not mirrored and not shifted:
        return None
    turned = abs(balance.flux_direction) > 0.25 * math.pi
    whose = "voltages" if (backwards if mirrored else turned) else "currents"
    if mirrored:
        if shifted == AXES_SWAPPED:
            return f"the {whose} are swapped: alpha and beta", "exchange alpha and beta in the channel map"
        two = "b and c" if not shifted else "a and b" if shifted > 0.0 else "a and c"
        if whose == "voltages":
            two = "two of them"
        return f"the phases of the {whose} are swapped: {two}", f"exchange {two} in the channel map"
    return (
        f"the phases of the {whose} are in the wrong order: shifted by one",
        f"name the phases of the {whose} in the order of the motor's phases",
    )


def _sign(balance: Balance) -> tuple[str, str] | None:
    if not (balance.resistance < 0.0 and balance.inductance < 0.0):
        return None
    whose = "voltages" if abs(balance.flux_direction) > 0.5 * math.pi else "currents"
    return (
        f"the {whose} have the wrong sign: they fit a resistance of {balance.resistance:.3g} ohm",
        f"give the {whose} a factor of -1 in the channel map",
    )


def _scale(balance: Balance, p: SampledMotorParameters) -> tuple[str, str] | None:
    if min(balance.resistance, balance.inductance, balance.flux) <= 0.0:
        return None
    resistance = balance.resistance / p.motor_resistance
    inductance = balance.inductance / (0.5 * (p.motor_inductance + p.inductance_across))
    flux = balance.flux / p.motor_flux
    if not _near(flux, 1.0) and _near(inductance, flux):
        if _near(resistance, 1.0, WARMTH) and not _near(resistance, flux, ALIKE):
            true = p.sample_time / flux
            return (
                f"inductance and flux are both {flux:.2g} times those of the vehicle file, the resistance is not: the "
                f"samples come every {1e3 * true:.2g} ms, but by their time stamps every {1e3 * p.sample_time:.3g} ms",
                "correct the time of the recording: its unit or its sampling interval",
            )
        if _near(resistance, flux, WARMTH):
            return (
                f"resistance, inductance and flux are all {flux:.2g} times those of the vehicle file: so are the "
                "recorded voltages",
                "correct factor and unit of the voltages in the channel map",
            )
    # A wrong scale of the currents changes resistance and inductance by the same factor.
    alone = abs(math.log(resistance)) < abs(math.log(resistance / inductance))
    if _near(flux, 1.0) and not _near(inductance, 1.0) and _near(resistance, inductance, WARMTH) and not alone:
        return (
            f"resistance and inductance are both {inductance:.2g} times those of the vehicle file, the flux is not: "
            f"the recorded currents are {1.0 / inductance:.2g} times the true ones",
            "correct factor and unit of the currents in the channel map; amplitude-invariant vectors are expected",
        )
    return None


class Departure(NamedTuple):
    """Parameters of a motor over those of the vehicle file; NaN where the recording does not determine them."""

    resistance: float
    flux: float
    along: float
    across: float

    @classmethod
    def of(cls, axes: AxisBalance, p: SampledMotorParameters, current_noise: float) -> Departure:
        """The departure of a balance from the parameters of the vehicle file; noise of the current in [A]."""
        pairs = ((axes.along, axes.change_along), (axes.across, axes.change_across))
        nominal = (p.motor_inductance, p.inductance_across)
        along, across = (
            # Noise at both ends of a window adds to the change, and is no change of the flux.
            value / of / (1.0 - 2.0 * (current_noise / change) ** 2) if change > LEAST_CHANGE * current_noise else nan
            for (value, change), of in zip(pairs, nominal, strict=True)
        )
        return cls(axes.resistance / p.motor_resistance, axes.flux / p.motor_flux, along, across)

    def in_words(self) -> str:
        """The parameters that differ from the vehicle file by more than temperature explains; "" without any."""
        limits = {"resistance": WARMTH, "flux": ALIKE, "along": ALIKE, "across": ALIKE}
        named = {"along": "inductance along the flux", "across": "inductance across the flux"}
        apart = [
            f"{value:.2f} times the {named.get(name, name)}"
            for name, value in self._asdict().items()
            if not math.isnan(value) and not _near(value, 1.0, limits[name])
        ]
        return " and ".join(apart) and f"{' and '.join(apart)} of the vehicle file{self._scaled()}"

    def _scaled(self) -> str:
        if not _near(self.flux, 1.0) or _near(self.across, 1.0) or not _near(self.resistance, self.across, WARMTH):
            return ""
        return f", as with currents {1.0 / self.across:.1f} times the true ones"


def other_inductances(
    collected: VoltageBalance, p: SampledMotorParameters, current_noise: float
) -> tuple[str, str] | None:
    """Cause and action where only inductances differ from the vehicle file; None otherwise. Arguments as of `misread`.

    A wrong scale of the currents changes the resistance by the same factor, and is no other inductance.
    """
    shares = ((0.0, 1.0), (0.0, 0.5), (0.5, 1.0))
    found = [axes for share in shares if (axes := collected.axes(share)) is not None]
    if len(found) < len(shares) or found[0].unexplained > CLEAN or min(found[0].along, found[0].across) <= 0.0:
        return None
    assumed = collected.axes(known=(p.motor_inductance, p.inductance_across))
    if assumed is None or found[0].unexplained > EXPLAINS * assumed.unexplained:
        return None
    whole, *halves = (Departure.of(axes, p, current_noise) for axes in found)
    if not _near(whole.resistance, 1.0, WARMTH) or not _near(whole.flux, 1.0):
        return None
    wrong = {
        name: value
        for name, value in (("along", whole.along), ("across", whole.across))
        if not math.isnan(value) and not _near(value, 1.0) and not _near(value, whole.resistance)
    }
    both = [(getattr(half, name), value) for half in halves for name, value in wrong.items()]
    if not wrong or not all(math.isnan(one) or _near(one, all_) for one, all_ in both):
        return None
    return _other_inductance(wrong, whole, p)


def _other_inductance(wrong: dict[str, float], whole: Departure, p: SampledMotorParameters) -> tuple[str, str]:
    are = "inductances {} the flux are" if len(wrong) > 1 else "inductance {} the flux is"
    factors = " and ".join(f"{value:.2f}" for value in wrong.values())
    cause = (
        f"the {are.format(' and '.join(wrong))} {factors} times that of the vehicle file, resistance and flux are "
        "those of the file"
    )
    if p.motor_saliency is None:
        cause += ": it gives one inductance, but those along and across the flux may differ"
    if not math.isnan(whole.along) and not math.isnan(whole.across):
        along, across = whole.along * p.motor_inductance, whole.across * p.inductance_across
        return (
            cause,
            f"give motor_inductance = {along:.3g} H (along the flux) and motor_saliency = {across / along:.2f} (L_q "
            "over L_d) in the vehicle file",
        )
    if "across" in wrong and p.motor_saliency is None:
        ratio = wrong["across"]
        return (
            cause,
            f"with interior magnets give motor_saliency = {ratio:.2f} (L_q over L_d) beside the motor_inductance along "
            f"the flux; with surface magnets multiply motor_inductance by {ratio:.2f}",
        )
    return cause, "correct motor_inductance and motor_saliency in the vehicle file: 'tierod identify motor' finds both"


def _near(value: float, other: float, factor: float = ALIKE) -> bool:
    return other / factor < value < other * factor
