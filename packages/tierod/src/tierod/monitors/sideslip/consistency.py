"""Observables that the car of a vehicle file must show in a drive, and their tolerances for fault-free cars."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, NamedTuple

import numpy as np

from tierod.methods.analysis.consistency import lower_gamma
from tierod.monitors.sideslip.observables import WHEELS, Observables, ObservablesOverDrive
from tierod.physics.motion import understeer_gradient
from tierod.vehicles.classes import class_of, moved, typical, with_spread
from tierod.vehicles.vehicle import Vehicle


@dataclass(frozen=True)
class Tolerances:
    """Deviations of fault-free cars from their files: standard deviations added to those of the parameters."""

    # Mean and standard deviation of the logarithm of lateral acceleration over speed times yaw rate; bank makes it
    # smaller, lean larger.
    turn_usual: Annotated[float, ""] = -0.03
    turn: Annotated[float, ""] = 0.05
    # Relative, of wheelbase and steering ratio; the ratio varies with the angle, columns twist.
    wheelbase: Annotated[float, ""] = 0.10
    understeer: Annotated[float, "rad*s**2/m"] = 0.0015  # error of the understeer gradient from nonlinear tyres
    # Least relative standard deviation of a cornering stiffness, which is uncertain on another surface.
    tyres: Annotated[float, ""] = 0.3
    steering_zero: Annotated[float, "rad"] = 0.003  # zero of the road wheels [rad]; 3 degrees at the steering wheel
    # Mean and standard deviation of the accelerometer's place; a delay of some hundredths of a second moves it
    # backwards.
    sensor_usual: Annotated[float, "m"] = -0.2
    sensor: Annotated[float, "m"] = 0.2
    # Standard deviation of the place about the centre of gravity, where the file gives none.
    sensor_forward: Annotated[float, "m"] = 0.3
    track: Annotated[float, ""] = 0.05  # relative, of the rear track; wheel speeds in a turn follow the tyres' centres
    wheel: Annotated[float, ""] = 0.03  # relative, of the radius of the wheels
    gain: Annotated[float, ""] = 0.06  # relative, from slopes and slip
    # Threshold on the squared normalised deviations explained by one hypothesis, 3.2 standard deviations.
    decides: Annotated[float, ""] = 10.0
    file_decides: Annotated[float, ""] = 16.0  # the same threshold for the vehicle file with its four quantities
    left: Annotated[float, ""] = 0.01  # probability below which what the accepted hypothesis leaves is no chance
    alike: Annotated[float, ""] = 4.0  # difference of these up to which two hypotheses cannot be separated
    least: Annotated[float, ""] = 0.08  # relative error of a scale from which it is reported


class Expected(NamedTuple):
    """Expected observables of a vehicle file: values, and standard deviations including the tolerances."""

    values: Observables
    deviations: Observables


def expected(vehicle: Vehicle, tolerances: Tolerances | None = None) -> Expected:
    """Expected observables of a vehicle file."""
    limits = tolerances or Tolerances()
    car, _ = with_spread(vehicle)
    length = car["front_distance"] + car["rear_distance"]
    spread = {name: each.standard_deviation or 0.0 for name, each in car.parameters.items()}
    known = spread.get("wheelbase", math.hypot(spread["front_distance"], spread["rear_distance"]))
    ratio = spread.get("steering_ratio", 0.0) / car["steering_ratio"]
    if "track_width" in car:
        track, track_spread = car["track_width"], spread["track_width"]
    else:
        usual = typical(class_of(car))["track_width"]
        track, track_spread = usual.value, usual.standard_deviation or 0.0
    forward = car["sensor_forward"] if "sensor_forward" in car.parameters else 0.0
    values = Observables(
        turn=limits.turn_usual,
        wheelbase=length,
        understeer=_understeer(car),
        steering_zero=0.0,
        sensor_place=car["rear_distance"] + forward + limits.sensor_usual,
        track=track,
        wheel=0.0,
        gain=0.0,
    )
    deviations = Observables(
        turn=limits.turn,
        wheelbase=length * math.hypot(known / length, ratio, limits.wheelbase),
        understeer=math.hypot(limits.understeer, *_understeer_moves(car, limits)),
        steering_zero=math.hypot(
            limits.steering_zero, car["steering_ratio"] * spread.get("steering_wheel_angle_offset", 0.0)
        ),
        sensor_place=math.hypot(
            limits.sensor, spread["rear_distance"], spread.get("sensor_forward") or limits.sensor_forward
        ),
        track=math.hypot(track_spread, limits.track * track),
        wheel=math.hypot(limits.wheel, spread.get("wheel_speed_scale", 0.0)),
        gain=limits.gain,
    )
    return Expected(values, deviations)


STEERING = ("mass", "front_distance", "rear_distance", "front_cornering_stiffness", "rear_cornering_stiffness")


def _understeer(car: Vehicle) -> float:
    gradient: float = understeer_gradient(*(car[name] for name in STEERING))
    return gradient


def _understeer_moves(car: Vehicle, limits: Tolerances) -> list[float]:
    least = {name: limits.tyres * car[name] for name in STEERING[-2:]}
    wider = {
        name: replace(
            car.parameters[name],
            standard_deviation=max(car.parameters[name].standard_deviation or 0.0, least.get(name, 0.0)),
        )
        for name in STEERING
    }
    car = replace(car, parameters={**car.parameters, **wider})
    return [0.5 * (_understeer(moved(car, {name: 1.0})) - _understeer(moved(car, {name: -1.0}))) for name in STEERING]


# Names of the test statistics in the evidence.
SIGNALS_WEIGHT, FILE_WEIGHT = "contradicting_signals_chi_square", "contradicting_file_chi_square"
FILE = ("wheelbase", "understeer", "sensor_place", "track")  # observables that depend on the vehicle file

REAR_WHEELS = "the rear wheel speeds"

WORDS = {
    "wheelbase": "wheelbase for the file's steering_ratio",
    "understeer": "understeer gradient",
    "sensor_place": "distance of the accelerometer from the rear axle",
    "track": "track of the rear wheels",
}
RESTS_ON = {
    "turn": ("lateral_acceleration", "vehicle_speed", "yaw_rate"),
    "wheelbase": ("vehicle_speed", "yaw_rate", "the steering angle"),
    "understeer": ("vehicle_speed", "yaw_rate", "the steering angle"),
    "steering_zero": ("the steering angle", "yaw_rate"),
    "sensor_place": ("lateral_acceleration", "yaw_rate"),
    "track": (REAR_WHEELS, "yaw_rate"),
    "wheel": ("vehicle_speed", REAR_WHEELS),
    "gain": ("longitudinal_acceleration", "vehicle_speed"),
}
"""Signals from which each observable is determined."""

# Observables that can be wrong by signals alone that hardly affect the sideslip, and these signals.
BESIDE = {"track": (REAR_WHEELS,), "wheel": (REAR_WHEELS,), "gain": ("longitudinal_acceleration",)}
# Signals that an offset shifts like a scale, and the observable that it leaves, as that rests on their changes.
OFFSET_LEAVES = {"vehicle_speed": "gain", REAR_WHEELS: "track"}
DEVIATES = 1.5  # standard deviations from which an observable belongs to a contradiction

CONTRADICTION = "signals and vehicle file contradict each other"

UNITS = {"wheelbase": "m", "understeer": "mrad·s²/m", "sensor_place": "m", "track": "m"}
DECIMALS = {"wheelbase": 2, "understeer": 1, "sensor_place": 1, "track": 2}

# Signal and ratio cannot be separated: both make the file's wheelbase seem too short where they are too large.
STEERED = "steering_wheel_angle or steering_ratio, or inversely wheelbase"
# Bounds on the logarithm of a scale. Above the first the linear model gives no value: another unit, or a wrong sign. No
# mistaken unit exceeds the second, so that no scale explains the deviation.
STATED, LARGEST = math.log(10.0), math.log(1e3)


@dataclass(frozen=True)
class Explanation:
    """One hypothesis about what is wrong."""

    name: str  # name of the signal or the parameters
    weight: float  # reduction of the squared normalised deviations by the hypothesis
    size: float  # natural logarithm of the scale; in rad for a zero; for the track, its deviation over the file's value
    deviation: float  # standard deviation of the size
    zero: bool = False  # whether the hypothesis is a wrong zero
    words: str = ""  # text for messages, where it is neither scale nor zero

    def __str__(self) -> str:
        if self.words:
            return self.words
        if self.zero:
            degrees = math.degrees(self.size), math.degrees(self.deviation)
            return f"zero of {self.name}: road wheels straight at {degrees[0]:+.2f} ± {degrees[1]:.2f} degrees"
        if abs(self.size) > STATED:
            return f"{self.name} (far from its right scale, or its sign is wrong)"
        return (
            f"{self.name} ({math.exp(self.size):.2f} ± {math.exp(self.size) * self.deviation:.2f} times the right "
            "value)"
        )


@dataclass(frozen=True)
class Consistency:
    """Deviations of a drive from its vehicle file, and the hypotheses that explain them."""

    shown: Observables  # observables of the drive
    noise: np.ndarray  # covariance of these
    expected: Expected  # values expected by the file
    limits: Tolerances  # tolerances and thresholds
    # Zero of the steering angle that an offset of the yaw rate imitates, per offset [s]; NaN if unknown.
    lever: Annotated[float, "s"] = math.nan

    @cached_property
    def _known(self) -> np.ndarray:
        return np.asarray(np.isfinite(np.array(self.shown)))

    @cached_property
    def _off(self) -> np.ndarray:
        return np.asarray((np.array(self.shown) - np.array(self.expected.values))[self._known])

    @cached_property
    def _weights(self) -> np.ndarray:
        at = np.flatnonzero(self._known)
        own = self.noise[np.ix_(at, at)] + np.diag(np.array(self.expected.deviations)[at] ** 2)
        return np.asarray(np.linalg.inv(own))

    def deviations(self) -> dict[str, float]:
        """Deviation of every observable that the drive determines, in standard deviations."""
        sizes = np.sqrt(np.diag(np.linalg.inv(self._weights))) if self._names else []
        return {name: float(off / size) for name, off, size in zip(self._names, self._off, sizes, strict=True)}

    @cached_property
    def explanations(self) -> tuple[Explanation, ...]:
        """Every single-fault hypothesis, the most likely first."""
        wheelbase, place, track = (self._scalable(name) for name in ("wheelbase", "sensor_place", "track"))
        understeer = self.shown.understeer if wheelbase else 0.0
        effects: dict[str, Mapping[str, float]] = {
            "yaw_rate": {
                "turn": -1.0,
                "wheelbase": -wheelbase,
                "understeer": -understeer,
                "sensor_place": -place,
                "track": -track,
            },
            "vehicle_speed": {
                "turn": -1.0,
                "wheelbase": wheelbase,
                "understeer": -understeer,
                "wheel": 1.0,
                "gain": 1.0,
            },
            "lateral_acceleration": {"turn": 1.0, "sensor_place": place},
            "longitudinal_acceleration": {"gain": -1.0},
            STEERED: {"wheelbase": wheelbase, "understeer": understeer},
            REAR_WHEELS: {"wheel": -1.0, "track": track},
        }
        scales = {name: self._explained(name, effect) for name, effect in effects.items()}
        scales[REAR_WHEELS] = _of_one_or_both(scales[REAR_WHEELS])
        for name, left in OFFSET_LEAVES.items():
            offset = self._explained(name, {**effects[name], left: 0.0})
            if offset.weight > scales[name].weight + self.limits.alike:
                scales[name] = replace(offset, words=f"offset of {offset}")
            elif offset.weight > scales[name].weight - self.limits.alike:
                scales[name] = replace(scales[name], words=f"{str(scales[name])[:-1]}, or an offset)")
        found = [each if abs(each.size) < LARGEST else replace(each, weight=0.0, size=0.0) for each in scales.values()]
        found += [self._explained("the steering angle", {"steering_zero": 1.0}, zero=True), *self._yaw_rate_offset()]
        of_track = self._explained("track_width", {"track": self.expected.values.track})
        named = "track_width" if track else "track_width, or wheel speeds left and right that are alike or exchanged"
        found.append(replace(of_track, words=f"{named} ({self._beside('track')})"))
        return tuple(sorted(found, key=lambda each: -each.weight))

    def _yaw_rate_offset(self) -> list[Explanation]:
        if not self.lever > 0.0:
            return []
        found = self._explained("yaw_rate", {"steering_zero": -self.lever}, zero=True)
        size, deviation = math.degrees(found.size), math.degrees(found.deviation)
        return [replace(found, words=f"offset of the yaw rate: {size:+.1f} ± {deviation:.1f} degrees per second")]

    def _scalable(self, name: str) -> float:
        shown, given = getattr(self.shown, name), getattr(self.expected.values, name)
        return float(shown) if shown * given > 0.0 else 0.0

    def _explained(self, name: str, effect: Mapping[str, float], zero: bool = False) -> Explanation:
        along = np.array([effect.get(each, 0.0) for each in self.shown._fields])[self._known]
        information = float(along @ self._weights @ along)
        if not information > 0.0:
            return Explanation(name, 0.0, 0.0, math.inf, zero)
        size = float(along @ self._weights @ self._off) / information
        return Explanation(name, size * size * information, size, information**-0.5, zero)

    @cached_property
    def _names(self) -> tuple[str, ...]:
        return tuple(name for name, known in zip(self.shown._fields, self._known, strict=True) if known)

    def file_weight(self) -> float:
        """Reduction of the squared normalised deviations by a vehicle file of another car."""
        return self._free(FILE)[0]

    def _free(self, free: Iterable[str]) -> tuple[float, int]:
        """Reduction of the squared normalised deviations where these observables are free, and their number."""
        along = np.array([[float(name == each) for name in self._names] for each in free if each in self._names])
        if not len(along):
            return 0.0, 0
        information = along @ self._weights @ along.T
        right = along @ self._weights @ self._off
        return float(right @ np.linalg.solve(information, right)), len(along)

    def _leaves(self, explained: float, freedom: int) -> bool:
        """Whether a hypothesis leaves more of the squared normalised deviations than chance does."""
        rest, number = float(self._off @ self._weights @ self._off) - explained, len(self._names) - freedom
        return number > 0 and 1.0 - lower_gamma(0.5 * number, 0.5 * rest) < self.limits.left

    def evidence(self) -> dict[str, float]:
        """Test statistics of the best single-fault hypothesis and of another vehicle file, with the observables."""
        shown = {f"shown_{name}": value for name, value in self.shown._asdict().items() if math.isfinite(value)}
        return {SIGNALS_WEIGHT: self.explanations[0].weight, FILE_WEIGHT: self.file_weight(), **shown}

    def wrong(self) -> Wrong | None:
        """The accepted hypothesis; None where all agrees."""
        limits = self.limits
        best, *others = self.explanations
        of_file, freedom = self._free(FILE)
        single = best.weight > limits.decides and (best.zero or abs(best.size) > limits.least)
        of_another_car = of_file > limits.file_decides and of_file > best.weight + 2.0 * limits.alike
        if not (single or of_another_car):
            return None
        if self._leaves(*((of_file, freedom) if of_another_car else (best.weight, 1))):
            return self._of_several()
        if of_another_car:
            other = f"; or {best}" if single else ""
            return Wrong((), f"{self._of_file()}{other}", "the vehicle file does not fit this car")
        alike = [each for each in others if each.weight > best.weight - limits.alike]
        named = (best, *(each for each in alike if (best.zero if each.zero else abs(each.size) > limits.least)))
        names = tuple(name for each in named for name in _signals(each.name))
        sentence = " or ".join(str(each) for each in named)
        reason = f"{names[0]} contradicts the vehicle file" if len(set(names)) == 1 else CONTRADICTION
        return Wrong(names, f"{CONTRADICTION}: {sentence}", reason)

    def _of_several(self) -> Wrong:
        off = [name for name, each in self.deviations().items() if abs(each) > DEVIATES] or self._names
        rests_on = RESTS_ON if BESIDE.keys().isdisjoint(off) or self._leaves(*self._free(BESIDE)) else BESIDE
        signals = tuple(dict.fromkeys(signal for name in off for signal in rests_on.get(name, ())))
        sentence = (
            f"{CONTRADICTION}, and no wrong scale, zero or file alone explains it: more than one of "
            f"{', '.join(signals)} is wrong, or one of them is late or changes over the drive"
        )
        names = tuple(name for signal in signals for name in _signals(signal))
        return Wrong(names, sentence, CONTRADICTION, several=True)

    def _of_file(self) -> str:
        off = {name: each for name, each in self.deviations().items() if name in FILE}
        named = sorted(off, key=lambda name: -abs(off[name]))
        named = [name for name in named if abs(off[name]) > DEVIATES][:3] or named[:1]
        signals = dict.fromkeys(signal for name in named for signal in RESTS_ON[name])
        return (
            f"the vehicle file does not fit this car, or one of {', '.join(signals)} is wrong: "
            f"{'; '.join(self._beside(name) for name in named)}"
        )

    def _beside(self, name: str) -> str:
        factor = 1e3 if name == "understeer" else 1.0
        seen, given = (factor * getattr(each, name) for each in (self.shown, self.expected.values))
        digits = DECIMALS[name]
        late = (given - seen) / USUAL_SLOW_SPEED
        if name == "sensor_place" and abs(late) > LATE:
            one, other = ("lateral_acceleration", "yaw_rate") if late > 0.0 else ("yaw_rate", "lateral_acceleration")
            return f"{self._seen(name, seen, given, digits)}, or {one} is {abs(late):.2f} s late relative to {other}"
        return self._seen(name, seen, given, digits, factor)

    def _seen(self, name: str, seen: float, given: float, digits: int, factor: float = 1.0) -> str:
        own = self.expected.deviations
        return (
            f"{WORDS[name]} {seen:.{digits}f} {UNITS[name]} in the drive, {given:.{digits}f} ± "
            f"{factor * getattr(own, name):.{digits}f} expected"
        )


class Wrong(NamedTuple):
    """Disagreeing signals, none where it is the file alone; a sentence; a reason; whether no hypothesis explains it."""

    names: tuple[str, ...]
    sentence: str
    reason: str
    several: bool = False

    @property
    def decisive(self) -> bool:
        """Whether the sideslip depends on them."""
        return not self.names or any(name not in UNUSED for name in self.names)


# Speed at which the accelerometer's place is observed [m/s], and a delay that imitates it [s].
USUAL_SLOW_SPEED, LATE = 6.5, 0.1
UNUSED = ("longitudinal_acceleration", "track_width", *WHEELS)  # signals and parameters that hardly affect the sideslip


def _of_one_or_both(wheels: Explanation) -> Explanation:
    """A wrong scale of both rear wheel speeds: one of them alone shifts their mean and the track by half its error."""
    alone = 2.0 * math.exp(wheels.size) - 1.0 if abs(wheels.size) < STATED else 0.0
    return replace(wheels, words=f"{str(wheels)[:-1]}, or one of them {alone:.2f} times)") if alone > 0.0 else wheels


def _signals(name: str) -> tuple[str, ...]:
    if REAR_WHEELS in name:
        return WHEELS
    return ("steering_wheel_angle",) if name.startswith(("steering", "the steering")) else (name,)


def consistency_of(
    drive: ObservablesOverDrive, vehicle: Vehicle, limits: Tolerances, yaw_rate_offset: float = 0.0
) -> Consistency:
    """Consistency of a drive with a vehicle file.

    Args:
        yaw_rate_offset: offset identified elsewhere [rad/s]; the zero of the steering angle that it imitates is
            removed
    """
    shown, noise = drive.found()
    lever = drive.lever(shown.wheelbase, shown.understeer)
    shown = shown._replace(steering_zero=shown.steering_zero + lever * yaw_rate_offset)
    return Consistency(shown, noise, expected(vehicle, limits), limits, lever)
