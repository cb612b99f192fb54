"""Signs of a column's sensors, tested on the data: angles, torque of the bar, torque of the motor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Block, Scalar, Tree
from tierod.core.findings import Status
from tierod.core.graph.maths import absolute, all_of, both, maximum, present, where
from tierod.core.statuses import Statement, code_of
from tierod.methods.relations import WRONG_SIGN_SHARE
from tierod.monitors.driver_torque.hands import HandsMonitor, HandsSample
from tierod.monitors.driver_torque.observer import ColumnSample

# Torque of the bar from which the motor assists; equal to that of the friction monitors' gate.
WORKED: Annotated[float, "N*m"] = 0.5
# Least time with such torques for a test. In fault-free drives the torques oppose each other for 3 % of it at most.
LEAST_WORKED: Annotated[float, "s"] = 5.0
# Work drawn from the steering from which a sign is wrong: a steering only takes work in the long run. An offset does
# work only between the first and the last angle: 0.8 N·m over two turns. Fault-free drives take 50 J a minute.
LEAST_WORK: Annotated[float, "J"] = 10.0

CORRECT = "correct it in the channel map (factor -1)"


class WorkOverDrive:
    """Work of motor and bar, and time with opposed hands and motor, over the pieces of a recording."""

    def __init__(self, rate: float) -> None:
        self._rate, self._angle = rate, np.nan
        self._worked = self._opposed = 0
        self._motor = self._bar = self._alone = 0.0

    def add(self, angle: np.ndarray, bar: np.ndarray, motor: np.ndarray) -> None:
        worked = (np.abs(bar) > WORKED) & np.isfinite(motor) & (motor != 0.0)
        self._worked += int(np.count_nonzero(worked))
        self._opposed += int(np.count_nonzero(worked & (bar * motor < 0.0)))
        travel = np.diff(angle, prepend=self._angle)
        by_motor, by_bar = motor * travel, bar * travel
        together = np.isfinite(by_motor) & np.isfinite(by_bar)
        self._motor += float(by_motor[together].sum())
        self._bar += float(by_bar[together].sum())
        self._alone += float(by_bar[np.isfinite(by_bar)].sum())
        self._angle = float(angle[-1]) if len(angle) else self._angle

    def wrong_signs(self, motor: str, ratio: float) -> tuple[str, ...]:
        """A sentence for the signal with the wrong sign by the motor's ratio; none where all signs may be right."""
        by_motor = ratio * self._motor
        share = self._opposed / max(self._worked, 1)
        if self._worked >= LEAST_WORKED * self._rate and share > WRONG_SIGN_SHARE:
            # Hands may pull against a motor that turns the wheel; a motor that only brakes is not an assist.
            name, work = ("driver_torque", self._bar) if self._bar < by_motor else (motor, by_motor)
            drawn = f", and it takes {-work:.0f} J out of the steering" if work < 0.0 else ""
            opposed = f"driver and motor torque oppose each other for {share:.0%} of the time"
            return (f"{name} has the wrong sign: {opposed}{drawn}; {CORRECT}",)
        if by_motor + self._bar < -LEAST_WORK:
            return (
                f"steering_wheel_angle has the wrong sign, or both driver_torque and {motor}: the torques take "
                f"{-by_motor - self._bar:.0f} J out of the steering, which cannot supply energy; {CORRECT}",
            )
        return ()

    def doubts(self) -> tuple[str, ...]:
        """A remark where the bar draws work from the steering; without motor torque no more can be concluded."""
        if self._alone >= -LEAST_WORK:
            return ()
        return (
            f"the hands take {-self._alone:.0f} J out of the steering, as under lane keeping, or with a wrong sign of "
            "driver_torque or steering_wheel_angle",
        )


class SignVerdict(NamedTuple):
    """1 for a signal with a wrong sign, 0 for a right one or one not tested yet; then which could be tested."""

    # steering_wheel_angle, motor_angle_mechanical, driver_torque, motor_torque: 1 where the sign is wrong
    steering_wheel_angle: Annotated[Scalar, ""]
    motor_angle_mechanical: Annotated[Scalar, ""]
    driver_torque: Annotated[Scalar, ""]
    motor_torque: Annotated[Scalar, ""]
    angles_judged: Annotated[Scalar, ""]  # 1 once both angles have moved together
    torque_judged: Annotated[Scalar, ""]  # 1 once the bar has been twisted enough
    motor_judged: Annotated[Scalar, ""]  # 1 once the motor has done enough work


class SignState(NamedTuple):
    """Exponentially weighted means and products."""

    weight: Annotated[Scalar, ""]  # weight of all samples so far, up to 1
    means: tuple[Scalar, ...]  # of wheel angle, gear angle, bar torque
    # of (wheel, wheel), (gear, gear), (wheel, gear), (bar, bar), (bar, wheel), (bar, gear), about the means
    products: tuple[Scalar, ...]
    work: tuple[Scalar, Scalar]  # exponentially weighted work of the motor, and of the bar on the motor [J]
    angle: Annotated[Scalar, "rad"]  # motor angle of the previous sample
    begun: Annotated[Scalar, ""]  # 1 after the first complete sample


