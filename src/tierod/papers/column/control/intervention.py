"""Detection of a driver who takes the wheel under position control: end of control, and condition of its return."""

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
    """Autocorrelated noise of an estimate.

    Args:
        deviation: standard deviation, in the unit of the estimate
        correlated: correlation length in samples: 1 + 2 (sum of its autocorrelation)
    """

    deviation: float
    correlated: float


def noise_of(values: np.ndarray) -> Noise:
    """Noise of an estimate from its values while the true value is zero.

    Args:
        values: the estimates, thousands of correlation lengths long, (n,)

    The sum of the autocorrelation is truncated at its first fall below 0.05, since beyond it consists of noise.

    Raises:
        ParameterError: fewer than 1000 values, or constant values
    """
    values = np.asarray(values, float)
    if len(values) < 1000 or not values.std() > 0.0:
        raise ParameterError(f"{len(values)} values, deviation {values.std()}; expected 1000 or more that vary")
    # Zero padding to twice the length makes the autocorrelation linear instead of circular.
    centred = values - values.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * len(centred))) ** 2
    correlation = np.fft.irfft(spectrum)[: len(centred)]
    correlation /= correlation[0]
    low = np.nonzero(correlation < 0.05)[0]
    last = int(low[0]) if len(low) else len(correlation)
    return Noise(float(values.std()), float(1.0 + 2.0 * correlation[1:last].sum()))


@dataclass(frozen=True)
class Takeover:
    """Specification of the detection of a takeover by the driver.

    Args:
        torque: hand torque that must end control: a firm hand, half of the torque that holds a wheel against a push
        forgiven: hand torque that wrong parameters may feign for any time without ending control
        delay: largest detection delay of a step to exactly `torque`: half of the 60 ms allowed in all, the other half
            is for the lag of the observer and for a torque that changes its sign meanwhile
        hours: least mean time between false ends of control while `forgiven` is estimated all the time: once in the
            life of a car
        quiet_torque: largest torque of hands that have let go; half of `torque`, a hysteresis against alternation
        quiet_time: time for which the hands must be quiet before control may return; longer than a turn of a slalom
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
    """End control when the driver takes the wheel, and permit it again only on a new request.

    The rule is a CUSUM of the absolute hand torque above the forgiven torque. The torque that a wrong inertia of the
    wheel would feign at the planned acceleration is subtracted first. Control ends at the alarm. It returns at the next
    new request (off, then on) after the hands have been quiet for a while. A missing hand torque (NaN) counts as a
    takeover: without estimates for longer than the delay there is no control.

    Args:
        cusum: CUSUM of the absolute hand torque, from `design`
        restless: CUSUM above the quiet torque; its alarm, which noise alone never causes, means that hands move
        quiet: debouncing of quiet hands
        inertia_uncertainty: uncertainty of the inertia of the steering wheel, whose torque is forgiven as well
        unseen_torque: torque that replaces a missing one: the torque that must be detected
    """

    cusum: Cusum
    restless: Cusum
    quiet: Debounce
    inertia_uncertainty: Annotated[float, "kg*m**2", NOT_NEGATIVE] = 0.0
    unseen_torque: Annotated[float, "N*m"] = Takeover.torque

    class Sample(NamedTuple):
        """Observed torque of the hands, planned acceleration of the wheel, and request for control (1.0 or 0.0)."""

        hand_torque: Annotated[float, "N*m"]
        steering_wheel_acceleration: Annotated[float, "rad/s**2"]
        request: Annotated[float, ""]

    class State(NamedTuple):
        """States of both CUSUMs and the debouncing, whether control is allowed, and the request of the last sample."""

        cusum: Cusum.State
        restless: Cusum.State
        quiet: Debounce.State
        allowed: float
        request: float

    class Output(NamedTuple):
        """Whether control may act, whether a driver was detected in this sample (1.0 or 0.0), and the CUSUM."""

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
        """Design the rule for the noise of an observer.

        Args:
            noise: noise of its hand torque, from `noise_of`
            sample_time: sampling interval [s]
            takeover: specification; the default where None
            inertia_uncertainty: uncertainty of the inertia of the steering wheel [kg m^2]

        The drift is the mean of the forgiven torque and the torque that must be detected. The threshold is the largest
        that keeps the detection delay; its reserve against noise covers transients of the estimate, such as at
        reversals of friction. Siegmund's run length checks that noise alone leaves the required mean time between false
        ends; there the noise counts as white, with its correlation length in the standard deviation.

        Raises:
            ParameterError: a deviation that is not above zero, or too much noise for the detection delay
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
        """State with no driver detected, no request, and hands not yet known to be quiet."""
        return self.State(self.cusum.init(), self.restless.init(), self.quiet.init(), 0.0, 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        """Advance by one sample."""
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
    """Position control that releases when a driver takes the wheel.

    Args:
        position: the position control
        intervention: driver detection, which ends control and permits its return
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
        """States of position control and driver detection."""

        position: PositionControl.State
        intervention: DriverIntervention.State

    class Output(NamedTuple):
        """Outputs of both parts; `control.motor_torque` is the command to the motor."""

        control: PositionControl.Output
        driver: DriverIntervention.Output

    def init(self) -> State:
        """State with control released."""
        return self.State(self.position.init(), self.intervention.init())

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        """Advance by one sample."""
        position = self.position
        planned = motion_for(sample.reference, position.column, position.output_stiffness)
        judged = self.intervention.Sample(sample.hand_torque, planned.steering_wheel_acceleration, sample.request)
        intervention, driver = self.intervention.step(state.intervention, judged)
        asked = position.Sample(sample.observed, sample.reference, driver.allowed)
        after, control = position.step(state.position, asked)
        return self.State(after, intervention), self.Output(control, driver)
