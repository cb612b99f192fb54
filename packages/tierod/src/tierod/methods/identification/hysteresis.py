"""Friction of a steering system from the hysteresis loop of a lock-to-lock test (Mohtat et al., appendix A)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.core.findings import Estimate
from tierod.core.recording import Recording
from tierod.methods.identification import lock_to_lock
from tierod.models.steering_column import BelowBarParameters
from tierod.physics.steering import torsion_bar_twist
from tierod.vehicles import Vehicle
from tierod.vehicles.classes import held_deviation

Support = Literal["hoist", "ground"]
PLACE = "friction torque at the steering wheel axis"
_SIGNALS = ("steering_wheel_angle", "steering_wheel_rate", "driver_torque", "motor_torque")


class NoisySignal(NamedTuple):
    name: str
    noise: lock_to_lock.Noise
    friction_deviation: float  # standard deviation of the friction that the noise causes [N m]


@dataclass(frozen=True)
class HysteresisFriction:
    """Friction of the steering system over all closed loops of one recording."""

    support: Support  # "hoist" (internal friction only) or "ground" (with tyre scrub)
    friction_torque: float  # mean over the loops [N m]
    # of the mean, by damping, closing gap, scatter of the loops, work lost in reversals, and noise of the signals [N m]
    standard_deviation: float
    independent_deviation: float  # part without the damping, which is common to recordings of one vehicle [N m]
    noises: tuple[NoisySignal, ...]  # noise of the angle and of both torques, with its part in the deviation
    damping_deviation: float  # standard deviation of the damping [N m s/rad]
    mean_rate: float  # mean rate, at which the damping acted [rad/s]
    loops: tuple[lock_to_lock.WorkBalance, ...]
    # angle over which friction builds up after a reversal, None where it is not observable
    pre_sliding: lock_to_lock.PreSliding | None
    # angle, torque: the loops for plotting, of the column below the torsion bar [rad], [N m]; without inertial and
    # viscous torque
    angle: np.ndarray
    torque: np.ndarray

    @property
    def estimate(self) -> Estimate:
        return Estimate(f"{PLACE}, on {self.support}", self.friction_torque, self.standard_deviation, "N*m")


@dataclass(frozen=True)
class HysteresisIdentification:
    """Work balance over lock-to-lock loops, eqs (15) to (17).

    Over a closed loop the work of inertia and of every spring (tyre, self-alignment) vanishes; friction and damping
    remain. The scrub of the tyres on the ground is friction too: only the difference to a loop of the fault-free car on
    the same ground is the additional friction (`friction_increase`).

    The driver's torque is that in the torsion bar. It acts on the parts below the bar: on the angle of the steering
    wheel less the twist of the bar, against inertia and damping below. The twist hardly changes the work over a closed
    loop, but would appear as pre-sliding at the reversals.

    Source: Mohtat et al., appendix A, eqs (15) to (17); read as J/2 * (rate_2^2 - rate_1^2) in (16).
    """

    motor_gear_ratio: float  # motor angle per steering wheel angle, n [-]
    inertia: float  # J_eq below the torsion bar at the steering wheel axis [kg m^2]
    damping: float  # B_eq below the torsion bar at the steering wheel axis [N m s/rad]
    damping_deviation: float  # its standard deviation [N m s/rad], for the uncertainty at the mean rate
    # smallest angle from lock to lock [rad]; road cars have 2 to 3.5 turns, less a margin of half a turn
    minimum_stroke: float = math.radians(540.0)
    # largest gap between both ends of a loop [rad]; it gives an error of 2 mN m for 1 N m/rad
    closing_tolerance: float = math.radians(5.0)
    maximum_rate: float = 6.0  # fastest turn [rad/s]; above it the viscous torque is no longer small against friction
    maximum_speed: float = 0.3  # of the vehicle [m/s]; above it the wheels roll and the test is invalid
    sampling_rate: float = 100.0  # of the resampled signals [Hz]
    maximum_age: float = 0.1  # longest gap in a channel [s]
    noise_angle: float = math.radians(3.0)  # smallest motion that counts as a reversal [rad]
    # the same over the noise of the smoothed angle [-]; the range of some thousand readings
    noise_reversals: float = 8.0
    # motion that certainly is a reversal [rad]; smaller ones are part of the deviation, since slow noise may be
    # their cause
    sure_reversal: float = math.radians(30.0)
    largest_angle_noise: float = 0.1  # noise of the angle above which reversals are not found reliably [rad]
    # pre-sliding angle for the uncertainty where the reversals show none [rad]; each reversal loses the work of
    # twice this angle
    unseen_build_up: float = math.radians(1.0)
    torsion_bar_stiffness: float = math.inf  # [N m/rad]; infinite for a rigid bar

    @classmethod
    def of_vehicle(cls, vehicle: Vehicle, sampling_rate: float = 100.0) -> HysteresisIdentification:
        """The identification with the parameters of a vehicle. Args: sampling_rate: of the resampled signals [Hz]."""
        below = vehicle.parameters_for(BelowBarParameters)
        # Torques of an uncalibrated vehicle are in counts, to which a stiffness in N*m/rad does not apply.
        stiffness = below.torsion_bar_stiffness if vehicle.calibrated else math.inf
        return cls(
            vehicle["motor_ratio"],
            below.inertia,
            below.damping,
            held_deviation(vehicle, "column_damping"),
            sampling_rate=sampling_rate,
            torsion_bar_stiffness=stiffness,
        )

    def identify(self, recording: Recording, support: Support) -> HysteresisFriction:
        """Friction over the closed loops of a recording.

        Args: recording: with steering_wheel_angle, driver_torque and motor_torque; steering_wheel_rate and
        vehicle_speed if available (without the rate the angle is differentiated).
        """
        if support not in ("hoist", "ground"):
            raise ParameterError(f"support is '{support}', but a lock-to-lock test stands on 'hoist' or 'ground'")
        time, angle, rate, driver, motor = self._signals(recording)
        noise, course = lock_to_lock.noise_of(angle, time), lock_to_lock.smoothed(angle, time)
        left = lock_to_lock.noise_left(noise, time)
        least_return = max(self.noise_angle, self.noise_reversals * left)
        tolerance = max(self.closing_tolerance, least_return)
        loops = lock_to_lock.closed_loops(course, self.minimum_stroke, tolerance, least_return)
        begin, end = loops[0].first, loops[-1].last + 1
        loops = [loop.shifted(-begin) for loop in loops]
        time, angle, course, rate, driver, motor = (
            values[begin:end] for values in (time, angle, course, rate, driver, motor)
        )
        self._require_complete(time, dict(zip(_SIGNALS[1:], (rate, driver, motor), strict=True)))
        self._require_slow(course, lock_to_lock.smoothed(rate, time))
        apart = lock_to_lock.path_deviation(course, loops, left, self.sure_reversal)
        noises = self._noises(time, angle, driver, motor, loops, apart)
        twist = torsion_bar_twist(driver, self.torsion_bar_stiffness)
        rate = rate - torsion_bar_twist(lock_to_lock.slope(driver, time), self.torsion_bar_stiffness)
        motor = self.motor_gear_ratio * motor
        motion = lock_to_lock.Motion(
            time, angle - twist, course - lock_to_lock.smoothed(twist, time), rate, driver, motor
        )
        balances = tuple(lock_to_lock.work_balance(loop, motion, self.inertia, self.damping) for loop in loops)
        torque = driver + motor - self.damping * rate - self.inertia * lock_to_lock.slope(rate, time)
        return self._result(support, balances, loops, angle - twist, torque, noises)

    def angle_noise(self, recording: Recording) -> lock_to_lock.Noise:
        """Noise of the steering wheel's angle; above `largest_angle_noise` the loop cannot be judged."""
        aligned = recording.align(_SIGNALS[:1], self.sampling_rate, "linear", self.maximum_age)
        known = np.isfinite(aligned.values[:, 0])
        return lock_to_lock.noise_of(aligned.values[known, 0], aligned.time[known])

    def _noises(
        self,
        time: np.ndarray,
        angle: np.ndarray,
        driver: np.ndarray,
        motor: np.ndarray,
        loops: list[lock_to_lock.Loop],
        apart: float,
    ) -> tuple[NoisySignal, ...]:
        """Noise of angle and torques, and the standard deviation of the friction from each.

        By partial summation the work of the noise of the angle is its sum over the changes of the torque, and that of
        the noise of a torque its sum over the changes of the angle.
        """
        torque = driver + self.motor_gear_ratio * motor
        path = lock_to_lock.path_over(angle, loops)

        def work(noise: lock_to_lock.Noise, other: np.ndarray) -> float:
            # A torque without assist, say, has one reading, without noise.
            if len(noise.readings) < 2:
                return 0.0
            return noise.deviation * float(np.linalg.norm(np.gradient(other[noise.readings])))

        of_angle, of_driver, of_motor = (lock_to_lock.noise_of(values, time) for values in (angle, driver, motor))
        at_ends = of_angle.deviation * math.hypot(torque[0], torque[-1])
        by_path = abs(lock_to_lock.integral(torque, angle)) / path * apart
        return (
            NoisySignal("steering_wheel_angle", of_angle, math.hypot(work(of_angle, torque), at_ends, by_path) / path),
            NoisySignal("driver_torque", of_driver, work(of_driver, angle) / path),
            NoisySignal("motor_torque", of_motor, self.motor_gear_ratio * work(of_motor, angle) / path),
        )

    def _signals(self, recording: Recording) -> tuple[np.ndarray, ...]:
        for name in ("steering_wheel_angle", "driver_torque", "motor_torque"):
            if name not in recording or not len(recording[name].time):
                raise InputError(
                    f"the recording has no channel '{name}', which the work balance needs; map it in the channel map"
                )
            step = float(np.median(np.diff(recording[name].time))) if len(recording[name].time) > 1 else math.inf
            if not 0.0 < step <= self.maximum_age:
                raise InputError(
                    f"'{name}' is sampled every {step:.3g} s, but a lock-to-lock test needs a sample at least every "
                    f"{self.maximum_age} s; record it faster"
                )
        self._require_standing(recording)
        aligned = recording.align(_SIGNALS, self.sampling_rate, "linear", self.maximum_age)
        known = np.flatnonzero(np.isfinite(aligned.values[:, 0]))
        if len(known) < 2:
            raise InputError("'steering_wheel_angle' holds no values; check the channel map and that the sensor was on")
        span = slice(int(known[0]), int(known[-1]) + 1)
        time, (angle, rate, driver, motor) = aligned.time[span], aligned.values[span].T
        self._require_complete(time, {_SIGNALS[0]: angle})
        if "steering_wheel_rate" not in recording:
            rate = lock_to_lock.slope(angle, time)
        return time, angle, rate, driver, motor

    def _require_standing(self, recording: Recording) -> None:
        if "vehicle_speed" not in recording:
            return
        speed = np.abs(recording["vehicle_speed"].values)
        fastest = float(np.nanmax(speed)) if np.isfinite(speed).any() else 0.0
        if fastest > self.maximum_speed:
            raise InputError(
                f"the vehicle moves at up to {fastest:.1f} m/s, but a lock-to-lock test is done standing "
                f"(at most {self.maximum_speed} m/s); cut the recording to the test, or use the friction monitor"
            )

    def _require_slow(self, angle: np.ndarray, rate: np.ndarray) -> None:
        quick = float(np.percentile(np.abs(rate), 99.0))
        if quick > self.maximum_rate:
            least = np.ptp(angle) / self.maximum_rate
            raise InputError(
                f"the wheel is turned at {quick:.1f} rad/s, but above {self.maximum_rate:.1f} rad/s the viscous torque "
                f"hides the friction; turn steadily, in more than {least:.0f} s from lock to lock"
            )

    def _require_complete(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        for name, values in signals.items():
            missing = ~np.isfinite(values)
            if missing.any():
                seconds = missing.sum() / self.sampling_rate
                raise InputError(
                    f"{name} is missing or stuck for {seconds:.1f} s within the test, first at "
                    f"{time[np.argmax(missing)]:.2f} s (gap over {self.maximum_age} s); check the sensor and its "
                    "messages, and record the test again without gaps"
                )

    def _result(
        self,
        support: Support,
        balances: tuple[lock_to_lock.WorkBalance, ...],
        loops: list[lock_to_lock.Loop],
        angle: np.ndarray,
        torque: np.ndarray,
        noises: tuple[NoisySignal, ...],
    ) -> HysteresisFriction:
        friction = np.array([balance.friction_torque for balance in balances])
        count = len(friction)
        closing = np.mean([abs(b.gap) * b.torque_range / b.path for b in balances]) / math.sqrt(count)
        scatter = float(np.std(friction, ddof=1)) / math.sqrt(count) if count > 1 else 0.0
        mean_rate = float(np.mean([balance.mean_rate for balance in balances]))
        mean_friction = float(np.mean(friction))
        corners = sorted({corner for loop in loops for corner in loop.corners})
        reversed_at = lock_to_lock.pre_sliding(angle, torque, corners, mean_friction)
        build_up = 2.0 * (reversed_at.angle if reversed_at else self.unseen_build_up)
        lost = (
            mean_friction
            * build_up
            * float(np.mean([len(loop.turning_points) / b.path for loop, b in zip(loops, balances, strict=True)]))
        )
        independent = math.hypot(float(closing), scatter, lost, *(each.friction_deviation for each in noises))
        return HysteresisFriction(
            support=support,
            friction_torque=mean_friction,
            standard_deviation=math.hypot(independent, self.damping_deviation * mean_rate),
            independent_deviation=independent,
            noises=noises,
            damping_deviation=self.damping_deviation,
            mean_rate=mean_rate,
            loops=balances,
            pre_sliding=reversed_at,
            angle=angle,
            torque=torque,
        )


def friction_increase(
    faulted: HysteresisFriction, unfaulted: HysteresisFriction | Sequence[HysteresisFriction]
) -> Estimate:
    """Increase of friction from the fault-free to the faulted state of one vehicle."""
    healthy = [unfaulted] if isinstance(unfaulted, HysteresisFriction) else list(unfaulted)
    if not healthy or any(one.support != faulted.support for one in healthy):
        given = ", ".join(one.support for one in healthy) or "none"
        raise ParameterError(
            f"the faulted loop was taken on {faulted.support}, the unfaulted ones on: {given}; compare loops of one "
            "support only, since tyre scrub adds friction on the ground"
        )
    base = float(np.mean([one.friction_torque for one in healthy]))
    base_rate = float(np.mean([one.mean_rate for one in healthy]))
    base_deviation = math.sqrt(sum(one.independent_deviation**2 for one in healthy)) / len(healthy)
    common = faulted.damping_deviation * (faulted.mean_rate - base_rate)
    deviation = math.sqrt(faulted.independent_deviation**2 + base_deviation**2 + common**2)
    return Estimate(
        f"increase of {PLACE}, on {faulted.support}",
        faulted.friction_torque - base,
        deviation,
        "N*m",
        {"unfaulted": base},
    )
