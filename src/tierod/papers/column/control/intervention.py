"""A driver who takes the wheel while it is controlled: when the controller lets go, and when it may come back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE
from tierod.core.graph.maths import absolute, all_of, both, either, negated, present, where
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.design import threshold_for
from tierod.methods.detectors.threshold import Debounce
from tierod.papers.column.control.position_control import ObservedColumn, PositionControl
from tierod.papers.column.control.reference import Reference, motion_for


class Noise(NamedTuple):
    """Noise of an estimate.

    Args:
        deviation: standard deviation, in the unit of the estimate
        correlated: samples over which it hangs together: 1 + 2 (sum of its autocorrelation)
    """

    deviation: float
    correlated: float


def noise_of(values: np.ndarray) -> Noise:
    """Noise of an estimate from its values while the truth is zero.

    Args:
        values: thousands of times its correlation long, (n,)

    The sum of the autocorrelation ends at its first fall below 0.05, so that noise of the sum itself is left out.

    Raises:
        ParameterError: fewer than 1000 values, or values that do not change
    """
    values = np.asarray(values, float)
    if len(values) < 1000 or not values.std() > 0.0:
        raise ParameterError(f"{len(values)} values, deviation {values.std()}; expected 1000 or more that vary")
    centred = values - values.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * len(centred))) ** 2
    correlation = np.fft.irfft(spectrum)[: len(centred)]
    correlation /= correlation[0]
    low = np.nonzero(correlation < 0.05)[0]
    last = int(low[0]) if len(low) else len(correlation)
    return Noise(float(values.std()), float(1.0 + 2.0 * correlation[1:last].sum()))


@dataclass(frozen=True)
class Takeover:
    """Limits that define a takeover by the driver.

    Args:
        torque: of the hands that must end control: a firm hand, half of what holding a wheel against a push takes
        forgiven: torque that may be seen without hands, from wrong parameters, for any time
        delay: after which a torque that jumps to exactly `torque` must be found at the latest: half of the 60 ms that
            are allowed in all, the other half for the observer's lag and for a torque that turns round meanwhile
        hours: at least between false ends of control while `forgiven` is seen all the time, on average: once in the
            life of a car
        quiet_torque: at most so much are hands that have let go; half of `torque`, so that the two never alternate
        quiet_time: that they must be still before control may come back; longer than one turn of a slalom
    """

    torque: Annotated[float, "N*m"] = 1.0
    forgiven: Annotated[float, "N*m"] = 0.5
    delay: Annotated[float, "s"] = 0.03
    hours: Annotated[float, "h"] = 1.0e4
    quiet_torque: Annotated[float, "N*m"] = 0.5
    quiet_time: Annotated[float, "s"] = 1.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.forgiven < self.torque:
            raise ParameterError(
                f"forgiven is {self.forgiven} and torque {self.torque} N m; expected 0 <= forgiven < torque"
            )
        if not 0.0 < self.quiet_torque <= self.torque:
            raise ParameterError(
                f"quiet_torque is {self.quiet_torque} N m; expected a number above zero, at most torque, {self.torque}"
            )
        if not (self.hours > 0.0 and self.delay > 0.0 and self.quiet_time >= 0.0):
            raise ParameterError(
                f"hours is {self.hours}, delay {self.delay} s and quiet_time {self.quiet_time} s; "
                "expected the first two above zero and the last one not negative"
            )


@dataclass(frozen=True)
class DriverIntervention:
    """End control once the driver's hands are on the wheel against it; give it back only when asked anew.

    A cumulative sum of |hand torque| above what is forgiven, less what a wrong inertia of the wheel would feign at the
    planned acceleration. Control ends at its alarm. It comes back at the next new request (off, then on) that finds
    the hands still for a while. Hands that are not seen (NaN) count as hands that take over: blind for longer than the
    delay there is no control.

    Args:
        cusum: stopping rule on the size of the torque, `design`
        restless: the same above the quiet torque: at its alarm the hands are not still, which noise alone never causes
        quiet: how long the hands must be still
        inertia_uncertainty: of the steering wheel's inertia, whose torque is forgiven besides
        unseen_torque: that stands for a missing one; the torque that must be found
    """

    cusum: Cusum
    restless: Cusum
    quiet: Debounce
    inertia_uncertainty: Annotated[float, "kg*m**2", NOT_NEGATIVE] = 0.0
    unseen_torque: Annotated[float, "N*m"] = Takeover.torque

    class Sample(NamedTuple):
        """Observed torque of the hands, planned acceleration of the wheel, whether control is asked for (1.0, 0.0)."""

        hand_torque: Annotated[float, "N*m"]
        steering_wheel_acceleration: Annotated[float, "rad/s**2"]
        request: Annotated[float, ""]

    class State(NamedTuple):
        """State of both sums and the stillness, whether control is allowed, and the request of the sample before."""

        cusum: Cusum.State
        restless: Cusum.State
        quiet: Debounce.State
        allowed: float
        request: float

    class Output(NamedTuple):
        """Whether control may act, whether a driver has just been found (1.0 or 0.0), and the sum that decides it."""

        allowed: Annotated[float, ""]
        found: Annotated[float, ""]
        sum: Annotated[float, "N*m"]

    def __post_init__(self) -> None:
        for name in ("cusum", "restless"):
            if (sides := getattr(self, name).sides) != "upper":
                raise ParameterError(f"the sides of {name} are '{sides}'; expected 'upper'")
        if not 0.0 <= self.inertia_uncertainty < math.inf:
            raise ParameterError(
                f"inertia_uncertainty is {self.inertia_uncertainty} kg m^2; expected a number that is not negative"
            )

    @classmethod
    def design(
        cls, noise: Noise, sample_time: float, takeover: Takeover | None = None, inertia_uncertainty: float = 0.0
    ) -> DriverIntervention:
        """The rule for an observer's noise.

        Args:
            noise: of its hand torque, `noise_of`
            sample_time: [s]
            takeover: what counts as a driver
            inertia_uncertainty: of the steering wheel [kg m^2]

        The drift lies half way between what is forgiven and what must be found. The threshold is the largest that finds
        it within the delay: what is left over against noise is there for twitches of the estimate, such as where
        friction turns round. That noise alone leaves enough hours is checked by Siegmund's run length, the noise taken
        as white with its correlation in its deviation.

        Raises:
            ParameterError: a deviation that is not above zero, or so much noise that the delay cannot be kept
        """
        takeover = takeover or Takeover()
        spread = noise.deviation * math.sqrt(noise.correlated)
        if not 0.0 < spread < math.inf:
            raise ParameterError(f"the noise {noise} has no deviation above zero; measure it with `noise_of`")
        margin = 0.5 * (takeover.torque - takeover.forgiven)
        threshold = margin * takeover.delay / sample_time
        samples = takeover.hours * 3600.0 / sample_time
        needed = spread * threshold_for(margin / spread, samples, sides="upper")
        if needed > threshold:
            raise ParameterError(
                f"noise of {noise.deviation:.3g} N m over {noise.correlated:.3g} samples finds {takeover.torque} N m "
                f"only after {needed / margin * sample_time:.3g} s if false ends are to be {takeover.hours:g} h apart; "
                f"expected at most delay, {takeover.delay} s: allow more of it, or give an observer with less noise"
            )
        cusum = Cusum(takeover.forgiven + margin, threshold, 2.0 * threshold, "upper")
        restless = Cusum(takeover.quiet_torque, threshold, 2.0 * threshold, "upper")
        quiet = Debounce(takeover.quiet_time, 0.0, sample_time)
        return cls(cusum, restless, quiet, inertia_uncertainty, takeover.torque)

    def init(self) -> State:
        """No driver found, nothing asked for, hands not yet known to be still."""
        return self.State(self.cusum.init(), self.restless.init(), self.quiet.init(), 0.0, 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        """One sample on."""
        acceleration = absolute(sample.steering_wheel_acceleration)
        feigned = self.inertia_uncertainty * where(present(acceleration), acceleration, 0.0)
        seen = absolute(sample.hand_torque) - feigned
        torque = where(present(seen), seen, self.unseen_torque)
        cusum, sums = self.cusum.step(state.cusum, torque)
        restless, moving = self.restless.step(state.restless, torque)
        quiet, still = self.quiet.step(state.quiet, 1.0 - moving.alarm)
        asked = where(present(sample.request), sample.request, 0.0) > 0.5
        anew = all_of(asked, negated(state.request > 0.5), still.active > 0.5, negated(sums.alarm > 0.5))
        stays = all_of(asked, state.allowed > 0.5, negated(sums.alarm > 0.5))
        allowed = where(either(anew, stays), 1.0, 0.0)
        found = both(state.allowed > 0.5, sums.alarm > 0.5)
        after = self.State(cusum, restless, quiet, allowed, where(asked, 1.0, 0.0))
        return after, self.Output(allowed, where(found, 1.0, 0.0), sums.up)


@dataclass(frozen=True)
class SteeringController:
    """Follow a reference until hands are found on the wheel, then let go.

    Args:
        position: the control
        intervention: when it ends, and when it comes back
    """

    position: PositionControl
    intervention: DriverIntervention

    class Sample(NamedTuple):
        """Estimates of the column and the hands, the reference, and whether control is requested (1.0 or 0.0)."""

        observed: ObservedColumn
        hand_torque: Annotated[float, "N*m"]
        reference: Reference
        request: Annotated[float, ""]

    class State(NamedTuple):
        """State of both parts."""

        position: PositionControl.State
        intervention: DriverIntervention.State

    class Output(NamedTuple):
        """Outputs of both parts; `control.motor_torque` is to be asked of the motor."""

        control: PositionControl.Output
        driver: DriverIntervention.Output

    def init(self) -> State:
        """Let go."""
        return self.State(self.position.init(), self.intervention.init())

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        """One sample on."""
        position = self.position
        planned = motion_for(sample.reference, position.column, position.output_stiffness)
        judged = self.intervention.Sample(sample.hand_torque, planned.steering_wheel_acceleration, sample.request)
        intervention, driver = self.intervention.step(state.intervention, judged)
        asked = position.Sample(sample.observed, sample.reference, driver.allowed)
        after, control = position.step(state.position, asked)
        return self.State(after, intervention), self.Output(control, driver)
