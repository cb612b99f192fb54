"""The angle of the back-EMF, followed by a model of the rotor with a load: an angle that does not jump."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.graph.maths import both, present, where
from tierod.methods.estimators.linear_algebra import add
from tierod.methods.estimators.pole_placement import discrete_poles, observer_gain
from tierod.models.linear import LinearSystem, sampled
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.papers.motor_angle.feedforward import FeedforwardAngle, FeedforwardState
from tierod.papers.motor_angle.printed_signals import Sample, fresh, output_class, residual
from tierod.physics.clarke_park import StatorVector, direction, electrical_angle, park
from tierod.physics.pm_motor import rotor_acceleration, torque_constant

FOLLOWING_POLES = (-250.0, -251.0, -252.0)
"""Of the error of angle, speed and load [1/s]: above a reversing load, well below the filter of the derivative."""


class RotorState(NamedTuple):
    """Angle, speed and load."""

    angle: Annotated[float, "rad"]
    speed: Annotated[float, "rad/s"]
    load_torque: Annotated[float, "N*m"]


class FollowedState(NamedTuple):
    """Memory of the feedforward and of the rotor, and whether the sensor has told the beginning."""

    feedforward: FeedforwardState
    rotor: RotorState
    begun: Any


@dataclass(frozen=True)
class FeedforwardWithLoad:
    """Luenberger observer of angle, speed and load, fed by the torque of the current and by the angle of (46).

    Args:
        feedforward: gives the angle
        gain: of angle, speed and load per radian between that angle and the own one

    While the back-EMF tells nothing, the model is drawn to the angle that is held: a load that reverses at rest would
    carry it away otherwise.

    Source: Reinelt et al., eqs (16) and (46); the combination and the load are additions.
    """

    feedforward: FeedforwardAngle
    gain: tuple[float, float, float]

    Sample = Sample

    @classmethod
    def of(
        cls, parameters: SampledMotorParameters, poles: tuple[float, ...] = FOLLOWING_POLES, slow: str = "held"
    ) -> FeedforwardWithLoad:
        """The usual one of a motor.

        Args:
            parameters: of the motor
            poles: of the error of angle, speed and load [1/s]
            slow: what `FeedforwardAngle` does below its least speed

        Raises:
            ParameterError: the poles do not fit
        """
        p, A = parameters, np.zeros((3, 3))
        A[0, 1], A[1, 1], A[1, 2] = 1.0, -p.motor_damping / p.motor_inertia, -1.0 / p.motor_inertia
        system = sampled(LinearSystem.of(A, [[1.0, 0.0, 0.0]], states=RotorState._fields), p.sample_time)
        gain = observer_gain(system, discrete_poles(poles, p.sample_time))
        return cls(FeedforwardAngle(p, slow=slow), tuple(row[0] for row in gain))  # type: ignore[arg-type]

    def init(self) -> FollowedState:
        """Nothing seen."""
        return FollowedState(self.feedforward.init(), RotorState(0.0, 0.0, 0.0), 0.0)

    def step(self, state: FollowedState, sample: Any) -> tuple[FollowedState, Any]:
        """One sample on."""
        p = self.feedforward.parameters
        first = fresh(state.begun, sample)
        inner, turning = self.feedforward.turned(state.feedforward, sample)
        rotor = self._predicted(state.rotor, sample)
        away = turning.electrical_angle / p.motor_pole_pairs - rotor.angle
        usable = both(inner.begun, present(away))
        shift = where(usable, away, 0.0)
        rotor = RotorState(*add(rotor, tuple(gain * shift for gain in self.gain)))
        begun = inner.begun
        rotor = RotorState(*(where(begun, new, old) for new, old in zip(rotor, state.rotor, strict=True)))
        rotor = rotor._replace(angle=where(first, sample.motor_angle_mechanical, rotor.angle))
        told = residual(begun, sample, rotor.angle, p.motor_pole_pairs)
        output = output_class("motor_load_torque", "standing")(
            rotor.angle, rotor.speed, rotor.load_torque, turning.standing, told
        )
        return FollowedState(inner, rotor, begun), output

    def _predicted(self, rotor: RotorState, sample: Any) -> RotorState:
        """The rotor a sample on, by the current's torque; as it was where the current is missing."""
        p = self.feedforward.parameters
        own = direction(electrical_angle(rotor.angle, p.motor_pole_pairs))
        current = park(StatorVector(sample.motor_current_alpha, sample.motor_current_beta), own)
        torque = torque_constant(p.motor_pole_pairs, p.motor_flux) * current.q
        gained = p.sample_time * rotor_acceleration(
            torque, rotor.load_torque, rotor.speed, p.motor_inertia, p.motor_damping
        )
        gained = where(present(gained), gained, 0.0)
        angle = rotor.angle + p.sample_time * (rotor.speed + 0.5 * gained)
        return RotorState(angle, rotor.speed + gained, rotor.load_torque)
