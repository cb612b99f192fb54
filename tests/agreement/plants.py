"""The virtual car's chassis beside CommonRoad's models and beside recordings of real cars."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from chassis_replay import STEP, Replay, courses
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.core.series import runs
from tierod.vehicles import load
from tierod_lab.ground.chassis import Axle, Kingpins, TwoTrack, Tyre
from tierod_lab.ground.parts import Wheels
from tierod_lab.ground.powertrain import Powertrain

STEERING_ZERO = -0.0029
"""Steering offset of the race laps [rad], fitted with the cornering stiffnesses; it drifts by 1 mrad within minutes."""
LINEAR = 4.0  # Lateral acceleration up to which tyres and car are regarded as linear [m/s**2]
SETTLING = 0.5  # Time at the start of every part that is excluded from the comparison [s]


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
    from vehiclemodels.parameters_vehicle2 import parameters_vehicle2

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


def _at(recording: Recording, names: tuple[str, ...], time: np.ndarray) -> list[np.ndarray]:
    return [np.interp(time, recording[name].time, recording[name].values) for name in names]


def rav4_agreement(recording: Recording) -> Agreement:
    """Compare the chassis, with the parameters of the RAV4's vehicle file, with the recorded yaw rate of one minute.

    The recording does not contain the offset of the gyroscope, so the mean difference is removed.

    Args:
        recording: the minute, with steering-wheel angle, speed, yaw rate and lateral acceleration
    """
    car = load("rav4")
    chassis = TwoTrack(
        mass=car["mass"],
        yaw_inertia=car["yaw_inertia"],
        front_distance=car["front_distance"],
        rear_distance=car["rear_distance"],
    ).with_axle_stiffness(car["front_cornering_stiffness"], car["rear_cornering_stiffness"])
    first, last = recording["steering_wheel_angle"].time[[0, -1]]
    time = np.arange(first + 0.1, last - 0.1, STEP)
    names = ("steering_wheel_angle", "vehicle_speed", "yaw_rate", "lateral_acceleration")
    angle, speed, yaw, lateral = _at(recording, names, time)
    out = scan(Replay(chassis, start_speed=float(speed[0])), courses(car["steering_ratio"] * angle, speed))
    ours = np.column_stack([out["yaw_rate"], out["lateral_acceleration"]])
    theirs = np.column_stack([yaw, lateral])
    return agreement(ours - np.mean(ours - theirs, axis=0), theirs)


def ferrari() -> TwoTrack:
    """The Ferrari 250 LM of the public race laps.

    Masses and distances are published with the laps; cornering stiffnesses are fitted to yaw rate and sideslip in the
    linear parts, up to 5 m/s**2, of their first half; all other parameters are assumed.
    """
    tyre = Tyre(nominal_load=2500.0, friction=1.3, load_sensitivity=-0.05, trail=0.02, lateral_relaxation=0.3)
    return TwoTrack(
        mass=982.0,
        yaw_inertia=1400.0,
        front_distance=1.33,
        rear_distance=1.07,
        centre_height=0.42,
        roll_inertia=250.0,
        front=Axle(1.35, 0.05, 60e3, 2500.0, 0.0, 1.0, tyre),
        rear=Axle(1.35, 0.10, 50e3, 2500.0, 0.0, 1.2, replace(tyre, cornering_stiffness=40.0)),
    ).with_axle_stiffness(83e3, 145e3)


def ferrari_agreement(recording: Recording, second_half: bool = True) -> Agreement:
    """Compare the chassis with the Ferrari's yaw rate and speed times yaw rate, in the linear parts of the race laps.

    Every part of 1.5 s or more is simulated separately from the recorded state of motion, since an open loop at the
    limit of adhesion does not stay where the driver kept the car.

    Args:
        recording: the laps, with road-wheel angle, speed, lateral speed and yaw rate
        second_half: whether to judge the half that was not used for fitting, or the other one
    """
    first, last = recording["vehicle_speed"].time[[0, -1]]
    time = np.arange(first, last, STEP)
    names = ("road_wheel_angle", "vehicle_speed", "lateral_speed", "yaw_rate")
    series = _at(recording, names, time)
    ours, theirs = [], []
    for start, stop in _linear_parts(time, series[1] * series[3]):
        if (start > len(time) / 2) == second_half:
            steer, speed, across, yaw = (values[start:stop] for values in series)
            out = _driven_from(ferrari(), steer - STEERING_ZERO, speed, float(across[0]), float(yaw[0]))
            judged = slice(round(SETTLING / STEP), None)
            ours.append(np.column_stack([out["yaw_rate"], out["speed"] * out["yaw_rate"]])[judged])
            theirs.append(np.column_stack([yaw, speed * yaw])[judged])
    return agreement(np.concatenate(ours), np.concatenate(theirs))


def _linear_parts(time: np.ndarray, lateral: np.ndarray) -> list[tuple[int, int]]:
    """Start and end index of every part; a glitch of the steering sensor at 207.27 s is excluded."""
    width = round(0.4 / STEP)
    smooth = np.convolve(lateral, np.ones(width) / width, "same")
    fit = (np.abs(smooth) < LINEAR) & (np.abs(time - 207.27) > 1.5)
    begins, ends = runs(fit)
    parts = zip(begins.tolist(), ends.tolist(), strict=True)
    return [(start, stop) for start, stop in parts if stop - start > round(1.5 / STEP)]


def _driven_from(chassis: TwoTrack, steer: np.ndarray, speed: np.ndarray, across: float, yaw: float) -> Any:
    replay = Replay(
        chassis, Powertrain(front_share=0.0, greatest_power=400e3, greatest_speed=100.0), start_speed=float(speed[0])
    )
    front_slip = float(steer[0]) - (across + chassis.front_distance * yaw) / float(speed[0])
    rear_slip = -(across - chassis.rear_distance * yaw) / float(speed[0])
    front = front_slip * chassis.front.tyre.lateral_relaxation
    rear = rear_slip * chassis.rear.tyre.lateral_relaxation
    begin = replay.init()._replace(lateral_speed=across, yaw_rate=yaw, lateral=Wheels(front, front, rear, rear))
    return scan(replay, courses(steer, speed), begin)
