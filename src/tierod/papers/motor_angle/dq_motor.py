"""A permanent-magnet motor in the rotor's axes, with its load as an input or as a state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.models.stator_frame_motor import MotorParameters
from tierod.physics.clarke_park import RotorVector
from tierod.physics.pm_motor import current_rate, electromagnetic_torque, rotor_acceleration


@dataclass(frozen=True)
class DqMotorParameters(MotorParameters):
    """A motor whose inductance may differ along and across the flux.

    Args:
        motor_saliency: L_sq over L_sd, `motor_inductance` being L_sd; 1 where a vehicle file does not tell it []
    """

    motor_saliency: Annotated[float, ""] = 1.0


class DqMotor:
    """Currents in the rotor's axes and speed; the load is an input.

    Validity: no saturation; the axes turn with the rotor's true electrical angle.
    Source: Reinelt et al., eqs (12) to (14), where theta is the mechanical angle; corrected: the torque constant is
    3/2 c_M with amplitude-invariant vectors, and a salient motor makes torque by (L_sd - L_sq) i_sd i_sq too.
    """

    class State(NamedTuple):
        """Currents along and across the rotor's flux, and mechanical speed."""

        current_d: Annotated[float, "A"]
        current_q: Annotated[float, "A"]
        speed: Annotated[float, "rad/s"]

    class Input(NamedTuple):
        """Voltages, and the torque that opposes."""

        voltage_d: Annotated[float, "V"]
        voltage_q: Annotated[float, "V"]
        load_torque: Annotated[float, "N*m"]

    class Output(NamedTuple):
        """Measured currents."""

        current_d: Annotated[float, "A"]
        current_q: Annotated[float, "A"]

    Parameters = DqMotorParameters

    @staticmethod
    def derivative(x: State, u: Input, p: DqMotorParameters) -> State:
        """Eqs (12) to (14)."""
        return DqMotor.State(*_rates(x, u, u.load_torque, p))

    @staticmethod
    def output(x: State, u: Input, p: DqMotorParameters) -> Output:
        """The currents."""
        return DqMotor.Output(x.current_d, x.current_q)


class LoadedDqMotor:
    """The same with the load as a state that stays as it is: process noise lets it walk.

    Source: as `DqMotor`; the state is an addition, since a load that is left out makes the speed wrong.
    """

    class State(NamedTuple):
        """Currents, mechanical speed, and the torque that opposes."""

        current_d: Annotated[float, "A"]
        current_q: Annotated[float, "A"]
        speed: Annotated[float, "rad/s"]
        load_torque: Annotated[float, "N*m"]

    class Input(NamedTuple):
        """Voltages."""

        voltage_d: Annotated[float, "V"]
        voltage_q: Annotated[float, "V"]

    Output = DqMotor.Output
    Parameters = DqMotorParameters

    @staticmethod
    def derivative(x: State, u: Input, p: DqMotorParameters) -> State:
        """Eqs (12) to (14), and a load that stays."""
        return LoadedDqMotor.State(*_rates(x, u, x.load_torque, p), 0.0)

    @staticmethod
    def output(x: State, u: Input, p: DqMotorParameters) -> DqMotor.Output:
        """The currents."""
        return DqMotor.Output(x.current_d, x.current_q)


def _rates(x: Any, u: Any, load_torque: Any, p: DqMotorParameters) -> tuple[Any, Any, Any]:
    """Rates of both currents and of the speed."""
    current = RotorVector(x.current_d, x.current_q)
    along, across = p.motor_inductance, p.motor_saliency * p.motor_inductance
    currents = current_rate(
        current,
        RotorVector(u.voltage_d, u.voltage_q),
        x.speed,
        resistance=p.motor_resistance,
        inductance_d=along,
        inductance_q=across,
        flux=p.motor_flux,
        pole_pairs=p.motor_pole_pairs,
    )
    torque = electromagnetic_torque(current, p.motor_pole_pairs, p.motor_flux, along, across)
    return (*currents, rotor_acceleration(torque, load_torque, x.speed, p.motor_inertia, p.motor_damping))