_PAIRS = ((0, 0), (1, 1), (0, 1), (2, 2), (2, 0), (2, 1))


@dataclass(frozen=True)
class ColumnSigns:
    """Sign test that finds the one of four column signals with a wrong sign.

    Both angles move together. The bar's torque grows with its twist, the wheel angle less the gear angle; where the
    angles disagree, the sign of the torque shows which of them is wrong. The part below the bar only dissipates energy
    in the long run, so a motor that seems to draw more work from it than the bar gives or takes has its torque
    reversed. With two wrong signs the verdict may name another signal; all of them reversed together are not
    detectable.

    A late angle or a wrong ratio also gives a twist against the torque, but one that correlates weakly with the torque
    or is of another size than the stiffness allows; then the sign of the torque is not reported.
    """

    motor_ratio: Annotated[float, ""]  # turns of the motor per turn of the shaft [-]
    sample_time: Annotated[float, "s"] = 1e-3  # sampling interval [s]
    memory: Annotated[float, "s"] = 20.0  # time constant of the weighting, a few turns of the wheel [s]
    # least standard deviation of the wheel's angle, fifty times the noise of the sensor [rad]
    least_angle: Annotated[float, "rad"] = 0.04
    # least standard deviation of the bar's torque, twice the noise of the twist from the angles [N m]
    least_torque: Annotated[float, "N*m"] = 0.3
    least_work: Annotated[float, "J"] = 2.0  # least work of the motor, five times what the noise of its angle makes [J]
    least_correlation: Annotated[float, ""] = 0.3  # least correlation for a test of a sign; chance stays below 0.1
    torsion_bar_stiffness: Annotated[float, "N*m/rad"] = 140.0  # stiffness from the vehicle file [N m/rad]
    # least correlation of twist and torque for a reversed torque: a reversed one has 0.9 to 1, with a motor angle that
    # is 3 to 5 ms late mostly below 0.75
    least_blame: Annotated[float, ""] = 0.8
    # largest twist over that from the torque; a motor angle that is 7 ms late or more makes more [-]
    greatest_twist: Annotated[float, ""] = 2.0

    Sample = ColumnSample

    def init(self) -> SignState:
        return SignState(0.0, (0.0,) * 3, (0.0,) * len(_PAIRS), (0.0, 0.0), 0.0, 0.0)

    def step(self, state: SignState, sample: ColumnSample) -> tuple[SignState, SignVerdict]:
        whole = all_of(*(present(value) for value in sample))
        values = [sample.steering_wheel_angle, sample.motor_angle_mechanical / self.motor_ratio, sample.driver_torque]
        values = [where(whole, value, mean) for value, mean in zip(values, state.means, strict=True)]
        forgetting = self.sample_time / self.memory
        share = where(whole, forgetting, 0.0)
        weight = state.weight + share * (1.0 - state.weight)
        gain = where(whole, forgetting / maximum(weight, forgetting), 0.0)
        away = [value - mean for value, mean in zip(values, state.means, strict=True)]
        means = tuple(mean + gain * each for mean, each in zip(state.means, away, strict=True))
        after = [value - mean for value, mean in zip(values, means, strict=True)]
        # Deviations before and after the update of the mean (Welford): a large mean causes no cancellation.
        products = tuple(
            old + gain * (away[i] * after[j] - old) for old, (i, j) in zip(state.products, _PAIRS, strict=True)
        )
        work = self._work(state, sample, both(whole, state.begun), 1.0 - share)
        begun = where(whole, 1.0, state.begun)
        angle = where(whole, sample.motor_angle_mechanical, state.angle)
        following = SignState(weight, means, products, work, angle, begun)
        return following, self._verdict(following)

    def _work(self, state: SignState, sample: ColumnSample, counts: Scalar, kept: Scalar) -> tuple[Scalar, Scalar]:
        travel = where(counts, sample.motor_angle_mechanical - state.angle, 0.0)
        motor = where(counts, sample.motor_torque, 0.0)
        bar = where(counts, sample.driver_torque, 0.0) / self.motor_ratio
        return kept * state.work[0] + motor * travel, kept * state.work[1] + bar * travel

    def _verdict(self, state: SignState) -> SignVerdict:
        wheel, gear, together, bar, bar_wheel, bar_gear = state.products
        moved = both(wheel > self.least_angle**2, gear > self.least_angle**2)
        angles = both(moved, together**2 > self.least_correlation**2 * wheel * gear)
        opposite = both(angles, together < 0.0)
        same = both(angles, together > 0.0)
        # The twist, with the sign of the gear angle reversed where the angles disagree.
        with_bar = where(opposite, bar_wheel + bar_gear, bar_wheel - bar_gear)
        twist = where(opposite, wheel + gear + 2.0 * together, wheel + gear - 2.0 * together)
        enough = self.least_correlation**2 * bar * maximum(twist, 0.0)
        torque = all_of(angles, bar > self.least_torque**2, with_bar**2 > enough)
        follows = with_bar**2 > self.least_blame**2 * bar * maximum(twist, 0.0)
        sized = twist * self.torsion_bar_stiffness**2 < self.greatest_twist**2 * bar
        motor, by_bar = state.work
        judged = all_of(same, torque, absolute(motor) > maximum(absolute(by_bar), self.least_work))
        return SignVerdict(
            *(
                where(flag, 1.0, 0.0)
                for flag in (
                    all_of(opposite, torque, with_bar < 0.0),
                    all_of(opposite, torque, with_bar > 0.0),
                    all_of(same, torque, follows, sized, with_bar < 0.0),
                    both(judged, motor < 0.0),
                    angles,
                    torque,
                    judged,
                )
            )
        )


