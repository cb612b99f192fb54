"""When the difference between a motor's angle sensor and its observer counts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.fields import NOT_NEGATIVE, POSITIVE, check_ranges
from tierod.core.graph.maths import absolute, all_of, both, log, maximum, minimum, present, where
from tierod.methods.detectors.threshold import Debounce


class Observed(NamedTuple):
    """What the gate wants of the observer, and the sensor's reading.

    Args:
        angle_residual_electrical: sensor less observer
        motor_angle_mechanical: of the sensor; NaN where the sample brings none
        motor_speed, motor_angle_standard_deviation, motor_flux: of the observer
        standing: 1 while the currents tell no angle
    """

    angle_residual_electrical: Annotated[float, "rad"]
    motor_angle_mechanical: Annotated[float, "rad"]
    motor_speed: Annotated[float, "rad/s"]
    motor_angle_standard_deviation: Annotated[float, "rad"]
    motor_flux: Annotated[float, "V*s"]
    standing: Annotated[float, ""]


@dataclass(frozen=True)
class ResidualGate:
    """Lets the residual count where the currents tell the angle well, one value in a millisecond.

    Args:
        pole_pairs: of the motor []
        nominal_flux: of its magnets, from the vehicle file [V s]
        sample_time: [s]
        least_speed: electrical; slower, an uncertain resistance hides the back-EMF [rad/s]
        most_deviation: of the observer's angle, mechanical [rad]
        hold: for so long all conditions must hold [s]
        start: after so long the observer has learnt resistance and flux [s]
        widest_flux: magnets from -40 to 120 degrees stay within 10 % of their flux: a logarithm beyond this is an
            observer that has not settled, and magnets so weak are a fault of their own []
        spacing: of the values that count: residuals nearer to each other tell the same [s]
    """

    pole_pairs: Annotated[float, "", POSITIVE]
    nominal_flux: Annotated[float, "V*s", POSITIVE]
    sample_time: Annotated[float, "s", POSITIVE] = 1e-4
    least_speed: Annotated[float, "rad/s", POSITIVE] = 40.0
    most_deviation: Annotated[float, "rad", POSITIVE] = 0.03
    hold: Annotated[float, "s", NOT_NEGATIVE] = 0.02
    start: Annotated[float, "s", NOT_NEGATIVE] = 5.0
    widest_flux: Annotated[float, "", POSITIVE] = 0.2
    spacing: Annotated[float, "s", POSITIVE] = 1e-3
    holding: Debounce = field(init=False, repr=False)

    Sample = Observed

    class State(NamedTuple):
        """Time since the start and since a value counted, up to their limits, and the hold."""

        elapsed: Any
        since: Any
        held: Any

    class Output(NamedTuple):
        """Whether the motor turns so that its angle is known, and whether this very value counts (1.0, 0.0)."""

        known: Annotated[float, ""]
        counts: Annotated[float, ""]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, 0.0, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        """Nothing seen."""
        return self.State(0.0, self.spacing, self.holding.init())

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        """One sample on."""
        half = 0.5 * self.sample_time
        elapsed = minimum(state.elapsed + self.sample_time, self.start + self.sample_time)
        flux = log(maximum(sample.motor_flux / self.nominal_flux, 1e-6))
        good = all_of(
            elapsed + half > self.start,
            self.pole_pairs * absolute(sample.motor_speed) > self.least_speed,
            sample.standing < 0.5,
            sample.motor_angle_standard_deviation < self.most_deviation,
            absolute(flux) < self.widest_flux,
        )
        held, debounced = self.holding.step(state.held, where(good, 1.0, 0.0))
        known = both(debounced.active, good)
        since = minimum(state.since + self.sample_time, self.spacing)
        counts = all_of(known, present(sample.motor_angle_mechanical), since + half > self.spacing)
        after = self.State(elapsed, where(counts, 0.0, since), held)
        return after, self.Output(where(known, 1.0, 0.0), where(counts, 1.0, 0.0))
