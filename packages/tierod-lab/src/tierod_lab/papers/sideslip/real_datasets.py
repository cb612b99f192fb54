"""Two real cars with a reference of the sideslip and without a steering torque: race laps and a car park."""

from __future__ import annotations

import dataclasses
import itertools
import math
from dataclasses import dataclass

import numpy as np

from tierod.core.recording import Recording
from tierod.monitors.sideslip.tuning import BAND
from tierod.vehicles import Vehicle, load
from tierod_lab.papers import real_data
from tierod_lab.papers.sideslip.calibration import TYRES, BesideTruth, beside_truth, calibrated, with_parameters
from tierod_lab.papers.sideslip.noise_calibration import calibrated_with_noises, with_noises
from tierod_lab.papers.sideslip.typical_cars import (
    PASSENGER,
    SIMPLE,
    SPORTS,
    Class,
    geometric,
    leaky,
    linear,
    measured_wrong,
    nothing,
    typical,
)
from tierod_lab.studies.metrics import Row


@dataclass(frozen=True)
class RealCar:
    """A real car with its recording."""

    file: tuple[str, str]  # folder and file of the recording
    vehicle: str  # vehicle file that was fitted to it
    kind: Class  # class of the car
    rate: float  # sampling rate [Hz]
    unfitted: float  # time at the start that is not judged without a fit [s]

    def recording(self) -> Recording | None:
        """The recording; None where it or the library of its reader is missing."""
        return real_data.recorded(*self.file, channel_map=load(self.vehicle).channel_map)


RACE = RealCar(("ferrari_250lm_race", "laps.parquet"), "ferrari-250lm", SPORTS, 100.0, 110.0)
PARK = RealCar(("revsted_slip_angle", "obd.csv"), "revsted-car", PASSENGER, 50.0, 1.0)
CARS = {"race laps": RACE, "passenger car": PARK}
"""The cars. The first 110 s of the laps, two of five blocks, are not judged without a fit: the default noises were
chosen in view of them."""
LAPS_FITTED, PARK_FITTED = 0.6, 5.0
"""Share of the laps [-], and time in the car park [s], to which parameters were fitted; the rest is judged."""


def _row(seen: BesideTruth, start: float, **more: str) -> dict[str, float | str | bool]:
    found = seen.figures(start)
    return {
        **more,
        "mean": math.degrees(found.mean_absolute),
        "rms": math.degrees(found.rms),
        "covered": found.coverage if seen.result is not None else math.nan,
    }


def fitted_until(recording: Recording) -> float:
    """End of the part of the laps to which parameters were fitted [s]."""
    first, last = recording["sideslip_angle"].time[[0, -1]].tolist()
    return float(first + LAPS_FITTED * (last - first))


def race_laps(wrong: bool) -> list[Row]:
    """A Ferrari 250 LM in a race, 275 s, beside an inertial navigation system that wanders by some 0.14 degrees.

    Tyres, noises, place of the accelerometer, and the zeros of steering sensor and INS were fitted to the first 60 %;
    the last 40 % are judged. Then one stiffness at a time is wrong by a fifth.
    """
    laps = RACE.recording()
    if laps is None:
        return []
    car, until = load(RACE.vehicle), fitted_until(laps)
    fixed = fixed_tyres(laps, car, until)
    found = {
        "sideslip of zero": nothing(laps),
        "integral with a leak of 1.5 s": leaky(laps, until),
        "linear Kalman filter, fixed stiffness": linear(laps, car, until),
        "combined, stiffness not followed": beside_truth(laps, fixed),
        "combined": beside_truth(laps, car),
    }
    rows: list[Row] = [_row(each, until, estimator=name, wrong="") for name, each in found.items()]
    for axle, factor in itertools.product(("front", "rear"), (1.2, 0.8)) if wrong else ():
        name = f"{axle}_cornering_stiffness"
        seen = beside_truth(laps, with_parameters(car, {name: factor * car[name]}))
        rows.append(_row(seen, until, estimator="combined", wrong=f"{axle} {100.0 * (factor - 1.0):+.0f} %"))
    return rows


def fixed_tyres(laps: Recording, car: Vehicle, until: float) -> Vehicle:
    """The car with constant tyre parameters, fitted to the first part of the laps."""
    settled = beside_truth(laps, car).result
    assert settled is not None
    early = settled.values[: round(len(settled.values) * LAPS_FITTED)]
    values = {"stiffness_wander": 0.0}
    for axle in ("front", "rear"):
        share = float(np.median(early[:, settled.names.index(f"estimate.{axle}_stiffness")]))
        values[f"{axle}_cornering_stiffness"] = share * car[f"{axle}_cornering_stiffness"]
    return calibrated(laps, with_parameters(car, values), TYRES, until)


NOISES = (
    "yaw_rate_noise",
    "yaw_rate_drift",
    "lateral_acceleration_noise",
    "lateral_acceleration_wander",
    "lateral_acceleration_wander_time",
    "lateral_speed_drift",
)
"""Noise parameters that are taken from the vehicle file of the race car."""
TRIED = ("yaw_rate_drift", "lateral_acceleration_noise", "lateral_speed_drift", "road_wheel_angle_wander")
"""Noise parameters that are tried at half, once and twice their value."""


