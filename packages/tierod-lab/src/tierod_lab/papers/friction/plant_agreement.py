"""Comparison of the virtual car's chassis with another simulator: figures for tests and lists of claims."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod_lab.ground.chassis import Axle, Kingpins, TwoTrack, Tyre
from tierod_lab.papers.friction.plant_checks import STEP, courses
from tierod_lab.papers.friction.plant_replay import Replay


class Agreement(NamedTuple):
    """Differences of a chassis from a reference."""

    yaw_rate: float  # yaw_rate, lateral_acceleration: RMS of the difference divided by that of the reference [-]
    lateral_acceleration: float
    yaw_rate_error: float  # RMS of the difference [rad/s]
    gain: float  # standard deviation of the chassis' yaw rate divided by that of the reference [-]
    correlation: float  # correlation coefficient of both yaw rates [-]
    peak: float  # maximum lateral acceleration of the reference [m/s**2]


def agreement(ours: np.ndarray, theirs: np.ndarray) -> Agreement:
    """Compare two pairs of series, with the columns yaw rate [rad/s] and lateral acceleration [m/s**2]."""
    error, size = (np.sqrt(np.mean(np.square(values), axis=0)) for values in (ours - theirs, theirs))
    yaw, reference = ours[:, 0], theirs[:, 0]
    return Agreement(
        float(error[0] / size[0]),
        float(error[1] / size[1]),
        float(error[0]),
        float(np.std(yaw) / np.std(reference)),
        float(np.corrcoef(yaw, reference)[0, 1]),
        float(np.max(np.abs(theirs[:, 1]))),
    )


def _commonroad() -> Any:
    try:
        from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
    except ImportError:
        raise InputError(
            "the models of CommonRoad are not here to compare with; pip install commonroad-vehicle-models"
        ) from None
    return parameters_vehicle2()


def commonroad_tyre() -> Tyre:
    """The tyre of CommonRoad's models as a `Tyre`: stiffness and friction proportional to the load, no trail."""
    given = _commonroad()
    tyre = given.tire
    return Tyre(
        radius=given.R_w,
        nominal_load=3000.0,
        cornering_stiffness=-1e3 * tyre.p_ky1,
        load_of_greatest=2e3,
        longitudinal_stiffness=tyre.p_kx1,
        friction=tyre.p_dy1,
        longitudinal_friction=tyre.p_dx1 / tyre.p_dy1,
        load_sensitivity=0.0,
        shape=tyre.p_cy1,
        curvature=tyre.p_ey1,
        trail=0.0,
        lateral_relaxation=0.05,
        longitudinal_relaxation=0.05,
        damping_time=0.0,
        rolling_coefficient=0.0,
    )


def commonroad_car(rolling: bool) -> TwoTrack:
    """CommonRoad's vehicle 2 (a BMW 320i) as a `TwoTrack`.

    Args:
        rolling: whether its body rolls, as in the multi-body model; the drift single-track model has no height
    """
    given, tyre = _commonroad(), commonroad_tyre()
    axles = []
    for spring, damper, track, bar in (
        (given.K_sf, given.K_sdf, given.T_f, given.K_tsf),
        (given.K_sr, given.K_sdr, given.T_r, given.K_tsr),
    ):
        half = 0.5 * track * track
        axles.append(Axle(track, 0.0, half * spring - bar, half * damper, 0.0, given.I_y_w, tyre))
    unsprung = given.m - given.m_s
    return TwoTrack(
        mass=given.m,
        yaw_inertia=given.I_z,
        front_distance=given.a,
        rear_distance=given.b,
        centre_height=given.h_cg if rolling else 0.01,
        roll_inertia=given.I_Phi_s + given.m_s * unsprung / given.m * given.h_s**2,
        drag_area=0.0,
        side_area=0.0,
        front=axles[0],
        rear=axles[1],
        kingpins=Kingpins(0.0, 0.0, 0.0),
    )


def commonroad_agreement(speed: float, steer: float, frequency: float, multibody: bool = False) -> Agreement:
    """Compare the chassis with CommonRoad's drift single-track or multi-body model at equal parameters and inputs.

    Args:
        speed: initial speed, then coasting [m/s]
        steer: amplitude of the road wheels [rad]
        frequency: frequency of the weave, which grows over its first second [Hz]

    Raises:
        InputError: the package `commonroad-vehicle-models` is not installed
    """
    given = _commonroad()
    from scipy.integrate import solve_ivp
    from vehiclemodels.init_mb import init_mb
    from vehiclemodels.init_std import init_std
    from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb
    from vehiclemodels.vehicle_dynamics_std import vehicle_dynamics_std

    model, start = (vehicle_dynamics_mb, init_mb) if multibody else (vehicle_dynamics_std, init_std)
    time = np.arange(round(8.0 / STEP)) * STEP

    def angle(instant: float) -> float:
        return float(steer * np.sin(2.0 * np.pi * frequency * instant) * min(1.0, instant))

    def slope(instant: float, state: np.ndarray) -> list[float]:
        rate = (angle(instant + 1e-6) - angle(instant - 1e-6)) / 2e-6
        rates: list[float] = model(list(state), [rate, 0.0], given)
        return rates

    begin = np.array(start([0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0], given), dtype=float)
    states = solve_ivp(slope, (0.0, time[-1]), begin, "LSODA", t_eval=time, rtol=1e-7, atol=1e-9, max_step=0.01).y
    along, yaw, lateral = _multibody_motion(states, given) if multibody else _single_track_motion(states)
    out = scan(Replay(commonroad_car(multibody), start_speed=speed), courses(states[2], along))
    ours = np.column_stack([out["yaw_rate"], out["lateral_acceleration"]])
    return agreement(ours, np.column_stack([yaw, lateral]))


def _single_track_motion(states: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    speed, yaw, sideslip = states[3], states[5], states[6]
    along = speed * np.cos(sideslip)
    return along, yaw, np.gradient(speed * np.sin(sideslip), STEP) + along * yaw


def _multibody_motion(states: np.ndarray, given: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Speed, yaw rate, and lateral acceleration of the common centre of gravity of body and axles."""
    along, yaw = states[3], states[5]
    masses = ((given.m_s, states[10]), (given.m_uf, states[15]), (given.m_ur, states[20]))
    lateral = sum(mass * (np.gradient(across, STEP) + along * yaw) for mass, across in masses) / given.m
    return along, yaw, lateral
