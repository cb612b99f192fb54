"""Virtual cars whose friction follows a law that no estimator of tierod assumes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from tierod.graph.maths import absolute
from tierod.physics.friction import stribeck_level
from tierod.physics.steering_ratio import torque_at_steering_wheel
from tierod.proving_ground import EpsCar

STRIBECK_EXCESS = 0.2
"""Friction at standstill above that of sliding [-]; assumed."""

STRIBECK_RATE = 0.1
"""Rate at which the excess has fallen to 1/e [rad/s]: within the rates of usual driving, so that it matters."""

LOAD_SHARE = 0.4
"""Share of friction that is proportional to load [-]; assumed."""

REFERENCE_LOAD = 4.0
"""Self-aligning torque at the steering wheel at which load-dependent friction has its stated level [N*m]."""


@dataclass(frozen=True)
class StribeckCar(EpsCar):
    """Friction that falls as the steering wheel turns faster; its stated level is that of sliding."""

    excess: Annotated[float, ""] = STRIBECK_EXCESS
    stribeck_rate: Annotated[float, "rad/s"] = STRIBECK_RATE

    def _forces(self, motion: Any, state: Any, sample: Any, turned: Any) -> Any:
        level = stribeck_level(motion.column_rate, 1.0 + self.excess, 1.0, self.stribeck_rate, 2.0)
        loaded = sample._replace(friction_torque=sample.friction_torque * level)
        return super()._forces(motion, state, loaded, turned)


@dataclass(frozen=True)
class LoadedCar(EpsCar):
    """Friction that grows with the load of the steering gear; its stated level is that at the reference load."""

    load_share: Annotated[float, ""] = LOAD_SHARE
    reference_load: Annotated[float, "N*m"] = REFERENCE_LOAD

    def _forces(self, motion: Any, state: Any, sample: Any, turned: Any) -> Any:
        forces = super()._forces(motion, state, sample, turned)
        load = absolute(torque_at_steering_wheel(forces.self_aligning_torque, self.steering.ratio))
        level = 1.0 + self.load_share * (load / self.reference_load - 1.0)
        loaded = sample._replace(friction_torque=sample.friction_torque * level)
        return super()._forces(motion, state, loaded, turned)
