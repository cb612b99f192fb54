"""Root cause of the alarms of a drive: which alarm comes first in the order of causes, when it began, what it means."""

from __future__ import annotations

import math

from tierod.monitors.motor_angle.alarms import ALARMS, BY_NAME
from tierod.monitors.motor_angle.drive import COMPARED, Drive
from tierod.monitors.motor_angle.residual_shape import DRIFT, GAIN, NOISE, OFFSET, RIPPLE
from tierod.monitors.motor_angle.signals import MEASURED
from tierod.monitors.motor_angle.voltage_balance import FITS
from tierod.monitors.motor_angle.which_angle import MOTOR, NOT_MOTOR, PINION, WHEEL
from tierod.vehicles import Vehicle

LEAST_KNOWN = 1.0
"""Least time with a turning motor for a healthy sensor [s]."""

FIVE_DEGREES = math.radians(5.0)

TOGETHER = 1.0
"""Time within which alarms have one root cause [s]."""

DISTURBING = ("stuck", "backwards", "electrical.resolver_mismatch", "electrical.angle_gradient", "not_following")
"""Sensor faults that disturb the observer: the drive stalls, as with swapped currents, or the angle leaps while the
motor is slow and its increments count."""

PASSING = 0.05
"""Share of surprising innovations since `model` alarmed, below which the motor's model was valid again at once."""

FEW_LEAPS = 3
"""Number of leaps of the angle up to which its zero jumped; a noisy or coarse sensor leaps all the time."""

STALLING = math.radians(45.0)
"""Offset from which a drive may not follow its target: its torque falls with the cosine [rad]."""

ONCE = (
    "currents, voltages and the changes of the angle contradicted each other for a moment, and agree again",
    "check whether the zero of the angle sensor jumped while the motor was slow; then the motor's flux and resistance",
)
"""Cause and action of `model` where the contradiction has passed and the sensor agrees."""

UNKNOWN = (
    "currents, voltages and the changes of the angle contradicted each other for a moment; the motor has turned too "
    "little since then to show whether the zero of the angle sensor has moved",
    "record faster or longer steering, and judge again; then check the zero of the angle sensor, and its line",
)
"""Cause and action of `model` where the contradiction has passed and the sensor could not be compared since."""

SENSOR_ALONE = (
    "the motor's angle contradicts currents and voltages, which fit each other",
    "check the sensor and its line: sign, noise, and the unit of motor_angle_mechanical in the channel map",
)
"""Cause and action of `model` where the induced voltage rotates as its magnitude requires."""

UNSETTLED = (
    "the angle sensor differs from the angle that currents and voltages give, and these contradict each other too: "
    "either may be wrong",
    "check sign, gain and phases of currents and voltages, and the sensor's magnet and its zero",
)
"""Cause and action of `angle` and `speed` where the induced voltage rotates otherwise than its magnitude requires."""

NOISY_SENSOR = (
    "the readings of the motor's angle sensor have noise",
    "check the sensor, its line and its resolution",
)
"""Cause and action of an alarm that noise of the readings explains."""

PASSED, UNDECIDED = "passed", "undecided"
"""A contradiction that has passed; one in which neither the sensor nor currents and voltages are accused alone."""

FROM_NOISE = ("model", "backwards", "angle", "speed", "electrical.angle_gradient", "not_following")
"""Alarms that noise of the readings can raise."""

CONFIRMED = (
    "the motor's angle stays away from target_motor_angle_mechanical, though currents and voltages confirm the "
    "sensor: the target is not the one that the motor follows, or the motor cannot follow it",
    "check sign and scale of the target in the channel map, and its time stamps; then the control and the load of the "
    "motor",
)
"""Cause and action of `not_following` where the sensor turns as the currents indicate."""

MOST_TORQUE = 10.0
"""Upper bound of a plausible driver's torque [N m]; power steering keeps it below 5."""

SUSPECTS = {
    MOTOR: "the motor's angle",
    WHEEL: "the steering wheel's angle",
    PINION: "the pinion's angle",
    NOT_MOTOR: "the steering wheel's angle or the pinion's, not the motor's,",
}


def root_of(drive: Drive) -> str | None:
    """The alarm from which the others follow; None without any.

    A contradiction of currents and voltages persists, whereas a sensor that stalls the drive, or leaps, disturbs the
    observer only once. An error of the sensor that stays is the root of such an earlier disturbance.
    """
    if not drive.starts:
        return None
    first = min(drive.starts.values())
    together = [each.name for each in ALARMS if drive.starts.get(each.name, math.inf) <= first + TOGETHER]
    root = together[0]
    disturbing = [name for name in together if name in DISTURBING]
    if root == "model" and disturbing and drive.surprised < 0.5:
        root = disturbing[0]
    return "angle" if _from_lasting_error(root, drive) else root


