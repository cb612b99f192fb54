"""Related signals of a car, which move together, so that one of them reveals that another is stuck."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

SPEEDS = (
    "vehicle_speed",
    "wheel_speed_front_left",
    "wheel_speed_front_right",
    "wheel_speed_rear_left",
    "wheel_speed_rear_right",
)
"""Signals that show whether the car moves."""

RATES = (
    ("steering_wheel_rate", "steering_wheel_angle"),
    ("pinion_rate", "pinion_angle"),
    ("motor_speed", "motor_angle_mechanical"),
)
"""(rate, angle) pairs: the rate is the derivative of the angle."""

TURN = ("lateral_acceleration", "yaw_rate", "vehicle_speed")
"""Signals of a turn: the first is approximately the product of the other two."""

STEERED = ("steering_wheel_angle", "road_wheel_angle")
"""Steering angles, which cannot rest while the car turns to one side and then to the other."""

SAME_SPEED = (
    ("vehicle_speed", SPEEDS[1:]),
    *((f"wheel_speed_{end}_left", ("vehicle_speed", f"wheel_speed_{end}_right")) for end in ("front", "rear")),
    *((f"wheel_speed_{end}_right", ("vehicle_speed", f"wheel_speed_{end}_left")) for end in ("front", "rear")),
)
"""(signal, others): speeds that differ only by slip and the radius of the turn. One of the others may slip, so that the
nearest one is compared."""

FOLLOWS = (
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
"""(signal, other, share): the signal cannot rest while the other changes by this share of the range that it has shown
so far. The torques need a large share: assist has a dead band, and a lane keeping motor turns a wheel without hands."""

WRONG_SIGN_SHARE = 0.9
"""Share of opposed driver and motor torques above which a wrong sign is more likely than lane keeping [-]."""

ORDERED = ("target", "truth", "lane_keeping", "duty_cycle")
"""Parts of the names of requested quantities, which may rest, and of quantities that no sensor measures."""

TURNED = ("angle", "rate", "position", "speed", "twist")
"""Parts of the names of signals of motion: without a recorded speed these may rest however much forces fluctuate."""


def witnesses(names: Iterable[str]) -> tuple[str, ...]:
    """Further signals that can reveal that one of these is stuck.

    Args:
        names: canonical signals that are monitored
    """
    known = tuple(names)
    found: dict[str, None] = {}
    speeds = ((name, *others) for name, others in SAME_SPEED if name in known)
    pairs = (pair for pair in (*RATES, *(entry[:2] for entry in FOLLOWS)) if any(name in known for name in pair))
    for together in (*pairs, *speeds):
        found |= dict.fromkeys(together)
    if any(name in known for name in TURN[:2]):
        found |= dict.fromkeys(TURN)
    return tuple(name for name in found if name not in known)


def is_ordered(name: str) -> bool:
    """Whether a signal may rest without a fault: a request, or a quantity that no sensor measures."""
    return any(part in name for part in ORDERED)


def is_turned(name: str) -> bool:
    """Whether a signal is one of motion, other than a speed of the car."""
    return any(part in name for part in TURNED) and name not in SPEEDS


Pair = tuple[str, str]


def odd_ones_out(names: Sequence[str], agreement: Mapping[Pair, bool]) -> tuple[str, ...]:
    """Signal that contradicts the others; several if they are not isolable from each other, none if all agree.

    Args:
        names: names of all signals
        agreement: whether a pair agrees; pairs without enough information are left out
    """
    against = [pair for pair, agrees in agreement.items() if not agrees]
    with_ = [pair for pair, agrees in agreement.items() if agrees]
    if not against:
        return ()
    suspects = [name for name in names if all(name in pair for pair in against)]
    cleared = [name for name in suspects if not any(name in pair for pair in with_)]
    return tuple(cleared or suspects or names)
