"""The motor's angle sensor against the observer: differences, what both gain, and sums of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.graph.maths import maximum, where
from tierod.methods.detectors.control_charts import Cusum
from tierod.monitors.motor_angle.residual import Observed, ResidualGate
from tierod.monitors.motor_angle.second_tests import Backwards, Increments, Stuck, Turning

ANGLE_DRIFT, ANGLE_THRESHOLD = 0.044, 0.9
"""Of the electrical angle's sum, one value a millisecond [rad]: see docs/explanation/motor-angle.md, Monitoring."""

SPEED_DRIFT, SPEED_THRESHOLD = 0.5, 2.0
"""Of the speed's sum, one value in 10 ms [rad/s]: see docs/explanation/motor-angle.md, Monitoring."""


@dataclass(frozen=True)
class SensorComparison:
    """What the observer says of the angle that the sensor reads.

    Args:
        gate: when the difference counts
        increments: what both gain over a window
        stuck, backwards: tests of what they gain
        angle, speed: sums of the differences of angle and of speed
    """

    gate: ResidualGate
    increments: Increments
    stuck: Stuck = field(default_factory=Stuck)
    backwards: Backwards = field(default_factory=Backwards)
    angle: Cusum = field(default_factory=lambda: Cusum(ANGLE_DRIFT, ANGLE_THRESHOLD, 2.0 * ANGLE_THRESHOLD))
    speed: Cusum = field(default_factory=lambda: Cusum(SPEED_DRIFT, SPEED_THRESHOLD, 2.0 * SPEED_THRESHOLD))

    class Sample(NamedTuple):
        """What the observer tells, and the sensor's reading.

        Args:
            observed: by the gate
            motor_angle: of the observer
        """

        observed: Observed
        motor_angle: Annotated[float, "rad"]

    class State(NamedTuple):
        """Of the parts, in order."""

        gate: Any
        increments: Any
        stuck: Any
        backwards: Any
        angle: Any
        speed: Any

    class Output(NamedTuple):
        """Whether the difference counts, the sums, what both gain, 1 while a test alarms, and what two tests see."""

        known: Annotated[float, ""]
        counts: Annotated[float, ""]
        early: Annotated[float, ""]
        angle_sum: Annotated[float, "rad"]
        speed_residual: Annotated[float, "rad/s"]
        speed_sum: Annotated[float, "rad/s"]
        sensor_gain: Annotated[float, "rad"]
        observer_gain: Annotated[float, "rad"]
        tells: Annotated[float, ""]
        angle_alarm: Annotated[float, ""]
        speed_alarm: Annotated[float, ""]
        backwards_alarm: Annotated[float, ""]
        stuck_alarm: Annotated[float, ""]
        backwards_sum: Annotated[float, ""]
        turned_meanwhile: Annotated[float, "rad"]

    def init(self) -> State:
        """Nothing seen."""
        parts = (self.gate, self.increments, self.stuck, self.backwards, self.angle, self.speed)
        return self.State(*(part.init() for part in parts))

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        """One sample on."""
        seen = sample.observed
        gate, gated = self.gate.step(state.gate, seen)
        angle, summed = self.angle.step(state.angle, seen.angle_residual_electrical, enabled=gated.counts)
        turning = Turning(seen.motor_angle_mechanical, sample.motor_angle, seen.motor_speed, seen.standing)
        increments, gained = self.increments.step(state.increments, turning)
        gained = gained._replace(tells=where(gated.known, gained.tells, 0.0))
        faster = (gained.sensor - gained.observer) / self.increments.window
        speed, speeds = self.speed.step(state.speed, faster, enabled=gained.tells)
        backwards, against = self.backwards.step(state.backwards, gained)
        stuck, still = self.stuck.step(state.stuck, turning._replace(standing=where(gated.known, 0.0, 1.0)))
        return self.State(gate, increments, stuck, backwards, angle, speed), self.Output(
            gated.known,
            gated.counts,
            where(gate.elapsed < self.gate.start, 1.0, 0.0),
            maximum(summed.up, summed.down),
            where(gained.tells, faster, 0.0),
            maximum(speeds.up, speeds.down),
            gained.sensor,
            gained.observer,
            gained.tells,
            summed.alarm,
            speeds.alarm,
            against.alarm,
            still.alarm,
            against.up,
            still.turned,
        )
