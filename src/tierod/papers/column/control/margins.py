"""Stability margins of a feedback loop, and the open loop of column, observer and control."""

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
    """Stability margins of a loop cut at one place.

    Args:
        gain_up: gain margin: factor by which the gain may grow; infinite where it may grow without limit
        gain_down: factor to which the gain may fall; zero where it may fall to zero
        phase: phase margin: least phase lost or gained at any crossover that makes the loop unstable [rad]
        delay: delay margin: largest additional delay [s]
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
    """Stability margins of a discrete loop L, closed by u = -L u.

    Args:
        loop: discrete system from the input at the cut to the negative returned signal
        sample_time: sampling interval [s]

    Raises:
        ParameterError: the closed loop is unstable; its eigenvalue is named
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
    """Logarithmic grid up to half the sampling rate, refined at the narrow peaks of oscillating eigenvalues [Hz]."""
    half = 0.5 / sample_time
    parts = [np.geomspace(1e-5 * half, half, 40_000)]
    for eigenvalue in np.linalg.eigvals(loop.A):
        if eigenvalue.imag > 0.0:
            exponent = np.log(eigenvalue) / (math.tau * sample_time)
            width = max(abs(exponent.real), 1e-9 * exponent.imag)
            # An even number of points avoids the eigenvalue itself, where the gain may be infinite.
            parts.append(exponent.imag + width * np.sinh(np.linspace(-12.0, 12.0, 2000)))
    whole = np.unique(np.concatenate(parts))
    return whole[(whole >= 1e-5 * half) & (whole <= half)]


def require_stable_when_closed(loop: LinearSystem) -> None:
    """Refuse a discrete loop L that is unstable when closed by u = -L u.

    Raises:
        ParameterError: the closed loop is unstable; its eigenvalue is named
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
    """The response at zero frequency, where it is finite, and at half the sampling rate; both are real."""
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
    """Frequencies at which a curve changes its sign, by linear interpolation."""
    before = np.nonzero(np.diff(np.signbit(values)))[0]
    share = values[before] / (values[before] - values[before + 1])
    return np.asarray(frequencies[before] + share * (frequencies[before + 1] - frequencies[before]))


def _to_minus_one(phase: float) -> float:
    """Angle from -180 degrees to a phase, between -pi and pi [rad]."""
    return float(np.mod(phase, math.tau) - math.pi)


Reading = Callable[[Tree], tuple[ObservedColumn, Scalar]]
"""Function that extracts the observed column and the hand torque from the output of an observer."""


SETTLED = 1000
"""Samples at rest until an observer counts as in steady state."""


def read_estimate(estimate: Tree) -> tuple[ObservedColumn, Scalar]:
    """State and hand torque from an estimate, or from its mean, by the names of its fields."""
    named: Tree = getattr(estimate, "mean", estimate)
    motor_angle = named.motor_angle if hasattr(named, "motor_angle") else named.motor_angle_mechanical
    column = ObservedColumn(
        named.steering_wheel_rate, named.motor_speed, named.steering_wheel_angle, motor_angle, named.disturbance_torque
    )
    return column, named.hand_torque


def open_loop(
    plant: LinearSystem, observer: Block, control: PositionControl, read: Reading = read_estimate
) -> LinearSystem:
    """Open loop from the torque on the column to the negative commanded motor torque, for `margins`.

    Args:
        plant: discrete system from the motor torque to the measurements, in the order of the observer
        observer: block whose sample is the motor torque that acted in the last sample and the measurements; it is
            linearised after `SETTLED` samples at rest
        control: control fully engaged and within its limits, with a reference at rest
        read: function that extracts the inputs of the controller from the output of the observer

    Raises:
        ParameterError: the outputs of the plant are not the measurements of the observer
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
        """One step of observer and control on (observer, integral, last command, command before it, measurements)."""
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