_REASONS = {
    "steering_wheel_angle": "it turns against the motor's angle, and the bar's torque agrees with the motor's",
    "motor_angle_mechanical": "it turns against the wheel's angle, and the bar's torque agrees with the wheel's",
    "driver_torque": "it is positive where both angles show the bar twisted to the right",
    "motor_torque": "the motor would take energy out of the column, which cannot supply any",
}


def wrong_signs(verdict: SignVerdict, motor: str = "motor_torque") -> tuple[str, ...]:
    """A sentence for every signal with a wrong sign."""
    named = {"motor_torque": motor}
    return tuple(
        f"{named.get(name, name)} has the wrong sign: {reason}; correct it in the channel map (factor -1)"
        for name, reason in _REASONS.items()
        if getattr(verdict, name) > 0.5
    )


@dataclass(frozen=True)
class DriverTorqueMonitor:
    """An observer of the column with the hands monitor, whose learnt offset corrects the torque of the torsion bar."""

    # a block with input `ColumnSample` and output `hand_torque`; optional outputs are its deviation, the disturbance
    # torque, `nis`, `present` and `ready`
    observer: Block
    hands: HandsMonitor  # detection of hands on the wheel
    signs: ColumnSigns  # test of the signals' signs

    class Sample(NamedTuple):
        steering_wheel_angle: Annotated[Scalar, "rad"]
        driver_torque: Annotated[Scalar, "N*m"]
        motor_torque: Annotated[Scalar, "N*m"]
        motor_target_torque: Annotated[Scalar, "N*m"]
        motor_angle_mechanical: Annotated[Scalar, "rad"]

    class State(NamedTuple):
        observer: Tree
        hands: HandsMonitor.State
        signs: SignState
        motor_torque: Annotated[Scalar, "N*m"]

    class Output(NamedTuple):
        # torque of the hands [N*m] with its deviation, healthy while it is known; the evidence is the CUSUM for hands
        # on (positive) or off (negative), over the threshold
        statement: Statement
        # disturbance_torque, disturbance_torque_deviation: torque that the motor overcomes at its shaft besides the
        # column
        disturbance_torque: Annotated[Scalar, "N*m"]
        disturbance_torque_deviation: Annotated[Scalar, "N*m"]
        hands: Annotated[Scalar, ""]  # 1 on, 0 off, 0.5 uncertain
        # inertia_error, torque_offset: errors of wheel and torsion bar, learnt without hands
        inertia_error: Annotated[Scalar, "kg*m**2"]
        torque_offset: Annotated[Scalar, "N*m"]
        nis: Annotated[Scalar, ""]  # nis, present: NIS of the observer, and its number of outputs
        present: Annotated[Scalar, ""]
        turned: SignVerdict  # 1 for every signal with a wrong sign

    def init(self) -> State:
        return self.State(self.observer.init(), self.hands.init(), self.signs.init(), 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        # The hands monitor runs first: its learnt offset corrects the torque that the observer gets.
        hands, found = self.hands.step(state.hands, HandsSample(sample.steering_wheel_angle, sample.driver_torque))
        wanted = where(present(sample.motor_target_torque), sample.motor_target_torque, state.motor_torque)
        motor = where(present(sample.motor_torque), sample.motor_torque, wanted)
        corrected = sample.driver_torque - found.torque_offset
        column = ColumnSample(motor, sample.steering_wheel_angle, sample.motor_angle_mechanical, corrected)
        observer, estimate = self.observer.step(state.observer, column)
        signs, turned = self.signs.step(state.signs, column)
        there = both(present(sample.steering_wheel_angle), present(sample.driver_torque))

        def of_observer(name: str, otherwise: Scalar = 0.0) -> Scalar:
            value: Scalar = getattr(estimate, name, otherwise)
            return value

        ready = where(there, of_observer("ready", 1.0), 0.0)
        statement = Statement(
            status=where(ready > 0.5, code_of(Status.ESTIMATED), code_of(Status.NOT_READY)),
            since=-1.0,
            kind=0.0,
            magnitude=of_observer("hand_torque"),
            deviation=of_observer("hand_torque_deviation"),
            evidence=found.evidence_on - found.evidence_off,
        )
        return self.State(observer, hands, signs, motor), self.Output(
            statement=statement,
            disturbance_torque=of_observer("disturbance_torque"),
            disturbance_torque_deviation=of_observer("disturbance_torque_deviation"),
            hands=found.hands,
            inertia_error=found.inertia_error,
            torque_offset=found.torque_offset,
            nis=of_observer("nis"),
            present=of_observer("present"),
            turned=turned,
        )