def _from_lasting_error(root: str, drive: Drive) -> bool:
    """Whether an error of the sensor that stays explains an earlier alarm."""
    shape = drive.shape
    if shape is None or "angle" not in drive.starts or drive.starts["angle"] < drive.starts[root]:
        return False
    if root == "model":
        return drive.surprised < PASSING and shape.kind in (OFFSET, DRIFT, GAIN, RIPPLE)
    if root == "electrical.angle_gradient":
        return drive.spells[root].samples <= FEW_LEAPS and shape.kind == OFFSET
    if root == "not_following":
        far = abs(shape.size) > STALLING
        return (shape.kind == OFFSET and far) or shape.kind == DRIFT or (shape.kind == GAIN and 0.5 < shape.size < 2.0)
    return False


def onset_of(root: str, drive: Drive) -> tuple[float, bool]:
    """When the error behind the root alarm began [s], and whether it was seen to begin."""
    declared = drive.starts[root]
    if root not in COMPARED or not math.isfinite(drive.onset):
        return declared, True
    shape, begin = drive.shape, drive.onset
    if shape is not None and shape.kind == DRIFT and math.isfinite(shape.zero):
        begin = min(max(shape.zero, 0.0), begin)
    if drive.settled:
        return begin, True
    earlier = [time for name, time in drive.starts.items() if name in (*DISTURBING, "model") and time < begin]
    return min((begin, *earlier)), bool(earlier) or begin < drive.onset


def accused_by(root: str, drive: Drive) -> str:
    """The alarm whose meaning the root alarm has, often itself; or NOISE, PASSED or UNDECIDED.

    Args:
        root: name of the root alarm
        drive: results of the drive
    """
    if root in FROM_NOISE and drive.shape is not None and drive.shape.kind == NOISE:
        return NOISE
    passed = root == "model" and drive.surprised < PASSING
    if root not in COMPARED and not passed:
        return root
    fits = drive.closes and not drive.departure
    if drive.voltages != MEASURED or fits or not drive.contradicting > FITS:
        return PASSED if passed else root
    # A motor with other parameters whose flux turns with the sensor: currents and voltages are at fault.
    agrees = abs(drive.turned) < FIVE_DEGREES if drive.closes else not drive.starts.keys() & set(COMPARED)
    return "model" if agrees else UNDECIDED


def cause_of(root: str, drive: Drive, vehicle: Vehicle) -> tuple[str, str]:
    """Cause and action of the root alarm."""
    root = accused_by(root, drive)
    if root == NOISE:
        return NOISY_SENSOR
    if root == UNDECIDED:
        return UNSETTLED[0] + _together(drive), UNSETTLED[1]
    if root == PASSED:
        return ONCE if drive.rms_since_model < FIVE_DEGREES else UNKNOWN
    if root == "model" and drive.voltages == MEASURED and drive.contradicting < FITS:
        return SENSOR_ALONE
    confirmed = drive.known >= LEAST_KNOWN and drive.rms < FIVE_DEGREES
    if root == "not_following" and confirmed and set(drive.starts) <= {root, "plausibility"}:
        return CONFIRMED
    cause, action = BY_NAME[root].cause, BY_NAME[root].action
    if root in COMPARED and drive.shape is not None:
        # The shape describes the difference of the angles, whichever of both alarms came first, and so the remedy.
        turns_otherwise = drive.shape.kind in (DRIFT, GAIN)
        cause, action = BY_NAME["angle"].cause, BY_NAME["speed" if turns_otherwise else "angle"].action
    if root == "plausibility":
        cause += f"; {SUSPECTS.get(drive.suspect, 'which of them is wrong')}" + (
            " is the wrong one" if drive.suspect else " cannot be decided"
        )
        cause += _or_torque(drive, vehicle)
    if root == "model" and drive.departure:
        cause += f"; they fit {drive.departure}"
    return cause, action


def _together(drive: Drive) -> str:
    """The motor and the offset of the sensor that currents, voltages and angle fit together; "" without any."""
    if not drive.closes:
        return ""
    offset = f"an angle sensor that is off by {-math.degrees(drive.turned):+.1f}° electrical"
    return f"; together they fit {drive.departure}, and {offset}"


def _or_torque(drive: Drive, vehicle: Vehicle) -> str:
    """The driver's torque as an alternative cause: it gives the twist of the bar between wheel and pinion."""
    if drive.suspect not in (WHEEL, NOT_MOTOR, 0.0) or not drive.mismatch > 0.0:
        return ""
    torque = drive.mismatch * vehicle["torsion_bar_stiffness"] / vehicle["superposition_input_ratio"]
    if torque > MOST_TORQUE:
        return ""
    return f", or driver_torque is off by up to {torque:.1f} N·m, so that the twist of the torsion bar is wrong"
