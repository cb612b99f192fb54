"""Simple sideslip estimators, with which the combined one is compared on real cars."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.core.graph.maths import present, where
from tierod.core.recording import Recording
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.linear import discretise
from tierod.models.single_track import SingleTrack
from tierod.vehicles import Vehicle
from tierod_lab.papers.sideslip.calibration import BesideTruth, truth_of

LINEAR: Any = discretise(SingleTrack, "midpoint")
RATE = 100.0

LINEAR_START = {
    "front": 8e4,
    "rear": 1.2e5,
    "yaw_rate": 0.01,
    "lateral_acceleration": 2.0,
    "sideslip_drift": 0.02,
    "yaw_drift": 0.3,
}
"""Initial cornering stiffnesses [N/rad], noises and drifts for the fit of the linear filter."""


@dataclass(frozen=True)
class LeakyKinematic:
    """Lateral speed as the leaky integral of lateral acceleration less yaw rate times speed.

    Args:
        sample_time: sampling interval
        leak_time: time constant of the leak; a longer one drifts more, a shorter one loses long corners
    """

    sample_time: Annotated[float, "s"]
    leak_time: Annotated[float, "s"]

    class Sample(NamedTuple):
        vehicle_speed: Annotated[Any, "m/s"]
        yaw_rate: Annotated[Any, "rad/s"]
        lateral_acceleration: Annotated[Any, "m/s**2"]

    def init(self) -> float:
        return 0.0

    def step(self, state: Any, sample: Any) -> tuple[Any, Any]:
        rate = sample.lateral_acceleration - sample.yaw_rate * sample.vehicle_speed - state / self.leak_time
        speed = where(present(rate), state + self.sample_time * rate, state)
        return speed, speed / sample.vehicle_speed


def signals(recording: Recording, names: tuple[str, ...], rate: float = RATE) -> tuple[np.ndarray, np.ndarray]:
    """Sampling times [s] and the named signals on that grid, (n,) and (n, k)."""
    aligned = recording.align(names, rate, maximum_age=0.1)
    return aligned.time, aligned.values


def beside(recording: Recording, estimate: np.ndarray, rate: float = RATE) -> BesideTruth:
    """An estimate without a band, paired with the truth of the recording."""
    time, truth = signals(recording, (truth_of(recording),), rate)
    return BesideTruth(time, estimate, np.full(len(time), np.nan), truth[:, 0])


def nothing(recording: Recording) -> BesideTruth:
    """The estimate of zero sideslip."""
    return beside(recording, np.zeros(len(signals(recording, ("vehicle_speed",))[0])))


def leaky(recording: Recording, until: float, leak_time: float = 1.5) -> BesideTruth:
    """The leaky integral, with gain (roll) and offset of the acceleration fitted to the part before a time [s]."""
    time, values = signals(recording, (*LeakyKinematic.Sample._fields, truth_of(recording)))
    block, speed, truth = LeakyKinematic(1.0 / RATE, leak_time), values[:, 0], values[:, 3]
    # The integral is linear in its inputs: with one part for the yaw rate and one for the acceleration, least squares
    # find the gain without another run.
    turning, accelerating = (
        scan(block, values[:, :3] * np.array(kept)).values[:, 0] for kept in ((1.0, 1.0, 0.0), (1.0, 0.0, 1.0))
    )
    columns = np.column_stack([accelerating, 1.0 / speed])
    early = (time < until) & np.isfinite(truth)
    gains = np.linalg.lstsq(columns[early], (np.tan(truth) - turning)[early], rcond=None)[0]
    return beside(recording, np.arctan(turning + columns @ gains))


def linear(recording: Recording, vehicle: Vehicle, until: float) -> BesideTruth:
    """A linear single-track Kalman filter; stiffnesses, noises and offsets are fitted to the part before a time [s]."""
    from scipy.optimize import least_squares

    names = ("road_wheel_angle", "vehicle_speed", "yaw_rate", "lateral_acceleration")
    _, values = signals(recording, names)
    # Units of 3 mrad for the zeros, and of 30 % for the other parameters, put all of them on one scale.
    offset, span = np.array([1.0, 0.0, 0.0, 0.0]), np.array([3e-3, 3e-3])

    def run(moved: np.ndarray) -> BesideTruth:
        tuned = dict(zip(LINEAR_START, np.array(list(LINEAR_START.values())) * np.exp(0.3 * moved[2:]), strict=True))
        zeros = span * moved[:2]
        out = scan(linear_filter(vehicle, tuned), values + zeros[0] * offset)
        return beside(recording, out["mean.sideslip_angle"] + zeros[1])

    def residuals(moved: np.ndarray) -> np.ndarray:
        seen = run(moved)
        # Without the first second of warm-up; the last terms keep the parameters near their start.
        return np.concatenate([np.degrees(seen.error[(seen.time < until)][100::10]), 0.3 * moved])

    return run(least_squares(residuals, np.zeros(2 + len(LINEAR_START)), diff_step=1e-3, max_nfev=15).x)


def linear_filter(vehicle: Vehicle, tuned: dict[str, float], rate: float = RATE) -> KalmanFilter:
    """A Kalman filter of the linear single-track model.

    Args:
        vehicle: vehicle file that gives mass, yaw inertia and axle distances
        tuned: stiffnesses, noises and drifts, as in `LINEAR_START`
        rate: sampling rate [Hz]
    """
    names = ("mass", "yaw_inertia", "front_distance", "rear_distance")
    mass, inertia, front, rear = (vehicle[name] for name in names)
    car = SingleTrack.Parameters(mass, inertia, front, rear, tuned["front"], tuned["rear"])
    return KalmanFilter(
        LINEAR,
        LINEAR.Parameters(car, 1.0 / rate),
        initial_mean=(0.0, 0.0),
        initial_variance=(0.01, 0.1),
        process_noise=(tuned["sideslip_drift"] ** 2 / rate, tuned["yaw_drift"] ** 2 / rate),
        measurement_noise=(tuned["yaw_rate"] ** 2, tuned["lateral_acceleration"] ** 2),
    )


def geometric(recording: Recording, until: float, rate: float = 50.0) -> BesideTruth:
    """Rear distance times yaw rate over speed, with the distance fitted to the part before a time.

    Args:
        recording: recording with yaw rate, speed and truth
        until: end of the part that is fitted [s]
        rate: sampling rate [Hz]
    """
    time, values = signals(recording, ("yaw_rate", "vehicle_speed", truth_of(recording)), rate)
    curvature, truth = values[:, 0] / values[:, 1], values[:, 2]
    early = time < until
    distance = float(curvature[early] @ truth[early] / (curvature[early] @ curvature[early]))
    return beside(recording, distance * curvature, rate)
