"""Wheel imbalance: an unbalanced front wheel shakes the steering wheel once per turn of the wheel.

The driver's torque is demodulated with the angle of the wheel, which is the integral of speed over wheel radius; a
low-pass leaves the amplitude of the torque at that frequency.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod import BlockSession, Conclusion, Estimate, Fact, Monitor, Status, Variant, Vehicle, Verdict, maths
from tierod.core.block import Scalar
from tierod.core.graph import Result

LIMIT = 0.1
"""Amplitude [N*m] that a driver feels at the rim; assumed, in practice from a panel of drivers."""

PATIENCE = 3.0
"""Time constants of the low-pass after which its start is forgotten to 5 %."""


@dataclass(frozen=True)
class TorqueOncePerTurn:
    """Amplitude of the driver's torque at the frequency at which the wheels turn.

    Args:
        wheel_radius: effective radius of the wheels [m]
        period: between two samples [s]
        memory: time constant of the low-pass [s]; it passes 1 / (2 pi memory) beside the frequency of the wheels
        slowest: speed from which it listens [m/s]; below, the frequency lies among those of steering (up to 3 Hz)
    """

    wheel_radius: Annotated[float, "m"]
    period: Annotated[float, "s"] = 0.01
    memory: Annotated[float, "s"] = 5.0
    slowest: Annotated[float, "m/s"] = 15.0

    class Sample(NamedTuple):
        """Driver's torque and speed."""

        driver_torque: Annotated[Scalar, "N*m"]
        vehicle_speed: Annotated[Scalar, "m/s"]

    class State(NamedTuple):
        """Angle of the wheel, torque along its cosine and sine, time listened to."""

        angle: Annotated[Scalar, "rad"]
        cosine: Annotated[Scalar, "N*m"]
        sine: Annotated[Scalar, "N*m"]
        seconds: Annotated[Scalar, "s"]

    class Output(NamedTuple):
        """Amplitude, and the time over which it was found."""

        amplitude: Annotated[Scalar, "N*m"]
        seconds: Annotated[Scalar, "s"]

    def init(self) -> State:
        """Nothing heard yet."""
        return self.State(0.0, 0.0, 0.0, 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        """One sample on; a missing one changes nothing but the angle."""
        speed = maths.where(maths.present(sample.vehicle_speed), sample.vehicle_speed, 0.0)
        turned = state.angle + speed / self.wheel_radius * self.period
        angle = maths.where(turned > 2.0 * math.pi, turned - 2.0 * math.pi, turned)
        heard = maths.all_of(maths.present(sample.driver_torque), speed > self.slowest)
        torque = maths.where(heard, sample.driver_torque, 0.0)
        gain = maths.where(heard, self.period / self.memory, 0.0)
        cosine = state.cosine + gain * (2.0 * torque * maths.cos(angle) - state.cosine)
        sine = state.sine + gain * (2.0 * torque * maths.sin(angle) - state.sine)
        seconds = state.seconds + maths.where(heard, self.period, 0.0)
        amplitude = maths.sqrt(cosine * cosine + sine * sine)
        return self.State(angle, cosine, sine, seconds), self.Output(amplitude, seconds)


class ImbalanceSession(BlockSession):
    """The amplitude over one recording, judged by its last value.

    Args:
        vehicle: gives the radius of the wheels
        rate: of the samples [Hz]
    """

    def __init__(self, vehicle: Vehicle, rate: float):
        block = TorqueOncePerTurn(vehicle["wheel_radius"], 1.0 / rate)
        super().__init__(block, {"amplitude": ("imbalance_torque", "N*m")})
        self.patience, self.amplitude, self.seconds = PATIENCE * block.memory, 0.0, 0.0

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Keep the last values."""
        self.amplitude, self.seconds = float(result["amplitude"][-1]), float(result["seconds"][-1])

    def conclude(self) -> Conclusion:
        """Fault where a driver feels it."""
        evidence = {"listened_seconds": self.seconds}
        if self.seconds < self.patience:
            cause = f"the car was fast enough for {self.seconds:.3g} s; {self.patience:g} s are needed"
            slow = Fact("slow", cause, "the car was too slow", "drive faster than 54 km/h for longer")
            return Conclusion(Verdict("wheel-imbalance", Status.NOT_ENABLED, (slow,), evidence=evidence))
        estimate = Estimate("torque once per turn of the wheels", self.amplitude, 0.01, "N*m", {"limit": LIMIT})
        felt = self.amplitude > LIMIT
        status = Status.FAULT if felt else Status.HEALTHY
        unbalanced = Fact("unbalanced", "a front wheel is out of balance", action="balance the front wheels")
        because = (unbalanced,) if felt else ()
        return Conclusion(Verdict("wheel-imbalance", status, because, estimate, evidence=evidence))


WHEEL_IMBALANCE = Monitor(
    name="wheel-imbalance",
    title="Wheel imbalance",
    summary="Finds a front wheel that is out of balance by the torque it puts into the steering wheel.",
    source="synchronous demodulation, any textbook of signal processing",
    required=("driver_torque", "vehicle_speed"),
    optional=(),
    rate=100.0,
    minimum_rate=50.0,
    maximum_age=0.1,
    variants={
        "demodulation": Variant(
            "demodulation",
            "Amplitude at the frequency of the wheels.",
            "",
            lambda vehicle, rate, own_level: ImbalanceSession(vehicle, rate),
        )
    },
    default="demodulation",
)
