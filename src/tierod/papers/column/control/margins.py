"""Margins of a feedback loop to instability, and the loop of column, observer and control to be judged."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.block import Block, Scalar, Tree, leaves, rebuild, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.core.graph.derivatives import jacobian
from tierod.methods.analysis.frequency_response import frequency_response
from tierod.models.linear import LinearSystem
from tierod.papers.column.control.position_control import ObservedColumn, PositionControl
from tierod.papers.column.control.reference import Reference


@dataclass(frozen=True)
class Margins:
    """Margins of a loop that is cut at one place.

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
    frequencies = _frequencies(loop, sample_time)
    response = _response(loop, frequencies, sample_time)
    at_one = _crossings(frequencies, np.log(np.abs(response)))
    at_axis = _crossings(frequencies, response.imag)
    real = np.concatenate([_response(loop, at_axis, sample_time).real, _ends(loop)])
    returns = -real[real < 0.0]
    phase = np.angle(_response(loop, at_one, sample_time))
    left = np.array([_to_minus_one(each) for each in phase])
    late = np.mod(phase + math.pi, math.tau)
    return Margins(
        float((1.0 / returns[returns < 1.0]).min(initial=math.inf)),
        float((1.0 / returns[returns > 1.0]).max(initial=0.0)),
        float(np.abs(left).min(initial=math.inf)),
        float((late / (math.tau * at_one)).min(initial=math.inf)),
        float(at_one.max(initial=0.0)),
        float(np.abs(1.0 + response).min()),
    )


def _frequencies(loop: LinearSystem, sample_time: float) -> np.ndarray:
    """Up to half the rate, a constant ratio apart, and closer where an eigenvalue rings: its peak is narrow [Hz]."""
    half = 0.5 / sample_time
    parts = [np.geomspace(1e-5 * half, half, 40_000)]
    for eigenvalue in np.linalg.eigvals(loop.A):
        if eigenvalue.imag > 0.0:
            exponent = np.log(eigenvalue) / (math.tau * sample_time)
            width = max(abs(exponent.real), 1e-9 * exponent.imag)
            # An even number of points leaves out the eigenvalue itself, where the gain may be infinite.
            parts.append(exponent.imag + width * np.sinh(np.linspace(-12.0, 12.0, 2000)))
    whole = np.unique(np.concatenate(parts))
    return whole[(whole >= 1e-5 * half) & (whole <= half)]


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


def _response(loop: LinearSystem, frequencies: np.ndarray, sample_time: float) -> np.ndarray:
    return (
        frequency_response(loop, frequencies, sample_time).gain[:, 0, 0] if len(frequencies) else np.zeros(0, complex)
    )


def _crossings(frequencies: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Frequencies at which a curve changes its sign, straight between two of its points."""
    before = np.nonzero(np.diff(np.signbit(values)))[0]
    share = values[before] / (values[before] - values[before + 1])
    return np.asarray(frequencies[before] + share * (frequencies[before + 1] - frequencies[before]))


def _to_minus_one(phase: float) -> float:
    """Angle from -180 degrees, the nearer way round."""
    return float(np.mod(phase, math.tau) - math.pi)


Reading = Callable[[Tree], tuple[ObservedColumn, Scalar]]
"""Finds the observed column and the torque of the hands in what an observer puts out."""


SETTLED = 1000
"""Samples at rest after which an observer counts as settled."""


def read_estimate(estimate: Tree) -> tuple[ObservedColumn, Scalar]:
    """State and torque of the hands from an estimate, or its mean, that names them."""
    named: Tree = getattr(estimate, "mean", estimate)
    motor_angle = named.motor_angle if hasattr(named, "motor_angle") else named.motor_angle_mechanical
    column = ObservedColumn(
        named.steering_wheel_rate, named.motor_speed, named.steering_wheel_angle, motor_angle, named.disturbance_torque
    )
    return column, named.hand_torque


def open_loop(
    plant: LinearSystem, observer: Block, control: PositionControl, read: Reading = read_estimate
) -> LinearSystem:
    """Motor torque commanded for a torque that acts on the column, sign reversed: loop gain for `margins`.

    Args:
        plant: discrete, from the motor's torque to what the observer measures, in its order
        observer: block whose sample is the motor's torque, asked for, that acted in the sample before, and what is
            measured; linearised after `SETTLED` samples at rest
        control: in full hold, its limits not reached, following a reference at rest
        read: finds in the observer's output what the controller takes

    Raises:
        ParameterError: a plant whose outputs are not those that the observer measures
    """
    sample = skeleton(observer.Sample)
    names = [name for name, _ in leaves(sample)][1:]
    count = len(names)
    if plant.C.shape[0] != count or plant.B.shape[1] != 1:
        raise ParameterError(
            f"the plant has the outputs {', '.join(plant.outputs)} and {plant.B.shape[1]} inputs; "
            f"expected {count} outputs, {', '.join(names)}, and one input"
        )
    start = (_settled(observer, count + 1), 0.0, 0.0, 0.0, tuple([0.0] * count))

    def compensator(now: Tree) -> Tree:
        """(observer, integral, torque asked for in the sample before, and in that before it, measured)."""
        observed, integral, asked, before, measured = now
        observed, estimate = observer.step(observed, rebuild(sample, [before, *measured]))
        column, _ = read(estimate)
        state = control.State(asked, integral, 1.0)
        after, output = control.step(state, control.Sample(column, Reference(*[0.0] * 5), 1.0))
        return observed, after.integral, output.motor_torque, asked

    whole = np.array(jacobian(compensator, start), float)
    n, m = len(plant.A), len(whole)
    sensed = whole[:, m:]
    A = np.block([[plant.A, np.zeros((n, m))], [sensed @ plant.C, whole[:, :m]]])
    asked = np.zeros((1, n + m))
    asked[0, -2] = -1.0
    return LinearSystem.of(A, asked, np.concatenate([plant.B, sensed @ plant.D]))


def _settled(observer: Block, samples: int) -> Tree:
    return rebuild(observer.init(), scan(observer, np.zeros((SETTLED, samples))).state.values.tolist())