def car_park(task: None) -> list[Row]:
    """A passenger car at 9 to 35 km/h beside an optical sensor that is 40 ms late and scatters by 0.1 degrees.

    Steering ratio, its zero and place of the sensor are from the first 5 s; the other 15 s are judged. At this speed
    sideslip is geometry, whatever the tyres. The noises of this car's own file were chosen with the whole recording in
    view, so that those of the race car are judged, of 81 settings about them the best on the first 5 s.
    """
    drive = PARK.recording()
    if drive is None:
        return []
    car, until = load(PARK.vehicle), float(drive["yaw_rate"].time[0]) + PARK_FITTED
    other = with_parameters(car, {name: load(RACE.vehicle)[name] for name in NOISES}, f"of {RACE.vehicle}")
    tried = _scaled(other)
    early = [beside_truth(drive, each, PARK.rate).figures(stop=until).rms for each in tried]
    found = {
        "sideslip of zero": nothing(drive),
        "geometry, gyroscope": geometric(drive, until),
        "combined": beside_truth(drive, tried[int(np.argmin(early))], PARK.rate),
        "combined, noises of the race car as they are": beside_truth(drive, other, PARK.rate),
        "combined, noises of this car's file": beside_truth(drive, car, PARK.rate),
    }
    return [_row(each, until, estimator=name) for name, each in found.items()]


def _scaled(car: Vehicle) -> tuple[Vehicle, ...]:
    made = []
    for factors in itertools.product((0.5, 1.0, 2.0), repeat=len(TRIED)):
        values = {name: factor * car[name] for name, factor in zip(TRIED, factors, strict=True)}
        made.append(with_parameters(car, values, "tried"))
    return tuple(made)


def unprepared(name: str) -> list[Row]:
    """Mass and distances as tape and scale give them, tyres typical of the class, default noises, no reference.

    Corners: with errors of 3 cm and 3 %. Parameters are taken as exact here, so that the band lacks their spread.
    """
    each = CARS[name]
    recording = each.recording()
    if recording is None:
        return []
    car, start = load(each.vehicle), recording.span[0] + each.unfitted
    cars = measured_wrong(car, each.kind)
    simple = {key: estimate(recording, cars[0], each.rate) for key, estimate in SIMPLE.items()}
    fitted = beside_truth(recording, car, each.rate)
    best = min(other.figures(start).rms for other in simple.values())
    rows = [_row(other, start, car=name, estimate=key) for key, other in simple.items()]
    rows.append(_row(fitted, start, car=name, estimate="fitted vehicle file"))
    for place, drawn in enumerate(cars):
        seen = beside_truth(recording, drawn, each.rate)
        own = seen.figures(start).rms
        row = _row(seen, start, car=name, estimate="corner" if place else "typical")
        rows.append(row | {"over_fitted": own / fitted.figures(start).rms, "over_simple": own / best})
    return list(rows)


BLOCKS = 5
FITTED = (*TYRES, "sensor_forward", "roll_share")  # Parameters that are fitted beside the noises
SPREADS = {
    "front_cornering_stiffness": 0.3,
    "rear_cornering_stiffness": 0.3,
    "tyre_friction": 0.15,
    "rear_friction_ratio": 0.1,
}
"""Relative standard deviations of the typical values [-]."""
PLACED = {"rear_friction_ratio": (1.0, 0.1), "sensor_forward": (0.0, 0.3), "roll_share": (0.05, 0.02)}
"""Value and standard deviation of parameters for which the class of the car has no typical value; assumed."""
STRATA = {"speed": (0.0, 25.0, 42.0, math.inf), "angle": (*(math.radians(x) for x in (0.0, 0.5, 1.0, 3.0)), math.inf)}
"""Bounds of the strata of speed [m/s] and of sideslip angle [rad]."""


def blocks(number: int) -> list[Row]:
    """Race laps in blocks of 55 s, each estimated with a vehicle file that was made of the blocks before it alone.

    The file begins with typical tyres; tyres and noises are fitted to the reference.
    """
    laps = RACE.recording()
    if laps is None:
        return []
    first, last = laps["sideslip_angle"].time[[0, -1]]
    limits = np.linspace(first, last, BLOCKS + 1)
    before = laps.slice(float(limits[0]), float(limits[number - 1]))
    seen = beside_truth(laps, calibrated_with_noises(before, unfitted(load(RACE.vehicle)), FITTED))
    kept = (seen.time >= limits[number - 1]) & (seen.time < limits[number]) & np.isfinite(seen.error)
    error, inside = np.degrees(seen.error[kept]), np.abs(seen.error[kept]) <= BAND * seen.deviation[kept]
    speed = np.interp(seen.time[kept], laps["vehicle_speed"].time, laps["vehicle_speed"].values)
    rows: list[Row] = [
        {
            "block": number,
            "stratum": "all",
            "mean": float(np.mean(np.abs(error))),
            "rms": float(np.sqrt(np.mean(error**2))),
            "samples": len(error),
            "inside": float(inside.sum()),
        }
    ]
    for what, values in (("speed", speed), ("angle", np.abs(seen.truth[kept]))):
        for low, high in itertools.pairwise(STRATA[what]):
            part = (values >= low) & (values < high)
            name = f"{what} from {low:.3g}"
            counts = {"samples": float(part.sum()), "inside": float(inside[part].sum())}
            rows += [{"block": number, "stratum": name, **counts}] if part.any() else []
    return rows


def unfitted(car: Vehicle) -> Vehicle:
    """The race car with typical tyres and the prior standard deviations that a fit needs."""
    found = typical(car, SPORTS)
    parameters = dict(found.parameters)
    placed = with_noises(found, {name: value for name, (value, _) in PLACED.items()}, "assumed").parameters
    for name, (_, spread) in PLACED.items():
        parameters[name] = dataclasses.replace(placed[name], standard_deviation=spread)
    for name, share in SPREADS.items():
        each = parameters[name]
        parameters[name] = dataclasses.replace(each, standard_deviation=share * each.value)
    return dataclasses.replace(found, parameters=parameters)
