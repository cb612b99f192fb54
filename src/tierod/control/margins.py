"""How far a feedback loop is from instability: margins of gain, phase and delay."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.analysis.frequency_response import frequency_response
from tierod.errors import ParameterError
from tierod.models.linear import LinearSystem


@dataclass(frozen=True)
class Margins:
    """Of a loop that is cut at one place.

    Args:
        gain_up: factor by which the loop's gain may grow until it is unstable; infinite where it may grow without end
        gain_down: factor to which it may fall; zero where it may fall without end
        phase: that may be lost, or gained, at any crossover [rad]
        delay: that may be added [s]
        crossover: highest frequency at which the gain of the loop is one [Hz]
        distance: least distance of the Nyquist curve from -1; 1/distance is the peak of the sensitivity
    """

    gain_up: Annotated[float, ""]
    gain_down: Annotated[float, ""]
    phase: Annotated[float, "rad"]
    delay: Annotated[float, "s"]
    crossover: Annotated[float, "Hz"]
    distance: Annotated[float, ""]


def margins(loop: LinearSystem, sample_time: float) -> Margins:
    """Margins of a discrete loop L, closed by u = -L u.

    Args:
        loop: discrete, one input, one output: what comes back at the cut, with its sign turned
        sample_time: [s]

    Raises:
        ParameterError: the loop is unstable when it is closed: its eigenvalue is named
    """
    require_stable_when_closed(loop)
    half = 0.5 / sample_time
    frequencies = np.geomspace(1e-5 * half, half, 40_000)
    response = frequency_response(loop, frequencies, sample_time).gain[:, 0, 0]
    size, phase = np.abs(response), np.unwrap(np.angle(response))
    at_one = _crossings(np.log(size))
    real = np.concatenate([response.real[_crossings(response.imag)], _ends(loop)])
    returns = -real[real < 0.0]
    left = np.array([_to_minus_one(phase[k]) for k in at_one])
    late = np.array([np.mod(phase[k] + math.pi, math.tau) for k in at_one])
    return Margins(
        float((1.0 / returns[returns < 1.0]).min(initial=math.inf)),
        float((1.0 / returns[returns > 1.0]).max(initial=0.0)),
        float(np.abs(left).min(initial=math.inf)),
        float((late / (math.tau * frequencies[at_one])).min(initial=math.inf)),
        float(frequencies[at_one].max(initial=0.0)),
        float(np.abs(1.0 + response).min()),
    )


def require_stable_when_closed(loop: LinearSystem) -> None:
    """Refuse a discrete loop L that is unstable when it is closed by u = -L u.

    Raises:
        ParameterError: with the eigenvalue
    """
    feedback = np.linalg.inv(np.eye(len(loop.D)) + loop.D)
    eigenvalues = np.linalg.eigvals(loop.A - loop.B @ feedback @ loop.C)
    worst = eigenvalues[np.argmax(np.abs(eigenvalues))]
    if not abs(worst) < 1.0:
        shown = f"{worst.real:.6g}" if worst.imag == 0.0 else f"{worst:.6g}"
        raise ParameterError(
            f"the closed loop is unstable: eigenvalue {shown} of size {abs(worst):.6g}; lower the gain, "
            "or design it for the parameters of this plant"
        )


def _ends(loop: LinearSystem) -> np.ndarray:
    """The response at rest, where it is finite, and at half the rate: both real."""
    n = len(loop.A)
    ends = []
    for z in (1.0, -1.0):
        whole = z * np.eye(n) - loop.A
        if np.linalg.cond(whole) < 1e14:
            ends.append(float((loop.C[:1] @ np.linalg.solve(whole, loop.B[:, :1]))[0, 0] + loop.D[0, 0]))
    return np.array(ends)


def _crossings(values: np.ndarray) -> np.ndarray:
    """Indices before which a curve changes its sign."""
    return np.nonzero(np.diff(np.signbit(values)))[0]


def _to_minus_one(phase: float) -> float:
    """Angle from -180 degrees, the nearer way round."""
    return float(np.mod(phase, math.tau) - math.pi)
