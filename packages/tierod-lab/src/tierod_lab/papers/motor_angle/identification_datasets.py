"""Parameters of a motor from a drive, with statistical and guaranteed intervals, and recordings of a real drive."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tierod.core.block import Block
from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.io.readers import read
from tierod.methods.identification.motor import identify_motor
from tierod.methods.identification.motor_recording import motor_recording
from tierod.methods.identification.regression import Modulation, Rows, regress
from tierod.models.stator_frame_motor import MotorParameters, SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver, MotorAngleTuning
from tierod.physics.pm_motor import flux_at, resistance_at
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.back_emf import FeedforwardAngle, FluxObserver
from tierod_lab.papers.motor_angle.bench import NOISE, SAMPLE_TIME, noises, rms
from tierod_lab.papers.motor_angle.drawn_motors import drawn, parameter_errors, recording
from tierod_lab.papers.motor_angle.guaranteed_intervals import NAMES, MotorErrorBounds, guaranteed_motor
from tierod_lab.papers.real_data import path_of
from tierod_lab.studies.metrics import Row

CURVATURE = 2e7
"""Assumed bound of the second derivative of a current [A/s**2]: a rate of 60 A/ms that decays within 3 ms."""
_WIDE = math.sqrt(3.0)  # Half width of a uniform distribution over its standard deviation


def identified(task: tuple[int, float]) -> list[Row]:
    """Motors with drawn parameters and temperatures, each identified from a drive of 10 s against an unrecorded spring.

    The noise is 0.15 A, 0.03 V and 0.0005 rad at 10 kHz. On another drive the default observer then has the identified
    and the true parameters.
    """
    seed, seconds = task
    motor, known = drawn(seed), load("motor-bench")
    result = identify_motor(
        known.parameters_for(MotorParameters), {"drive": recording(motor.driven(seed), motor.temperature)}
    )
    rows = parameter_errors(motor, result)
    if not seconds:
        return rows
    seen, m = motor.driven(seed + 5000, seconds), motor.machine
    usual = replace(known.parameters_for(SampledMotorParameters), sample_time=SAMPLE_TIME)
    learnt = {each.name: each.value for each in result.found if hasattr(usual, each.name)}
    names = ("resistance", "flux", "inertia", "damping")
    true = {f"motor_{name}": getattr(m, name) for name in names} | {"motor_inductance": m.inductance_q}
    found, best = (rms(seen.error(MotorAngleObserver(replace(usual, **each)))) for each in (learnt, true))
    return [*rows, {"parameter": "angle", "over_true": found / best}]


def guaranteed(seed: int) -> list[Row]:
    """Estimation with unknown but bounded errors: all parameters that no reading contradicts form a polytope.

    Errors are uniform, with the deviations of the other parts, and their bounds are known. The box around the polytope
    holds without any assumption on the errors but their bounds.
    """
    motor, p = drawn(seed), load("motor-bench").parameters_for(MotorParameters)
    seen = motor.driven(seed, 4.0)
    shape = seen.samples.shape
    uniform = np.random.default_rng([seed, 6]).uniform(-_WIDE, _WIDE, shape) * NOISE
    bounded = replace(seen, samples=seen.samples - noises(seed, shape) + uniform)
    current, _, voltage, _, angle = (_WIDE * each for each in NOISE)
    bounds = MotorErrorBounds(current, voltage, angle, CURVATURE)
    made = motor_recording("drive", recording(bounded), p.motor_pole_pairs)
    box = guaranteed_motor([made], p.motor_pole_pairs, bounds)
    warm = float(resistance_at(motor.temperature, 1.0))
    true = np.array(
        [
            warm * motor.machine.resistance,
            motor.machine.inductance_q,
            float(flux_at(motor.temperature, motor.machine.flux)),
        ]
    )
    return [
        {
            "parameter": name,
            "half_width": float(half),
            "holds": float(low <= value <= high),
        }
        for name, low, high, value, half in zip(NAMES, box.low, box.high, true, box.half_width / true, strict=True)
    ]


DRAGGED, SPEED, POSITION = "SigRecSaveE.mat", "RecordSpeedRslt.mat", "RecordPosRslt.mat"
"""Recordings: a rotor that a current vector drags at 6 Hz; motions at constant speed and to and fro, with current."""
ASSUMED = MotorParameters(0.2, 5e-4, 0.132, 1.0, 1e-3, 1e-3)
"""Assumed parameters of the drive, from its maker's program where it states them.

