"""A permanent-magnet motor in stator axes, with known voltages or with the command of its inverter."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import exp, where
from tierod.physics.motor import (
    Direction,
    StatorVector,
    direction,
    electrical_angle,
    electromagnetic_torque,
    park,
    phase_signs,
    rotor_acceleration,
    salient_stator_current_rate,
    stator_current_rate,
)


@dataclass(frozen=True)
class MotorParameters:
    """A permanent-magnet motor, named as in a vehicle file."""

    motor_resistance: Annotated[float, "ohm"]  # of a phase, R_s [ohm]
    motor_inductance: Annotated[float, "H"]  # of a phase, along the flux, L_sd [H]
    motor_flux: Annotated[float, "V*s"]  # linkage of the magnets, Psi_p [V s]
    motor_pole_pairs: Annotated[float, ""]  # z_p [-]
    motor_inertia: Annotated[float, "kg*m**2"]  # J_M [kg m^2]
    motor_damping: Annotated[float, "N*m*s/rad"]  # b_M [N m s/rad]
    motor_saliency: Annotated[float, ""] | None = field(default=None, kw_only=True)  # L_sq over L_sd; None for 1 [-]

    @property
    def inductance_across(self) -> float:
        """Inductance in the q axis, L_sq [H]."""
        return self.motor_inductance if self.motor_saliency is None else self.motor_saliency * self.motor_inductance


@dataclass(frozen=True)
class SampledMotorParameters(MotorParameters):
    # of the modulation [s]; a tenth of the electrical time constant or shorter
    sample_time: Annotated[float, "s"] = 1e-4


class StatorFrameMotor:
    """Motor in stator axes: currents, rotor, load torque, and deviations of resistance and flux as states.

    No quantity is transformed to rotor axes with a measured angle, so that a fault of the angle sensor has no effect.
    While the motor stands, the angle is not observable from the currents; given increments change it.

    Validity: no magnetic saturation; midpoint rule, for electrical speeds up to 0.3 rad per sample. Voltages are means
    over the sample that ends. Source: Reinelt et al., eqs (17), (18) and (16), the latter with the torque of
    `electromagnetic_torque`; for a salient motor eqs (12), (13) in the stator's axes; load, resistance and flux as
    states are additions.
    """

    class State(NamedTuple):
        current_alpha: Annotated[float, "A"]
        current_beta: Annotated[float, "A"]
        speed: Annotated[float, "rad/s"]
        angle: Annotated[float, "rad"]
        load_torque: Annotated[float, "N*m"]
        log_resistance: Annotated[float, ""]
        log_flux: Annotated[float, ""]

    class Input(NamedTuple):
        """Mean voltages over the sample, angle increment at standstill, and whether the motor stands (1 or 0)."""

        voltage_alpha: Annotated[float, "V"]
        voltage_beta: Annotated[float, "V"]
        angle_increment: Annotated[float, "rad"]
        standing: Annotated[float, ""]

    class Output(NamedTuple):
        current_alpha: Annotated[float, "A"]
        current_beta: Annotated[float, "A"]
        speed: Annotated[float, "rad/s"]

    Parameters = SampledMotorParameters

    @staticmethod
    def transition(x: State, u: Input, p: SampledMotorParameters) -> State:
        middle = _ahead(x, _slope(x, u, p), 0.5 * p.sample_time)
        after = _ahead(x, _slope(middle, u, p), p.sample_time)
        return after._replace(angle=where(u.standing, x.angle + u.angle_increment, after.angle))

    @staticmethod
    def output(x: State, u: Input, p: SampledMotorParameters) -> Output:
        return StatorFrameMotor.Output(x.current_alpha, x.current_beta, x.speed)


def _slope(
    x: StatorFrameMotor.State, u: StatorFrameMotor.Input, p: SampledMotorParameters
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    current = StatorVector(x.current_alpha, x.current_beta)
    rotor = direction(electrical_angle(x.angle, p.motor_pole_pairs))
    flux, resistance = p.motor_flux * exp(x.log_flux), p.motor_resistance * exp(x.log_resistance)
    voltage = StatorVector(u.voltage_alpha, u.voltage_beta)
    currents = _current_rate(current, voltage, rotor, x.speed, p, resistance=resistance, flux=flux)
    torque = electromagnetic_torque(
        park(current, rotor), p.motor_pole_pairs, flux, p.motor_inductance, p.inductance_across
    )
    acceleration = rotor_acceleration(torque, x.load_torque, x.speed, p.motor_inertia, p.motor_damping)
    return (currents.alpha, currents.beta, acceleration, x.speed)


def _current_rate(
    current: StatorVector,
    voltage: StatorVector,
    rotor: Direction,
    speed: Scalar,
    p: SampledMotorParameters,
    **warm: Scalar,
) -> StatorVector:
    """Rate of the currents; without saliency in stator axes alone, since the transforms would double the cost."""
    along, pole_pairs = p.motor_inductance, p.motor_pole_pairs
    if p.motor_saliency is None:
        return stator_current_rate(current, voltage, rotor, speed, inductance=along, pole_pairs=pole_pairs, **warm)
    across = p.inductance_across
    return salient_stator_current_rate(
        current, voltage, rotor, speed, inductance_d=along, inductance_q=across, pole_pairs=pole_pairs, **warm
    )


def _ahead(
    x: StatorFrameMotor.State, slope: tuple[Scalar, Scalar, Scalar, Scalar], time: Scalar
) -> StatorFrameMotor.State:
    alpha, beta, acceleration, speed = slope
    return x._replace(
        current_alpha=x.current_alpha + time * alpha,
        current_beta=x.current_beta + time * beta,
        speed=x.speed + time * acceleration,
        angle=x.angle + time * speed,
    )


@dataclass(frozen=True, kw_only=True)
class CommandedMotorParameters(SampledMotorParameters):
    # voltage loss of a phase by dead time and semiconductors, far above the knee [V]
    inverter_voltage_loss: Annotated[float, "V"]
    # current below which the loss of a phase is in proportion to its current [A]
    inverter_knee_current: Annotated[float, "A"]


class CommandedMotor:
    """`StatorFrameMotor` with the command of the inverter as input; voltage loss and knee current are states.

    Validity: currents that change by less than the knee within a sample, since the loss is that of the currents at its
    start. Source: `tierod.physics.motor.lost_voltage`.
    """

    class State(NamedTuple):
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
        return StatorFrameMotor.Output(x.current_alpha, x.current_beta, x.speed)
