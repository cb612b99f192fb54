"""Identification of a car from ordinary drives: parameters of its motion, and the ratio of its motor's torque."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import exp, hypot, log, sqrt
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.facts import REPAIR
from tierod.core.graph import scan
from tierod.core.graph.maths import all_of, where
from tierod.core.recording import Recording
from tierod.io.derive import complete
from tierod.methods.filters import Butterworth
from tierod.methods.identification.experiment import Found
from tierod.methods.identification.vehicle import VehicleIdentification, identify_vehicle
from tierod.methods.identification.vehicle_judgement import CONTRADICTION, LEARNT, NARROWED, NOT_SEEN, Judged, spread_of
from tierod.models.steering_column import FrictionParameters
from tierod.monitors.defects import InputDefects
from tierod.monitors.friction.estimator import (
    ROLLING_SPEED,
    Coefficients,
    PreslidingTuning,
    Regressors,
    column_motion,
    reference_load,
    regressors,
)
from tierod.monitors.friction.signals import SAMPLE_TIME, SteeringConditioning, SteeringSample
from tierod.physics.friction import RELAXED, BuildUp, build_ups
from tierod.vehicles import Vehicle
from tierod.vehicles.vehicle import Parameter


class BalanceRow(NamedTuple):
    """One sample of the balance."""

    terms: Regressors  # regressors and torques of the balance, low-passed
    speed: Annotated[Scalar, "m/s"]  # vehicle speed [m/s]
    used: Annotated[Scalar, ""]  # 1 where the vehicle rolls and every signal is present and settled


@dataclass(frozen=True)
class BalanceRows:
    """Regressors of `PreslidingFrictionFilter` for one fixed Dahl angle."""

    parameters: FrictionParameters  # parameters of the vehicle; their `sample_time` is that of the samples
    dahl_angle: Annotated[float, "rad"]  # travel over which friction builds up [rad]
    # gives weight lever, turn slip and drive share, from which the load of the gear is computed
    tuning: PreslidingTuning = field(default_factory=PreslidingTuning)
    conditioning: SteeringConditioning = field(default_factory=SteeringConditioning)  # conditioning of the signals
    cutoff: Annotated[float, "Hz"] = 3.0  # cutoff frequency of the low-pass on both sides [Hz]
    low_pass: Butterworth = field(init=False, repr=False)

    Sample = SteeringSample
    Output = BalanceRow

    class State(NamedTuple):
        conditioning: Any
        finite: BuildUp
        exponential: BuildUp
        long: BuildUp
        low_pass: Any

    def __post_init__(self) -> None:
        low_pass = Butterworth(Regressors, self.conditioning.sample_time, 0.0, self.cutoff)
        object.__setattr__(self, "low_pass", low_pass)

    def init(self) -> State:
        return self.State(self.conditioning.init(), RELAXED, RELAXED, RELAXED, self.low_pass.init())

    def step(self, state: State, sample: SteeringSample) -> tuple[State, BalanceRow]:
        conditioning, clean = self.conditioning.step(state.conditioning, sample)
        column = column_motion(clean, self.parameters.torsion_bar_stiffness, self.conditioning.sample_time)
        laws = build_ups((state.finite, state.exponential, state.long), column.increment, self.dahl_angle)
        load = reference_load(self.parameters, self.tuning.reference_lever)
        rows = regressors(clean, column, laws, self._before, self.parameters, load)
        low_pass, passed = self.low_pass.step(state.low_pass, rows)
        speed = clean.signals.vehicle_speed
        used = where(all_of(speed > ROLLING_SPEED, clean.settled, clean.present), 1.0, 0.0)
        return self.State(conditioning, *laws, low_pass), BalanceRow(passed, speed, used)

    @property
    def _before(self) -> Coefficients:
        """Prior coefficients of the road torques, which determine the load of the gear."""
        tuning = self.tuning
        zero = Coefficients(*(0.0,) * len(Coefficients._fields))
        return zero._replace(
            aligning_gain=1.0,
            weight_lever=tuning.initial_weight_lever,
            turn_slip=tuning.initial_turn_slip,
            drive_share=tuning.initial_drive_share,
        )


NAME = "motor_ratio"
TERMS = (
    *("finite", "exponential", "long", "aligning_torque", "squared_aligning_torque", "weight", "turn_slip", "drive"),
    *("loaded_friction", "rate", "acceleration"),
)
"""Fields of `Regressors` on the side of road, friction and motion."""
SHORTEST, LONGEST, STEPS = 0.006, 0.06, 10
"""Range of the Dahl angle [rad], and number of grid points of the first search."""
STRIDE = 10  # Decimation of the samples: the low-pass leaves nothing faster
MODEL_ERROR = 0.09
"""Relative model error of the balance [-]: root mean square over ten drives of 13 minutes of six virtual cars (seed
77001); 0.03 without the van and the large car, whose gears are loaded more than the balance models."""
LEAST = 300.0  # Least driving time with all signals [s]
PARTS = 5  # Parts of the drives in the jackknife; each is left out once for the standard deviation


class DriveRatio(NamedTuple):
    """Motor ratio identified from drives alone, without the value of the vehicle file."""

    value: Annotated[float, ""]  # turns of the motor per turn of the column [-]
    deviation: Annotated[float, ""]  # standard deviation [-]
    dahl_angle: Annotated[float, "rad"]  # travel over which friction builds up [rad]


class _Balance(NamedTuple):
    """Samples of drives: both torques, terms of the other side, and instruments (terms times functions of speed)."""

    torques: np.ndarray
    terms: np.ndarray
    instruments: np.ndarray


def ratio_of_drives(
    recordings: Mapping[str, Recording], vehicle: Vehicle, progress: Callable[[float], None] = lambda share: None
) -> DriveRatio | None:
    """The motor ratio from drives alone; None where drives or vehicle file lack the data for it."""
    samples = [each for each in map(_samples, recordings.values()) if each is not None]
    if not vehicle.calibrated or not samples:
        return None
    try:
        parameters = replace(vehicle.parameters_for(FrictionParameters), sample_time=SAMPLE_TIME)
    except ParameterError:
        return None
    places = np.linspace(log(SHORTEST), log(LONGEST), STEPS).tolist()
    # A coarse grid in the logarithm of the angle, a finer one around its best point, then a parabola.
    finer = 0.25 * (places[1] - places[0])
    found: dict[float, float] = {}
    for number, place in enumerate(places):
        found[place] = _left(_balance(samples, parameters, exp(place)))
        progress(0.7 * (number + 1) / STEPS)
    best = min(found, key=found.__getitem__)
    near = {best + k * finer: _left(_balance(samples, parameters, exp(best + k * finer))) for k in (-2, -1, 0, 1, 2)}
    progress(0.95)
    angle = exp(_lowest(near, finer))
    balance = _balance(samples, parameters, angle)
    if len(balance.torques) * STRIDE * SAMPLE_TIME < LEAST:
        return None
    return _with_deviation(balance, angle)


def _samples(recording: Recording) -> np.ndarray | None:
    whole = complete(recording, SteeringSample._fields)
    if any(name not in whole for name in SteeringSample._fields):
        return None
    return whole.align(SteeringSample._fields, 1.0 / SAMPLE_TIME, maximum_age=0.1).values


def _balance(samples: Sequence[np.ndarray], parameters: FrictionParameters, angle: float) -> _Balance:
    parts = [_of_drive(each, parameters, angle) for each in samples]
    return _Balance(*(np.concatenate([getattr(each, name) for each in parts]) for name in _Balance._fields))


def _of_drive(samples: np.ndarray, parameters: FrictionParameters, angle: float) -> _Balance:
    result = scan(BalanceRows(parameters, angle), samples)
    used = np.flatnonzero(result["used"] > 0.0)[::STRIDE]
    terms = {name: result[f"terms.{name}"][used] for name in (*TERMS, "driver_torque", "motor_torque")}
    speed = result["speed"][used]
    aligning = terms["aligning_torque"]
    # The aligning torque per lateral force falls slightly with speed, by roll steer and load transfer.
    columns = np.column_stack(
        [*(terms[name] for name in TERMS), aligning**3, aligning * speed / 30.0, np.ones(len(used))]
    )
    shares = (1.0 / (1.0 + speed / 10.0), 1.0 / (1.0 + speed / 25.0), speed / 30.0)
    instruments = np.column_stack([columns, *(columns * share[:, None] for share in shares)])
    return _Balance(np.column_stack([terms["driver_torque"], terms["motor_torque"]]), columns, instruments)


def _ratio(balance: _Balance) -> tuple[float, float]:
    """Ratio, and unexplained share of the driving torque's power [-]; infinite where no ratio closes the balance."""
    own, wide = (_beside(balance.torques, each) for each in (balance.terms, balance.instruments))
    left, explained = own.T @ own, wide.T @ wide
    try:
        # The eigenvector of the smallest ratio of both remainders holds the coefficients of driver and motor torque.
        values, vectors = np.linalg.eig(np.linalg.solve(explained, left))
    except np.linalg.LinAlgError:
        return np.nan, np.inf
    driver, motor = vectors[:, int(np.argmin(values.real))].real
    if not driver * motor > 0.0:
        return np.nan, np.inf
    both = np.array([1.0, motor / driver])
    power = both @ np.cov(balance.torques.T) @ both
    return float(both[1]), float(both @ left @ both / power) / len(balance.torques)