One pole pair makes all angles electrical ones. Inertia and damping are placeholders without effect at constant speed.
"""
_FINE = 2e-4
"""Sampling interval of the interpolated recording for the observers [s]; its own is too long for their integration."""
_STANDS = 0.05  # Speed scale of the smoothed sign in the dry friction [1/s]
_CURRENTS = ("motor_current_alpha", "motor_current_beta")
_VOLTAGES = ("motor_voltage_alpha", "motor_voltage_beta")


def real_drive(name: str) -> list[Row]:
    """Recordings of a small drive by its own recorder; none holds currents, voltages and an independent angle together.

    Dragged: the current is counted out of the motor; the drive's own estimate of its angle is no truth. Friction: the
    current over speed and position of one file predicts the current of another.
    """
    paths = {"dragged": (DRAGGED,), "friction": (SPEED, POSITION)}[name]
    files = [path_of("pmsm_drive", each) for each in paths]
    if not all(each.exists() for each in files):
        return []
    return _dragged(read(files[0])) if name == "dragged" else _friction(*map(read, files))


def _column(found: Recording, name: str) -> np.ndarray:
    return found[next(each for each in found.names if each.rpartition(".")[2] == name)].values


def _dragged(found: Recording) -> list[Row]:
    time = found[_CURRENTS[0]].time
    angle = Channel("motor_angle_electrical", time, 2.0 * np.pi * _column(found, "SlessThetaHat"), "rad")
    said = ""
    try:
        identify_motor(ASSUMED, {"drive": found.with_channels([angle])})
    except InputError as error:
        said = str(error)
    rows: list[Row] = [{"what": "current sign", "said": float("sign = -1" in said)}]
    samples, own = _dragged_samples(found)
    fixed = SampledMotorParameters(**vars(ASSUMED), sample_time=_FINE)
    # Resistance and flux are not identifiable with the angle at one speed and current.
    held = replace(MotorAngleTuning(), resistance_wander=0.0, first_resistance=1e-3, flux_wander=0.0, first_flux=0.02)
    observers: dict[str, Block] = {
        "default": MotorAngleObserver(fixed, held),
        "feedforward": FeedforwardAngle(fixed),
        "flux observer": FluxObserver(fixed),
    }
    settled = slice(len(own) // 3, None)
    for name, observer in observers.items():
        away = np.exp(1j * (scan(observer, samples)["motor_angle"] - own))[settled]
        mean = float(np.angle(away.mean()))
        rows.append({"what": name, "mean": mean, "deviation": float(np.std(np.angle(away * np.exp(-1j * mean))))})
    return rows


def _dragged_samples(found: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Samples of an observer with the currents turned round, by splines, and the drive's own estimate [rad]."""
    from scipy.interpolate import CubicSpline

    time = found[_CURRENTS[0]].time
    fine = np.arange(time[0] + _FINE, time[-1], _FINE)
    own = CubicSpline(time, np.unwrap(2.0 * math.pi * _column(found, "SlessThetaHat")))(fine)
    currents = [-CubicSpline(time, found[name].values)(fine) for name in _CURRENTS]
    # The observers take a voltage as mean over the sample, which the antiderivative of the spline gives exactly.
    sums = [CubicSpline(time, found[name].values).antiderivative() for name in _VOLTAGES]
    voltages = [(each(fine) - each(fine - _FINE)) / _FINE for each in sums]
    return np.column_stack([*currents, *voltages, own]), own


def _friction(speed: Recording, position: Recording) -> list[Row]:
    name = next(each for each in position.names if each.rpartition(".")[2] == "PosFeedBack")
    step = float(np.median(np.diff(position[name].time)))
    window, place = Modulation(16, 2, step), position[name].values
    direction = np.tanh(_column(position, "UserSpeed") / _STANDS)
    columns = [window.acceleration(place), window.rate(place), window.mean(direction)]
    regressors = np.column_stack([*columns, np.ones_like(columns[0])])
    fit = regress([Rows(window.mean(_column(position, "motor_current_q")), regressors, regressors)])
    there, needed = (float(np.mean(_column(speed, each))) for each in ("UserSpeed", "motor_current_q"))
    return [{"what": "friction", "over_recorded": float((fit.values[1] * there + fit.values[2]) / needed)}]
