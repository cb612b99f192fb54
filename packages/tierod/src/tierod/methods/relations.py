"""Relations between the signals of a car: which signals follow which, and what a fault-free car shows.

One table serves the proposal of channel maps (units and signs), the inspection of a recording (signs and units), and
the checks of a monitor's inputs (delay and scale): see `RELATIONS`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Annotated

import numpy as np

from tierod.methods.detectors.reversing import STEERING_RATIO, WHEELBASE
from tierod.methods.running import Moments

CHARACTERISTIC_SPEED = 22.0  # of a usual car [m/s], at which understeer halves the yaw rate of the neutral-steer car
TRACK = 1.5  # of a usual car [m]
EARLY = 0.15  # lead of lateral acceleration over yaw rate times speed in fault-free cars [s]; virtual cars: up to 0.08
REAR_DISTANCE = 1.5  # of the accelerometer from the rear axle in a usual car [m]
Signals = Mapping[str, np.ndarray]
Pair = tuple[str, str]


@dataclass(frozen=True)
class Relation:
    """Two quantities of which the second follows the first, with their fault-free limits."""

    # Signals of each quantity; a delay is attributed to the first one of them, or the others are wrong, as a speed that
    # is another signal shifts its product with the yaw rate.
    first: tuple[str, ...]
    second: tuple[str, ...]
    words: tuple[str, str]  # second and first quantity, for messages
    quantities: Callable[[Signals, float], tuple[np.ndarray, np.ndarray]]  # of the signals (n,) and their rate [Hz]
    smallest: float = inf  # least root mean square of the first quantity's change in 0.4 s for a check over a drive
    earliest: Annotated[float, "s"] = -inf  # bounds of the second quantity's delay in fault-free cars with slow buses
    latest: Annotated[float, "s"] = inf
    gain: float = inf  # factor by which the ratio of second to first may differ from 1
    slowest: Annotated[float, "m/s"] = 0.0  # least vehicle_speed of the samples whose delay is compared
    # Exponents with which the units of the signals enter the ratio, and standard deviation of its logarithm over cars.
    powers: Mapping[str, int] = field(default_factory=dict)
    spread: float = inf

    @property
    def usual(self) -> float:
        """Delay of a usual fault-free car [s]: the middle of the bounds."""
        return 0.5 * (self.earliest + self.latest)

    @property
    def usual_deviation(self) -> float:
        """Standard deviation of that delay between cars [s]: the bounds are taken as two of them away."""
        return 0.25 * (self.latest - self.earliest)

    @property
    def signals(self) -> frozenset[str]:
        return frozenset((*self.first, *self.second))


def _usual_yaw(signals: Signals, road_wheels: np.ndarray) -> np.ndarray:
    """Yaw rate of a usual car at an angle of its road wheels [rad/s]."""
    speed = signals["vehicle_speed"]
    return np.asarray(road_wheels * speed / (WHEELBASE * (1.0 + (speed / CHARACTERISTIC_SPEED) ** 2)))


def _steered(signals: Signals) -> np.ndarray:
    return _usual_yaw(signals, STEERING_RATIO * signals["steering_wheel_angle"])


def _averaged(values: np.ndarray, rate: float) -> np.ndarray:
    """Mean over 0.2 s: an angle that is held at 20 Hz changes in steps, which would make the ratio to it too small."""
    width = round(0.2 * rate) + 1
    return np.convolve(values, np.full(width, 1.0 / width), mode="same")


def _rates(signals: Signals, rate: float) -> tuple[np.ndarray, np.ndarray]:
    change = np.gradient(signals["steering_wheel_angle"]) * rate
    return _averaged(change, rate), _averaged(signals["steering_wheel_rate"], rate)


def _turn(signals: Signals, rate: float) -> tuple[np.ndarray, np.ndarray]:
    return signals["vehicle_speed"] * signals["yaw_rate"], signals["lateral_acceleration"]


_PER_STEERED = STEERING_RATIO / WHEELBASE  # of the thresholds on the angle times speed [1/m]

# Relations by name. Limits are about twice what 18 fault-free virtual drives and the real recordings show.
RELATIONS: dict[str, Relation] = {
    # A derived rate lags by 25 ms, and one that is held at 20 Hz by another 25 ms.
    "steering": Relation(
        ("steering_wheel_angle",), ("steering_wheel_rate",),
        ("steering_wheel_rate", "the change of steering_wheel_angle"), _rates, 0.05, -0.06, 0.06, 1.35,
        powers={"steering_wheel_rate": 1, "steering_wheel_angle": -1}, spread=0.25,
    ),
    # Gains are 0.91 to 0.99 with roll and bank.
    "turn": Relation(
        ("yaw_rate", "vehicle_speed"), ("lateral_acceleration",),
        ("lateral_acceleration", "yaw_rate times vehicle_speed"), _turn, 0.15, gain=1.5,
        powers={"lateral_acceleration": 1, "vehicle_speed": -1, "yaw_rate": -1}, spread=0.35,
    ),
    # Delays are -79 to 92 ms in virtual cars and 119 ms in a real racing car. With v_y = rear_distance * yaw_rate at
    # the accelerometer, a = v r + dv_y/dt leads v r by rear_distance / v, hence the least speed.
    "fast turn": Relation(
        ("yaw_rate", "vehicle_speed"), ("lateral_acceleration",),
        ("lateral_acceleration", "yaw_rate times vehicle_speed"), _turn, 0.15, -EARLY, 0.2,
        slowest=REAR_DISTANCE / EARLY,
    ),
    # Delays are 6 to 115 ms in 21 virtual cars and a racing car; a soft car on the motorway may need half as much
    # again.
    "car": Relation(
        ("steering_wheel_angle", "vehicle_speed"), ("yaw_rate",), ("yaw_rate", "steering_wheel_angle"),
        lambda signals, _: (_steered(signals), signals["yaw_rate"]), 0.3 * _PER_STEERED, -0.05, 0.18,
        powers={"yaw_rate": 1, "vehicle_speed": -1, "steering_wheel_angle": -1}, spread=0.4,
    ),
    "road": Relation(
        ("road_wheel_angle", "vehicle_speed"), ("yaw_rate",), ("yaw_rate", "road_wheel_angle"),
        lambda signals, _: (_usual_yaw(signals, signals["road_wheel_angle"]), signals["yaw_rate"]), 0.02 / WHEELBASE,
        -0.05, 0.18,
    ),
    # Delays are -30 to 0 ms, as active return and damping act on the motor alone; messages add up to 20 ms, a period.
    "assist": Relation(
        ("driver_torque",), ("motor_torque",), ("motor_torque", "driver_torque"),
        lambda signals, _: (signals["driver_torque"], signals["motor_torque"]), 0.3, -0.06, 0.06,
    ),
    "bend": Relation(
        ("steering_wheel_angle", "vehicle_speed"), ("lateral_acceleration",),
        ("lateral_acceleration", "steering_wheel_angle"),
        lambda signals, _: (_steered(signals) * signals["vehicle_speed"], signals["lateral_acceleration"]),
        powers={"lateral_acceleration": 1, "vehicle_speed": -2, "steering_wheel_angle": -1}, spread=0.45,
    ),
    "wheels": Relation(
        ("yaw_rate",), ("wheel_speed_left", "wheel_speed_right"),
        ("difference of the wheel speeds", "track times yaw rate"),
        lambda s, _: (TRACK * s["yaw_rate"], s["wheel_speed_right"] - s["wheel_speed_left"]),
        powers={"vehicle_speed": 1, "yaw_rate": -1}, spread=0.35,
    ),
    "braking": Relation(
        ("vehicle_speed",), ("longitudinal_acceleration",), ("longitudinal acceleration", "change of speed"),
        lambda s, rate: (np.gradient(s["vehicle_speed"]) * rate, s["longitudinal_acceleration"]),
        powers={"longitudinal_acceleration": 1, "vehicle_speed": -1}, spread=0.35,
    ),
}  # fmt: skip

CORRELATION = 0.8  # from which a gain is compared with its limit [-]; fault-free drives show 0.93 and more
FOLLOWS = (
    0.5  # of the changes, from which a delay is compared with its limits [-]; fault-free drives show 0.66 and more
)
CERTAIN = 3.0  # standard deviations by which a delay must exceed its limit to count [-]
STRONG = 0.6  # least magnitude of the correlation from which signals count as related, or as contradicting [-]
WRONG_SIGN_SHARE = 0.9  # of opposed driver and motor torques, from which a wrong sign is likelier than lane keeping [-]


def related(name: str, signals: Signals, rate: float, least: Annotated[float, "s"] = 5.0) -> Moments | None:
    """Moments of both quantities of a relation; None without its signals, or with less time in common.

    Args: signals: by name, (n,) each; NaN where missing; rate: sampling rate [Hz].
    """
    relation = RELATIONS[name]
    if not all(each in signals and len(signals[each]) > 1 for each in relation.signals):
        return None
    return compared(*relation.quantities(signals, rate), least * rate)


def compared(first: np.ndarray, second: np.ndarray, fewest: float = 0.0) -> Moments | None:
    """Moments of two quantities, (n,) each; None with fewer samples at which both are known."""
    found = Moments().add(first, second)
    return found if found.count >= max(fewest, 1.0) else None


def odd_ones_out(names: Iterable[str], agreement: Mapping[Pair, bool]) -> tuple[str, ...]:
    """Signal that contradicts the others; several if they are not isolable from each other, none if all agree.

    Args: agreement: whether a pair agrees; pairs without enough information are left out.
    """
    names = tuple(names)
    against = [pair for pair, agrees in agreement.items() if not agrees]
    with_ = [pair for pair, agrees in agreement.items() if agrees]
    if not against:
        return ()
    suspects = [name for name in names if all(name in pair for pair in against)]
    cleared = [name for name in suspects if not any(name in pair for pair in with_)]
    return tuple(cleared or suspects or names)


# What follows serves signals that are stuck: pairs by which one reveals that the other one should have moved.

SPEEDS = ("vehicle_speed", *(f"wheel_speed_{end}_{side}" for end in ("front", "rear") for side in ("left", "right")))
# (rate, angle) pairs: the rate is the derivative of the angle
RATES = (
    ("steering_wheel_rate", "steering_wheel_angle"),
    ("pinion_rate", "pinion_angle"),
    ("motor_speed", "motor_angle_mechanical"),
)
TURN = ("lateral_acceleration", "yaw_rate", "vehicle_speed")  # the first is about the product of the other two
STEERED = ("steering_wheel_angle", "road_wheel_angle")  # cannot rest while the car turns to one side and the other
# (signal, others): speeds that differ only by slip and the radius of the turn. One of the others may slip, so that the
# nearest one is compared.
SAME_SPEED = (
    ("vehicle_speed", SPEEDS[1:]),
    *((f"wheel_speed_{end}_left", ("vehicle_speed", f"wheel_speed_{end}_right")) for end in ("front", "rear")),
    *((f"wheel_speed_{end}_right", ("vehicle_speed", f"wheel_speed_{end}_left")) for end in ("front", "rear")),
)
# (signal, other, share): the signal cannot rest while the other changes by this share of the range that it has shown
# so far. The torques need a large share: assist has a dead band, and a lane keeping motor turns a wheel without hands.
FOLLOWED = (
    ("driver_torque", "motor_torque", 0.4),
    ("motor_torque", "driver_torque", 0.4),
    ("motor_torque", "motor_target_torque", 0.3),
    ("steering_wheel_angle", "motor_angle_mechanical", 0.05),
    ("steering_wheel_angle", "road_wheel_angle", 0.1),
    ("road_wheel_angle", "steering_wheel_angle", 0.1),
    ("motor_angle_mechanical", "steering_wheel_angle", 0.05),
    ("steering_shaft_torque", "tie_rod_force", 0.4),
    ("tie_rod_force", "steering_shaft_torque", 0.4),
)
ORDERED = ("target", "truth", "lane_keeping", "duty_cycle")  # parts of names of requests and of what no sensor measures
# Parts of the names of signals of motion: without a recorded speed these may rest however much forces fluctuate.
MOVED = ("angle", "rate", "position", "speed", "twist")


def witnesses(names: Sequence[str]) -> tuple[str, ...]:
    """Further signals that can reveal that one of these is stuck."""
    found: dict[str, None] = {}
    speeds = ((name, *others) for name, others in SAME_SPEED if name in names)
    pairs = (pair for pair in (*RATES, *(entry[:2] for entry in FOLLOWED)) if any(name in names for name in pair))
    for together in (*pairs, *speeds):
        found |= dict.fromkeys(together)
    if any(name in names for name in TURN[:2]):
        found |= dict.fromkeys(TURN)
    return tuple(name for name in found if name not in names)


def is_ordered(name: str) -> bool:
    """Whether a signal may rest without a fault: a request, or a quantity that no sensor measures."""
    return any(part in name for part in ORDERED)


def is_moved(name: str) -> bool:
    """Whether a signal is one of motion, other than a speed of the car."""
    return any(part in name for part in MOVED) and name not in SPEEDS
