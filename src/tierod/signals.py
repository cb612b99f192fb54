"""The catalogue of canonical signals: name in words, SI unit, meaning, direction (ISO 8855: left positive).

Every reader, monitor, plant and report speaks these names. `docs/nomenclature.md` is generated from here.
"""

from __future__ import annotations

from dataclasses import dataclass

from tierod.errors import InputError, nearest


@dataclass(frozen=True)
class Signal:
    """One canonical signal.

    Args:
        name: in words, as used in every public signature
        unit: SI, in the notation of pint ("rad/s", "N*m", "m/s**2"); "" for a number without unit
        meaning: one sentence
        positive: what a positive value means
        plausible: the range that a healthy road vehicle can reach, in the unit
        aliases: names seen in recordings, matched without regard to case and punctuation
    """

    name: str
    unit: str
    meaning: str
    positive: str = ""
    plausible: tuple[float, float] = (float("-inf"), float("inf"))
    aliases: tuple[str, ...] = ()


_CATALOGUE = (
    Signal("steering_wheel_angle", "rad", "Angle of the steering wheel.", "wheel turned left", (-16.0, 16.0)),
    Signal("steering_wheel_rate", "rad/s", "Rate of the steering wheel.", "turning left", (-25.0, 25.0)),
    Signal("driver_torque", "N*m", "Torque of the driver, measured by the torsion bar.", "towards left", (-30.0, 30.0)),
    Signal("motor_torque", "N*m", "Torque of the assist motor at the motor shaft.", "towards left", (-15.0, 15.0)),
    Signal("yaw_rate", "rad/s", "Yaw rate.", "left turn", (-2.0, 2.0)),
    Signal("lateral_acceleration", "m/s**2", "Lateral acceleration at the centre of gravity.", "left turn", (-15.0, 15.0)),
    Signal("vehicle_speed", "m/s", "Forward speed at the centre of gravity.", "forward", (-20.0, 90.0)),
)

SIGNALS: dict[str, Signal] = {signal.name: signal for signal in _CATALOGUE}
"""Every canonical signal by name."""


def signal(name: str) -> Signal:
    """The canonical signal of this name.

    Raises:
        InputError: the name is not in the catalogue; the message names the nearest ones
    """
    try:
        return SIGNALS[name]
    except KeyError:
        raise InputError(f"'{name}' is not a canonical signal{nearest(name, SIGNALS)}") from None
