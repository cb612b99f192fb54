"""All residuals of sensors and actuators, from the readings without reconfiguration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import named_tuple
from tierod.monitors.condition.signals import ConditionSample
from tierod_lab.papers.condition.rules.actuator_set import ActuatorSet, Repaired, Targets
from tierod_lab.papers.condition.rules.parameters import RESIDUALS
from tierod_lab.papers.condition.rules.readings import Excitation, Motion
from tierod_lab.papers.condition.rules.residual_set import ResidualSet

Residuals: Any = named_tuple("Residuals", [(each.name, Annotated[float, each.unit]) for each in RESIDUALS.values()])
"""Every residual in its unit."""

Flags: Any = named_tuple("Flags", [(name, Annotated[float, ""]) for name in RESIDUALS])
"""Presence of each residual as a flag, 1.0 or 0.0."""


@dataclass(frozen=True)
class AllResiduals:
    """Residuals of sensors and actuators, for calibration and figures."""

    sensors: ResidualSet  # residuals r1 to r19
    actuators: ActuatorSet  # residuals r1a and following

    Sample = ConditionSample

    class State(NamedTuple):
        sensors: ResidualSet.State
        actuators: ActuatorSet.State

    class Output(NamedTuple):
        residuals: Residuals
        there: Flags
        excitation: Excitation
        motion: Motion

    def init(self) -> State:
        return self.State(self.sensors.init(), self.actuators.init())

    def step(self, state: State, sample: ConditionSample) -> tuple[State, Output]:
        sensors, seen = self.sensors.step(state.sensors, sample)
        targets = Targets(*(getattr(sample, name) for name in Targets._fields))
        repaired = Repaired(seen.held, seen.motion, seen.held.steering_shaft_torque, seen.residuals.r19)
        actuators, driven = self.actuators.step(state.actuators, ActuatorSet.Sample(targets, repaired))
        output = self.Output(
            Residuals(*seen.residuals, *driven.residuals),
            Flags(*seen.there, *driven.there),
            seen.excitation,
            seen.motion,
        )
        return self.State(sensors, actuators), output
