"""A permanent-magnet motor behind an inverter of which only the command is known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.graph.maths import exp
from tierod.models.stator_frame_motor import SampledMotorParameters, StatorFrameMotor
from tierod.physics.clarke_park import StatorVector
from tierod.physics.inverter import phase_signs


@dataclass(frozen=True, kw_only=True)
class CommandedMotorParameters(SampledMotorParameters):
    """A motor, and the inverter that feeds it.

    Args:
        inverter_voltage_loss: what dead time and semiconductors take from a phase far above the knee [V]
        inverter_knee_current: below it a phase's loss falls in proportion to its current [A]
    """

    inverter_voltage_loss: Annotated[float, "V"]
    inverter_knee_current: Annotated[float, "A"]


class CommandedMotor:
    """`StatorFrameMotor` fed with the command of the inverter; its voltage loss and knee are states.

    Validity: the loss is that of the currents at the beginning of a sample, for currents that change by less than the
    knee within one. Source: `tierod.physics.inverter.lost_voltage`.
    """

    class State(NamedTuple):
        """That of `StatorFrameMotor`; loss of a phase far above the knee, and logarithm of the knee over its value."""

        current_alpha: Annotated[float, "A"]
        current_beta: Annotated[float, "A"]
        speed: Annotated[float, "rad/s"]
        angle: Annotated[float, "rad"]
        load_torque: Annotated[float, "N*m"]
        log_resistance: Annotated[float, ""]
        log_flux: Annotated[float, ""]
        voltage_loss: Annotated[float, "V"]
        log_knee: Annotated[float, ""]

    Input = StatorFrameMotor.Input
    Output = StatorFrameMotor.Output
    Parameters = CommandedMotorParameters

    @staticmethod
    def transition(x: State, u: StatorFrameMotor.Input, p: CommandedMotorParameters) -> State:
        """One sample on; the input holds the voltage that was commanded."""
        knee = p.inverter_knee_current * exp(x.log_knee)
        signs = phase_signs(StatorVector(x.current_alpha, x.current_beta), knee)
        made = u._replace(
            voltage_alpha=u.voltage_alpha - x.voltage_loss * signs.alpha,
            voltage_beta=u.voltage_beta - x.voltage_loss * signs.beta,
        )
        motor = StatorFrameMotor.transition(StatorFrameMotor.State(*x[:7]), made, p)
        return CommandedMotor.State(*motor, x.voltage_loss, x.log_knee)

    @staticmethod
    def output(x: State, u: StatorFrameMotor.Input, p: CommandedMotorParameters) -> StatorFrameMotor.Output:
        """Currents and speed."""
        return StatorFrameMotor.Output(x.current_alpha, x.current_beta, x.speed)
