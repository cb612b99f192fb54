"""Whether currents and voltages are those of one motor, without its angle sensor."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

WINDOW: Annotated[float, "s"] = 5e-3
"""Over which the induced voltage is averaged: at 400 rad/s electrical the rotor turns by 2 rad meanwhile."""

SLOWEST, FASTEST = 0.2, 1.7
"""Change of the flux over a window, in multiples of the flux: below, noise counts; at 2 the turn is half a circle."""

LEAST_WINDOWS = 100
"""Half a second of turning."""

FITS = 0.04
"""Share of the induced voltage that may contradict its own turning: fault-free drives leave 0.008 to 0.021, a clipped
current 0.075 and more, any other change of currents or voltages more than 0.13."""


class InducedVoltage:
    """Collects how the voltage that the magnets induce turns, and how large it is.

    The change of the flux over a window is the chord 2 psi sin(turn / 2), and successive chords turn as the rotor does:
    size and turning of the induced voltage give the same speed, whatever the sensor reads.

    Args:
        resistance: [ohm]
        inductance: [H]
        flux: of the magnets [V s]
        sample_time: [s]

    Source: Reinelt et al., eqs (17), (18), integrated over a window.
    """

    def __init__(self, resistance: float, inductance: float, flux: float, sample_time: float):
        self._resistance, self._inductance, self._flux, self._time = resistance, inductance, flux, sample_time
        self._window = max(round(WINDOW / sample_time), 1)
        self._rest = np.zeros((2, 0), complex)
        self._chords = np.zeros(0, complex)
        self._windows, self._apart, self._power = 0, 0.0, 0.0

    def add(self, current: np.ndarray, voltage: np.ndarray) -> None:
        """The next piece: vectors in the stator's axes as complex numbers, current [A] and voltage [V], (n,) each."""
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
        self._chords = chords[-2:]
        self._compare(chords)

    def _compare(self, chords: np.ndarray) -> None:
        """Size of every chord against the turn from the one before to the one after."""
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
        """Share of the induced voltage that contradicts its own turning; NaN where the motor hardly turned."""
        return math.sqrt(self._apart / self._power) if self._windows >= LEAST_WINDOWS else math.nan
