"""Parameters of the residuals, and their catalogue with equations and corrections."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE
from tierod.models.single_track import SingleTrack
from tierod_lab.papers.condition.rules.rack import StiffRack


@dataclass(frozen=True)
class ResidualParameters:
    """Parameters of the vehicle, named as in its file.

    Args:
        mass: mass of the vehicle as driven
        front_distance, rear_distance: distance from the centre of gravity to the axle
        front_cornering_stiffness, rear_cornering_stiffness: cornering stiffness of an axle, both tyres together
        column_inertia: moment of inertia of all that turns with the column
        nominal_friction: dry friction of the fault-free steering at the column

    Source: Li, Frey, Gauterin, Table A1. There `i` is the inverse of the rack ratio, although eqs (1) to (3) need the
    ratio itself and eq (5) inverts it; the inertia is printed in a thousandth of its unit.
    """

    mass: Annotated[float, "kg", POSITIVE]
    yaw_inertia: Annotated[float, "kg*m**2", POSITIVE]
    front_distance: Annotated[float, "m", POSITIVE]
    rear_distance: Annotated[float, "m", POSITIVE]
    front_cornering_stiffness: Annotated[float, "N/rad", POSITIVE]
    rear_cornering_stiffness: Annotated[float, "N/rad", POSITIVE]
    track_width: Annotated[float, "m", POSITIVE]
    steering_ratio: Annotated[float, "", POSITIVE]
    column_inertia: Annotated[float, "kg*m**2", POSITIVE]
    rack_stiffness: Annotated[float, "N/m", NOT_NEGATIVE]
    rack_damping: Annotated[float, "N*s/m", NOT_NEGATIVE]
    rack_ratio: Annotated[float, "m/rad", POSITIVE]
    nominal_friction: Annotated[float, "N*m", NOT_NEGATIVE]
    wheel_radius: Annotated[float, "m", POSITIVE]

    @property
    def wheelbase(self) -> float:
        """Distance between the axles [m]."""
        return self.front_distance + self.rear_distance

    @property
    def single_track(self) -> SingleTrack.Parameters:
        """Parameters of the single-track model."""
        return SingleTrack.Parameters(
            self.mass,
            self.yaw_inertia,
            self.front_distance,
            self.rear_distance,
            self.front_cornering_stiffness,
            self.rear_cornering_stiffness,
        )

    @property
    def rack(self) -> StiffRack.Parameters:
        """Parameters of the steering with a rigid rack."""
        return StiffRack.Parameters(
            self.column_inertia,
            self.rack_stiffness,
            self.rack_damping,
            self.rack_ratio,
            self.nominal_friction,
        )


@dataclass(frozen=True)
class Coefficients:
    """Coefficients of the models of torque, tie-rod force, angle and drives, by least squares on fault-free drives."""

    # angle, rate, acceleration: torque over angle, rate and acceleration of the steering, a1 to a3 of eq (11)
    angle: Annotated[float, "N*m/rad", ANY] = 0.0
    rate: Annotated[float, "N*m*s/rad", ANY] = 0.0
    acceleration: Annotated[float, "kg*m**2", ANY] = 0.0
    friction: Annotated[float, "N*m", ANY] = 0.0  # dry friction, with the sign of the rate
    # torque over lateral acceleration; missing in eq (11), which holds without a tie-rod force only
    cornering: Annotated[float, "kg*m", ANY] = 0.0
    torque_offset: Annotated[float, "N*m", ANY] = 0.0  # offset of the torque sensor
    per_mass: Annotated[float, "", ANY] = 0.0  # per_mass, per_torque: a4 and a5 of eq (46)
    per_torque: Annotated[float, "1/m", ANY] = 0.0
    force_friction: Annotated[float, "N*m", ANY] = 0.0  # dry friction of eq (46), with the sign of the rate
    force_offset: Annotated[float, "N", ANY] = 0.0  # offset of the force sensor
    # steer angle over speed times yaw rate, which eq (7) leaves out
    understeer: Annotated[float, "rad*s**2/m", ANY] = 0.0
    angle_offset: Annotated[float, "rad", ANY] = 0.0  # offset of the angle sensor
    # inertia, resistance, drag, turning: force of the drives over longitudinal acceleration, constant, over squared
    # speed, and over lateral acceleration times steer angle
    inertia: Annotated[float, "kg", ANY] = 0.0
    resistance: Annotated[float, "N", ANY] = 0.0
    drag: Annotated[float, "N*s**2/m**2", ANY] = 0.0
    turning: Annotated[float, "kg", ANY] = 0.0


PAPER = "Li, Frey, Gauterin, "
LEFT, RIGHT = "wheel_speed_rear_left", "wheel_speed_rear_right"
YAW, ANGLE = "yaw_rate", "steering_wheel_angle"
TORQUE, FORCE = "steering_shaft_torque", "tie_rod_force"
ALONG, ACROSS = "longitudinal_acceleration", "lateral_acceleration"

_LATERAL = (LEFT, RIGHT, YAW, ANGLE, ACROSS)
_SPEED = (*_LATERAL, ALONG)
_WHEELS = (LEFT, RIGHT)
_TARGETS = ("target_steering_wheel_angle", "target_vehicle_speed")
_DRIVES = ("target_drive_torque_left", "target_drive_torque_right")
_TORQUES = ("steering_motor_1_target_torque", "steering_motor_2_target_torque")


@dataclass(frozen=True)
class Residual:
    """One residual: estimate less measurement, or target less actual value."""

    name: str  # name in the rules
    meaning: str  # short description
    equation: str  # equation of the paper
    signals: tuple[str, ...]  # canonical signals that determine its value, without wheel speeds that only enable it
    unit: str  # SI unit
    correction: str = ""  # correction of the printed equation, "" for none
    moving: bool = True  # whether it is enabled only while the vehicle moves
    steady: bool = False  # whether it is enabled only while the commanded steering torque does not jump
    gentle: bool = False  # whether it is enabled only at lateral accelerations at which the tyres are linear


def _wheel(name: str, side: str, by: str, route: str, number: int) -> Residual:
    through = "the mean of both wheels" if by == "mean" else "the two-stage filter's speed"
    angle = "the yaw rate" if route == "yaw" else "the steering angle"
    signals = (*_WHEELS, YAW if route == "yaw" else ANGLE) if by == "mean" else _SPEED
    correction = ""
    if by == "mean" and route == "yaw":
        correction = "eq (27) gave the right wheel the radicand of the left one"
    return Residual(
        name, f"{side} rear wheel from {through} and {angle}", f"{PAPER}eq ({number})", signals, "m/s", correction
    )


def _beyond(name: str, meaning: str, signals: tuple[str, ...]) -> Residual:
    return Residual(name, meaning, "beyond the paper: least squares over the last half second", signals, "")


SENSOR_RESIDUALS: tuple[Residual, ...] = (
    Residual(
        "r1",
        "steering angle from the balance of the steering, unscented filter",
        PAPER + "eqs (2) to (6)",
        (ANGLE, TORQUE, FORCE),
        "rad",
        "force of the teeth times rack ratio in eq (2); ratio turned round in eqs (1), (3), (5); inertia a thousandth; "
        "friction with the sign of the rate; one measurement instead of the same twice",
    ),
    Residual(
        "r2",
        "steering angle from yaw rate and rear wheels",
        PAPER + "eqs (7) to (10)",
        (LEFT, RIGHT, YAW, ANGLE),
        "rad",
        "ratio turned round in eq (9); arctangent instead of cotangents; understeer added",
        gentle=True,
    ),
    Residual(
        "r3",
        "steering torque from the motion of the steering",
        PAPER + "eqs (11), (12)",
        (ANGLE, TORQUE, ACROSS),
        "N*m",
        "friction with the sign of the rate; lateral acceleration added to eq (11)",
    ),
    Residual(
        "r4",
        "yaw rate from the single track",
        PAPER + "eqs (13) to (15)",
        _LATERAL,
        "rad/s",
        "C[1,1] of eq (14) without the speed",
        gentle=True,
    ),
    Residual(
        "r5",
        "longitudinal acceleration from the rear wheels",
        PAPER + "eqs (16), (17), (19), (20)",
        _SPEED,
        "m/s**2",
        "terms of a changing speed in eq (17)",
    ),
    Residual(
        "r6", "lateral acceleration from the single track", PAPER + "eqs (18), (21)", _LATERAL, "m/s**2", gentle=True
    ),
    _wheel("r7", "left", "mean", "yaw", 34),
    _wheel("r8", "left", "filter", "yaw", 35),
    _wheel("r9", "left", "mean", "angle", 36),
    _wheel("r10", "left", "filter", "angle", 37),
    _wheel("r11", "right", "mean", "yaw", 38),
    _wheel("r12", "right", "filter", "yaw", 39),
    _wheel("r13", "right", "mean", "angle", 40),
    _wheel("r14", "right", "filter", "angle", 41),
    Residual("r15", "speed of the two-stage filter beside the wheels' mean", PAPER + "eq (42)", _SPEED, "m/s"),
    Residual("r16", "acceleration of the two-stage filter less the sensor's", PAPER + "eq (43)", _SPEED, "m/s**2"),
    Residual(
        "r17", "sideslip of the single track beside the steering's", PAPER + "eq (44)", _LATERAL, "rad", gentle=True
    ),
    Residual(
        "r18", "sideslip of the single track beside the yaw rate's", PAPER + "eq (45)", _LATERAL, "rad", gentle=True
    ),
    Residual(
        "r19",
        "tie-rod force from lateral acceleration and steering torque",
        PAPER + "eqs (46), (47)",
        (ANGLE, TORQUE, FORCE, ACROSS),
        "N",
        "friction with the sign of the rate, which needs the angle; the measured force without a hat in eq (47)",
    ),
)
"""Residuals r1 to r19 of the sensors."""

ACTUATOR_RESIDUALS: tuple[Residual, ...] = (
    Residual("r1a", "yaw rate by the targets", PAPER + "eq (48)", (*_TARGETS, YAW), "rad/s"),
    Residual("r2a", "sideslip angle by the targets", PAPER + "eq (48)", (*_TARGETS, *_LATERAL), "rad"),
    Residual("r3a", "longitudinal acceleration by the targets", PAPER + "eq (49)", (*_TARGETS, ALONG), "m/s**2"),
    Residual("r4a", "lateral acceleration by the targets", PAPER + "eq (49)", (*_TARGETS, ACROSS), "m/s**2"),
    Residual("r5a", "target less actual steering angle", PAPER + "eq (50)", (_TARGETS[0], ANGLE), "rad"),
    Residual(
        "r6a",
        "target less actual steering torque",
        PAPER + "eq (50)",
        (*_TORQUES, TORQUE),
        "N*m",
        "both motors' targets are added, since the sensor sees their sum",
        moving=False,
        steady=True,
    ),
    Residual("r7a", "target less actual speed", PAPER + "eqs (51), (52)", (_TARGETS[1], *_WHEELS), "m/s", moving=False),
    Residual("r8a", "tie-rod force by the targets", PAPER + "eq (52)", (*_TARGETS, *_TORQUES, FORCE), "N", steady=True),
    _beyond("motor_1_share", "share of motor 1's torque missing at the shaft", (*_TORQUES, ANGLE, TORQUE, ACROSS)),
    _beyond("motor_2_share", "share of motor 2's torque missing at the shaft", (*_TORQUES, ANGLE, TORQUE, ACROSS)),
    _beyond("drive_share", "drives' torque missing along", (*_DRIVES, *_WHEELS, ANGLE, ALONG, ACROSS)),
    _beyond("drive_side", "drives' torque found at the tie rods", (*_DRIVES, ANGLE, TORQUE, FORCE, ACROSS)),
)
"""Residuals r1a to r8a of the actuators, r1 to r8 in the paper, and four beyond the paper."""

RESIDUALS: dict[str, Residual] = {each.name: each for each in (*SENSOR_RESIDUALS, *ACTUATOR_RESIDUALS)}
"""All residuals by name."""


def residual(name: str) -> Residual:
    """The residual with a name.

    Raises:
        ParameterError: there is no such residual; the message suggests the nearest name
    """
    if name not in RESIDUALS:
        raise ParameterError(f"no residual is called '{name}'{nearest(name, RESIDUALS)}")
    return RESIDUALS[name]
