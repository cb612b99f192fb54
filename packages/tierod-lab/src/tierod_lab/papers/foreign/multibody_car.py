"""Drives of CommonRoad's multi-body car, a BMW 320i, as readings of its motion sensors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.vehicles import Vehicle, load
from tierod_lab.papers.condition.real_cars import RealCar

RATE = 100.0  # Sampling rate of the recording [Hz]
STEERING_RATIO, AXLE_STIFFNESS = 1.0 / 16.0, (107e3, 119e3)
"""Road wheel angle over steering wheel angle, which CommonRoad does not give; cornering stiffness of the axles [N/rad],
from the coefficient 21.9 of CommonRoad's tyres, per load and friction."""
# The model names left the wheels that roll faster in a left turn, so that its sides are interchanged.
WHEELS = ("front_right", "front_left", "rear_right", "rear_left")
READINGS = {
    **{f"wheel_speed_{each}": (0.02, "m/s") for each in ("front_left", "front_right", "rear_left", "rear_right")},
    "yaw_rate": (3e-3, "rad/s"),
    "steering_wheel_angle": (5e-3, "rad"),
    "lateral_acceleration": (0.05, "m/s**2"),
    "longitudinal_acceleration": (0.05, "m/s**2"),
}
"""Standard deviation of the noise of each signal, and its unit."""


@dataclass(frozen=True)
class MultibodyCar(RealCar):
    """CommonRoad's car in the form of a car of the study of real cars."""

    seed: int = 0  # seed of course and noise

    @property
    def known(self) -> Vehicle:
        """Vehicle with the parameters of CommonRoad's car; all others are those of the RAV4."""
        base, given = load("rav4"), _parameters()
        values = {"mass": given.m, "yaw_inertia": given.I_z, "track_width": given.T_r}
        values |= {"front_distance": given.a, "rear_distance": given.b, "steering_ratio": STEERING_RATIO}
        stiffness = zip(("front_cornering_stiffness", "rear_cornering_stiffness"), AXLE_STIFFNESS, strict=True)
        values |= dict(stiffness)
        changed = {name: replace(base.parameters[name], value=float(value)) for name, value in values.items()}
        return replace(base, parameters={**base.parameters, **changed})

    def recording(self) -> Recording | None:
        """The simulated recording; None where CommonRoad's models are not installed."""
        try:
            return multibody_drive(self.seed, self.learning + 30.0)
        except InputError:
            return None


@lru_cache(maxsize=4)
def multibody_drive(seed: int, seconds: float) -> Recording:
    """Simulate a drive through bends of up to some 2.5 m/s2, between 8 and 20 m/s.

    Raises:
        InputError: the package `commonroad-vehicle-models` is not installed
    """
    given = _parameters()
    from scipy.integrate import solve_ivp
    from vehiclemodels.init_mb import init_mb
    from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb

    random = np.random.default_rng([seed, 4])
    knots = np.arange(0.0, seconds + 6.0, 3.0)
    lateral = random.uniform(-2.5, 2.5, len(knots)) * (random.random(len(knots)) < 0.8)
    speeds = np.clip(14.0 + np.cumsum(random.normal(size=len(knots))), 8.0, 20.0)

    def slope(instant: float, state: np.ndarray) -> list[float]:
        target = float(np.interp(instant, knots, speeds))
        wanted = float(np.interp(instant, knots, lateral)) * (given.a + given.b) / target**2
        rate = float(np.clip(4.0 * (wanted - state[2]), -0.3, 0.3))
        along = float(np.clip(target - state[3], -2.0, 2.0))
        rates: list[float] = vehicle_dynamics_mb(list(state), [rate, along], given)
        return rates

    time = np.arange(round(seconds * RATE)) / RATE
    begin = np.array(init_mb([0.0, 0.0, 0.0, speeds[0], 0.0, 0.0, 0.0], given), float)
    states = solve_ivp(slope, (0.0, time[-1]), begin, "LSODA", t_eval=time, rtol=1e-6, atol=1e-8, max_step=0.02).y
    along, yaw, across = states[3], states[5], states[10]
    signals = {f"wheel_speed_{name}": given.R_w * states[23 + place] for place, name in enumerate(WHEELS)} | {
        "yaw_rate": yaw,
        "steering_wheel_angle": states[2] / STEERING_RATIO,
        "lateral_acceleration": np.gradient(across, 1.0 / RATE) + along * yaw,
        "longitudinal_acceleration": np.gradient(along, 1.0 / RATE) - across * yaw,
    }
    channels = {}
    for name, (deviation, unit) in READINGS.items():
        read = signals[name] + deviation * random.normal(size=len(time))
        channels[name] = Channel(name, time, read, unit)
    return Recording(channels, {"source": "commonroad-vehicle-models"})


def _parameters() -> Any:
    try:
        from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
    except ImportError:
        raise InputError("the models of CommonRoad are not here; pip install commonroad-vehicle-models") from None
    return parameters_vehicle2()