def _beside(torques: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Residual of the torques after projection onto the columns."""
    size = np.linalg.norm(columns, axis=0)
    basis, _ = np.linalg.qr(columns[:, size > 0.0] / size[size > 0.0])
    return np.asarray(torques - basis @ (basis.T @ torques))


def _left(balance: _Balance) -> float:
    return _ratio(balance)[1] if len(balance.torques) > balance.instruments.shape[1] else np.inf


def _lowest(found: Mapping[float, float], step: float) -> float:
    """Minimum of a parabola through the lowest value and its neighbours; the lowest point itself at an end."""
    places = sorted(found)
    at = min(range(len(places)), key=lambda k: found[places[k]])
    if not 0 < at < len(places) - 1:
        return places[at]
    before, here, after = (found[places[at + k]] for k in (-1, 0, 1))
    bend = before - 2.0 * here + after
    return places[at] + (0.5 * step * (before - after) / bend if np.isfinite(bend) and bend > 0.0 else 0.0)


def _with_deviation(balance: _Balance, angle: float) -> DriveRatio | None:
    """The ratio with a standard deviation from the jackknife over parts of the drives and from the model error."""
    value, _ = _ratio(balance)
    part = np.arange(len(balance.torques)) * PARTS // len(balance.torques)
    without = [_ratio(_Balance(*(each[part != k] for each in balance)))[0] for k in range(PARTS)]
    if not np.isfinite([value, *without]).all():
        return None
    spread = float(np.sqrt((PARTS - 1.0) * np.mean(np.square(np.subtract(without, value)))))
    return DriveRatio(value, hypot(spread, MODEL_ERROR * value), angle)


CURE = (
    "record ten minutes of bends at 30 to 120 km/h with driver_torque and motor_torque; better: take it from the data "
    "sheet of the steering gear"
)
TORQUES = ("driver_torque", "motor_torque")
_MOTION = 0.8  # Share of the progress that the identification of the motion takes [-]


def identify_own_car(
    recordings: Mapping[str, Recording],
    vehicle: Vehicle,
    free: tuple[str, ...] = (),
    progress: Callable[[float], None] = lambda share: None,
) -> VehicleIdentification:
    """Most probable parameters of a car, given its vehicle file and its drives.

    Args:
        vehicle: prior knowledge, see `identify_vehicle`
        free: parameters of the motion to be estimated; if none is given, all that drives can identify, and the ratio of
            the motor's torque
        progress: called with the completed share, 0 to 1

    Raises:
        InputError: a recording lacks a signal that is needed
        ParameterError: the vehicle lacks a parameter, or a free parameter is not identifiable from drives
    """
    found = identify_vehicle(recordings, vehicle, free, lambda share: progress(_MOTION * share))
    if free or found.doubt or NAME not in vehicle or not spread_of(NAME, vehicle)[0]:
        return found
    if defects := _defects_of_torques(recordings):
        kept = _judged(vehicle, None)._replace(text=f"not identified: {'; '.join(defects)}; {REPAIR}")
        return dataclasses.replace(found, judged=(*found.judged, kept), remarks=(*found.remarks, *defects))
    seen = ratio_of_drives(recordings, _with(vehicle, found), lambda share: progress(_MOTION + (1 - _MOTION) * share))
    each = _judged(vehicle, seen)
    if each.kind != LEARNT:
        return dataclasses.replace(found, judged=(*found.judged, each))
    before = vehicle.parameters[NAME]
    learnt = Found.normal(NAME, (before.value, before.standard_deviation), each.value, each.deviation, "drives")
    return dataclasses.replace(found, found=(*found.found, learnt), judged=(*found.judged, each))


def _defects_of_torques(recordings: Mapping[str, Recording]) -> list[str]:
    """Sentences on torques that are late or clipped, since these bias the ratio from the balance of torques."""
    found = []
    for name, recording in recordings.items():
        if any(torque not in recording for torque in TORQUES):
            continue
        checks = InputDefects(TORQUES)
        checks.add(recording, *recording.span)
        found += [f"{name}: {each.cause}" for each in checks.found()]
    return found


def _with(vehicle: Vehicle, found: VehicleIdentification) -> Vehicle:
    """Vehicle with the parameters that the motion has identified."""
    learnt = {each.name: each.value for each in found.found if each.name in vehicle}
    parameters = {
        name: dataclasses.replace(each, value=learnt[name]) if name in learnt else each
        for name, each in vehicle.parameters.items()
    }
    return dataclasses.replace(vehicle, parameters=parameters)


def _judged(vehicle: Vehicle, seen: DriveRatio | None) -> Judged:
    """Combination of the values of file and drives, weighted by their inverse variances."""
    before: Parameter = vehicle.parameters[NAME]
    spread = spread_of(NAME, vehicle)[0]
    kept = Judged(
        NAME, NOT_SEEN, before.value, spread, before.value, spread, f"not identifiable from these drives; {CURE}"
    )
    if seen is None:
        return kept
    apart = abs(seen.value - before.value) / sqrt(seen.deviation**2 + spread**2)
    if apart > CONTRADICTION:
        text = f"{seen.value:.3g} ± {seen.deviation:.2g} in these drives, {apart:.1f} σ from the file; {CURE}"
        return kept._replace(text=text)
    weights = spread**-2, seen.deviation**-2
    deviation = 1.0 / sqrt(sum(weights))
    if deviation >= NARROWED * spread:
        return kept
    value = (weights[0] * before.value + weights[1] * seen.value) * deviation**2
    return Judged(NAME, LEARNT, before.value, spread, value, deviation, "")
