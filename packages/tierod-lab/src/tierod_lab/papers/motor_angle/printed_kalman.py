"""Extended Kalman filter of a motor in the rotor frame, as part of an observer of its angle."""

from __future__ import annotations

from dataclasses import dataclass

from tierod.core.block import Scalar, Tree
from tierod.core.errors import ParameterError, nearest
from tierod.core.graph.derivatives import jacobian
from tierod.methods.estimators.gaussian import Prediction
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.kernels import predict_covariance
from tierod.methods.estimators.linear_algebra import Noise
from tierod.methods.estimators.shapes import Belief, leaf_values
from tierod.models.discretise import discretise
from tierod.monitors.motor_angle.observer import MotorAngleTuning
from tierod.physics.clarke_park import RotorVector
from tierod_lab.papers.motor_angle.dq_motor import DqMotor, DqMotorParameters, LoadedDqMotor

JACOBIANS = ("corrected", "printed")
"""Jacobian (40) by differentiation of the model, or with the misprints of the paper."""


@dataclass(frozen=True)
class PrintedJacobianFilter(KalmanFilter):
    """Kalman filter with the misprints of (40) in its covariance, to measure their effect; not for use.

    Source: Reinelt et al., eq (40): the torque stands in the column of i_sd instead of i_sq, and F[2,1] is divided by
    L_sd instead of L_sq. The prediction of the state stays correct.
    """

    def _predict(self, state: Belief, inputs: Tree, process: Noise, entering: Noise) -> Prediction:
        rows = jacobian(lambda mean: self.model.transition(mean, inputs, self.parameters), state.mean)
        rows[2][0], rows[2][1] = rows[2][1], rows[2][0]
        # The saliency is L_sq/L_sd, and None for a motor without.
        rows[1][0] = rows[1][0] * (self.parameters.continuous.motor_saliency or 1.0)
        covariance = predict_covariance(rows, state.covariance, process)
        return Prediction(leaf_values(self.model.transition(state.mean, inputs, self.parameters)), covariance)


@dataclass(frozen=True)
class KalmanSpeed:
    """Speed by an extended Kalman filter with three states, or four with the load.

    Args:
        filter: result of `speed_filter`
    """

    filter: KalmanFilter

    @property
    def extras(self) -> tuple[str, ...]:
        """Names of the estimates besides the speed."""
        return ("motor_load_torque", "nis") if self._loaded else ("nis",)

    @property
    def _loaded(self) -> bool:
        return "load_torque" in self.filter.model.State._fields

    def start(self) -> Belief:
        return self.filter.init()

    def advance(self, before: Belief, voltage: RotorVector, current: RotorVector) -> tuple[Belief, tuple[Scalar, ...]]:
        model = self.filter.model
        inputs = model.Input(*voltage) if self._loaded else model.Input(*voltage, 0.0)
        after, estimate = self.filter.step(before, self.filter.Sample(inputs, model.Output(*current)))
        return after, (*after.mean[2:], estimate.nis)


def speed_filter(
    p: DqMotorParameters, sample_time: float, tuning: MotorAngleTuning, load: bool = True, reading: str = "corrected"
) -> KalmanFilter:
    """Extended Kalman filter of currents and speed, and of the load on request.

    Args:
        p: parameters of the motor
        sample_time: sampling interval [s], at most a fifth of the electrical time constant, since (34) is discretised
            by Euler's method
        tuning: noise levels; those of voltage, current, speed and load are used
        load: whether the load is a state
        reading: Jacobian (40), "corrected" or "printed"

    Raises:
        ParameterError: the sampling interval is too long, or another reading

    Source: Reinelt et al., eqs (34) to (45). Corrected: the Jacobian (40) comes from the graph, and (42) takes the
    expected output at the predicted state.
    """
    if reading not in JACOBIANS:
        raise ParameterError(f"reading is '{reading}'{nearest(reading, JACOBIANS)}; expected {' or '.join(JACOBIANS)}")
    share = sample_time * p.motor_resistance / p.motor_inductance
    if not share <= 0.2:
        raise ParameterError(
            f"a sample of {sample_time:g} s is {share:.2g} of the electrical time constant; expected 0.2 at most"
        )
    model = discretise(LoadedDqMotor if load else DqMotor, "euler")
    current = (tuning.voltage_noise * sample_time / p.motor_inductance) ** 2
    process = (current, current, tuning.speed_wander**2, tuning.load_wander**2)
    start = (tuning.current_noise**2, tuning.current_noise**2, tuning.first_speed**2, tuning.first_load**2)
    states = 4 if load else 3
    kind = PrintedJacobianFilter if reading == "printed" else KalmanFilter
    return kind(
        model,
        model.Parameters(p, sample_time),
        (0.0,) * states,
        start[:states],
        process[:states],
        (tuning.current_noise**2,) * 2,
    )
