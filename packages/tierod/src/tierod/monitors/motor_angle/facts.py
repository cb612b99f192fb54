"""The verdict over a drive: root cause of its alarms, isolated part, since when, and defects of the recording."""

from __future__ import annotations

import math
from dataclasses import replace

from tierod.core.facts import ESTIMATE, Fact, Verdict, shortened
from tierod.core.findings import Episode, Estimate, Status
from tierod.monitors.motor_angle.alarms import ALARMS, BY_NAME
from tierod.monitors.motor_angle.balance import FITS
from tierod.monitors.motor_angle.evidence import (
    COMPARED,
    DRIFT,
    GAIN,
    NOISE,
    OFFSET,
    RIPPLE,
    SCATTER,
    Drive,
    InverterLoss,
    Shape,
)
from tierod.monitors.motor_angle.observer import IN_WORDS, MEASURED
from tierod.monitors.motor_angle.plausibility import MOTOR, NOT_MOTOR, PINION, WHEEL
from tierod.vehicles import Vehicle

LEAST_KNOWN = 1.0  # least time with a turning motor for a healthy sensor [s]

FIVE_DEGREES = math.radians(5.0)

TOGETHER = 1.0  # time within which alarms have one root cause [s]
# Sensor faults that disturb the observer: the drive stalls, as with swapped currents, or the angle leaps while the
# motor is slow and its increments count.
DISTURBING = ("stuck", "backwards", "electrical.resolver_mismatch", "electrical.angle_gradient", "not_following")
# Share of surprising innovations since `model` alarmed, below which the motor's model was valid again at once.
PASSING = 0.05
FEW_LEAPS = 3  # number of leaps of the angle up to which its zero jumped; a noisy or coarse sensor leaps all the time
# Offset from which a drive may not follow its target: its torque falls with the cosine [rad].
STALLING = math.radians(45.0)

CASES = {
    each.name: each
    for each in (
        *(Fact(each.name, each.cause, each.reason, each.action) for each in ALARMS),
        Fact(
            "once",
            "currents, voltages and the changes of the angle contradicted each other for a moment, and agree again",
            "a contradiction of currents and angle passed",
            "check whether the zero of the angle sensor jumped while the motor was slow; then the motor's flux and "
            "resistance",
        ),
        Fact(
            "unknown",
            "currents, voltages and the changes of the angle contradicted each other for a moment; the motor has "
            "turned too little since then to show whether the zero of the angle sensor has moved",
            "a contradiction of currents and angle passed",
            "record faster or longer steering, and judge again; then check the zero of the angle sensor, and its line",
        ),
        Fact(
            "sensor alone",
            "the motor's angle contradicts currents and voltages, which fit each other",
            "the angle contradicts currents and voltages",
            "check the sensor and its line: sign, noise, and the unit of motor_angle_mechanical in the channel map",
        ),
        Fact(
            "unsettled",
            "the angle sensor differs from the angle that currents and voltages give, and these contradict each other "
            "too: either may be wrong{together}",
            "angle, currents and voltages contradict each other",
            "check sign, gain and phases of currents and voltages, and the sensor's magnet and its zero",
        ),
        Fact(
            "noise",
            "the readings of the motor's angle sensor have noise",
            "",
            "check the sensor, its line and its resolution",
        ),
        Fact(
            "other target",
            "the motor's angle stays away from target_motor_angle_mechanical, though currents and voltages confirm "
            "the sensor: the target is not the one that the motor follows, or the motor cannot follow it",
            "the motor does not follow its target",
            "check sign and scale of the target in the channel map, and its time stamps; then the control and the "
            "load of the motor",
        ),
        Fact(
            "slow",
            f"the motor turned fast enough for {{known:.1f}} s only, {LEAST_KNOWN:g} s are needed",
            "turned fast enough for {known:.1f} s only",
            "record faster or longer steering; below about 10 rad/s at the shaft the currents do not determine the "
            "angle",
        ),
        Fact(
            "uncompared",
            "the angle was missing whenever the motor turned fast enough to compare it",
            "the angle was missing while the motor turned",
            "record the angle throughout",
        ),
        Fact(
            "untwisted",
            "the angles of motor, steering wheel and pinion are not compared: without driver_torque the twist of the "
            "torsion bar between them is unknown",
        ),
        Fact("noisy", "the readings of the angle sensor have noise of {noise:.2f}° mechanical, above {limit:.2f}°"),
    )
}
"""Sentences of the findings, by case; those of the alarms by their names."""

# A contradiction that has passed; one in which neither the sensor nor currents and voltages are isolated.
PASSED, UNDECIDED = "passed", "undecided"
# Alarms that noise of the readings can raise.
FROM_NOISE = ("model", "backwards", "angle", "speed", "electrical.angle_gradient", "not_following")
MOST_TORQUE = 10.0  # upper bound of a plausible driver's torque [N m]; power steering keeps it below 5

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


def isolated_by(root: str, drive: Drive) -> str:
    """The alarm whose meaning the root alarm has, often itself; or NOISE, PASSED or UNDECIDED."""
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


def fact_of(root: str, drive: Drive, vehicle: Vehicle) -> Fact:
    """What the root alarm means."""
    root = isolated_by(root, drive)
    if root == NOISE:
        return CASES["noise"]
    if root == UNDECIDED:
        return CASES["unsettled"].filled(together=_together(drive))
    if root == PASSED:
        return CASES["once" if drive.rms_since_model < FIVE_DEGREES else "unknown"]
    if root == "model" and drive.voltages == MEASURED and drive.contradicting < FITS:
        return CASES["sensor alone"]
    confirmed = drive.known >= LEAST_KNOWN and drive.rms < FIVE_DEGREES
    if root == "not_following" and confirmed and set(drive.starts) <= {root, "plausibility"}:
        return CASES["other target"]
    found = CASES[root]
    if root in COMPARED and drive.shape is not None:
        # The shape describes the difference of the angles, whichever of both alarms came first, and so the remedy.
        turns_otherwise = drive.shape.kind in (DRIFT, GAIN)
        return replace(CASES["angle"], action=CASES["speed" if turns_otherwise else "angle"].action)
    if root == "plausibility":
        wrong = SUSPECTS.get(drive.suspect, "which of them is wrong")
        decided = "is the wrong one" if drive.suspect else "cannot be decided"
        return replace(found, cause=f"{found.cause}; {wrong} {decided}{_or_torque(drive, vehicle)}")
    if root == "model" and drive.departure:
        return replace(found, cause=f"{found.cause}; they fit {drive.departure}")
    return found


def _together(drive: Drive) -> str:
    if not drive.closes:
        return ""
    offset = f"an angle sensor that is off by {-math.degrees(drive.turned):+.1f}° electrical"
    return f"; together they fit {drive.departure}, and {offset}"


def _or_torque(drive: Drive, vehicle: Vehicle) -> str:
    if drive.suspect not in (WHEEL, NOT_MOTOR, 0.0) or not drive.mismatch > 0.0:
        return ""
    torque = drive.mismatch * vehicle["torsion_bar_stiffness"] / vehicle["superposition_input_ratio"]
    if torque > MOST_TORQUE:
        return ""
    return f", or driver_torque is off by up to {torque:.1f} N·m, so that the twist of the torsion bar is wrong"


DIFFERENCE = "difference of the motor's angle sensor from the angle that its currents give, electrical"

ENDED = 1.0  # time without the alarm at the end of the drive from which it has ended [s]
# Alarms that a wrong recording can raise.
NOT_THE_SENSOR = ("model", "angle", "speed", "stuck", "backwards", "not_following", "electrical.angle_gradient")


def judge(drive: Drive, vehicle: Vehicle) -> Verdict:
    """The verdict over a drive, with remarks on the voltages behind it."""
    notes = [CASES["untwisted"]] if drive.untwisted else []
    if drive.noise > drive.noise_limit and not drive.starts:
        noise, limit = math.degrees(drive.noise), math.degrees(drive.noise_limit)
        notes.append(CASES["noisy"].filled(noise=noise, limit=limit))
    notes += (Fact("inverter", each) for each in inverter_remarks(drive.lost, drive.voltages))
    return replace(_judged(drive, vehicle), facts=tuple(notes))


def _wrong_recording(drive: Drive, vehicle: Vehicle) -> tuple[str, str] | None:
    """Cause and action of an error of the recording that prevents a judgement of the sensor; None without one."""
    if wrong := wrong_scale(drive, vehicle["motor_pole_pairs"]):
        return wrong
    suspect = root_of(drive) in NOT_THE_SENSOR or (not drive.starts and drive.known < LEAST_KNOWN)
    if drive.misread is not None and suspect:
        return drive.misread
    return knee_beyond(drive.lost) if drive.lost is not None and suspect else None


def _judged(drive: Drive, vehicle: Vehicle) -> Verdict:
    evidence = _evidence(drive)
    if wrong := _wrong_recording(drive, vehicle):
        cause, action = wrong
        reason = shortened(cause) or "the recording does not fit the motor"
        fact = Fact("recording", cause, reason, action)
        return Verdict(drive.monitor, Status.NOT_TESTABLE, (fact,), evidence=evidence)
    if drive.starts:
        return _fault(drive, vehicle, evidence)
    estimate = None
    if drive.counted:
        limit = {"smallest offset worth an alarm": FIVE_DEGREES}
        estimate = Estimate(DIFFERENCE, drive.offset, drive.offset_deviation, "rad", limit)
    if drive.known < LEAST_KNOWN:
        because = (CASES["slow"].filled(known=drive.known),)
        return Verdict(drive.monitor, Status.NOT_ENABLED, because, estimate, evidence=evidence)
    if estimate is None:
        return Verdict(drive.monitor, Status.NOT_ENABLED, (CASES["uncompared"],), evidence=evidence)
    voltages = "voltages" if drive.lost is None else "commanded voltages"
    differs = f"over {drive.known:.1f} s of turning it differs by {ESTIMATE} electrical from the angle that currents"
    details = (f"{differs} and {voltages} give",)
    because = (Fact("healthy", "", action="none"),)
    return Verdict(drive.monitor, Status.HEALTHY, because, estimate, evidence=evidence, details=details)


def _fault(drive: Drive, vehicle: Vehicle, evidence: dict[str, float]) -> Verdict:
    root = root_of(drive)
    assert root is not None
    fact, isolated = fact_of(root, drive, vehicle), isolated_by(root, drive)
    # The difference from the observer is the magnitude of the fault only where it decided.
    shape = drive.shape if isolated in (*COMPARED, NOISE) else None
    episode, seen = _episode(root, drive)
    details = [_when(episode, seen)]
    if shape is not None:
        details.insert(0, f"{fact.cause} {shape.in_words(drive.settled)}")
        fact = replace(fact, reason="")  # the estimate says more
    return Verdict(
        drive.monitor,
        Status.SUSPECT if isolated == UNDECIDED else Status.FAULT,
        (fact,),
        None if shape is None else _magnitude(shape),
        episode.start,
        evidence,
        tuple(details),
        (BY_NAME[root].decision.name,),
        episode.declared,
        episode.end,
    )


def _magnitude(shape: Shape) -> Estimate:
    quantity = {
        DRIFT: f"drift of {DIFFERENCE}",
        GAIN: "turn of the motor's angle sensor over that which its currents give",
        RIPPLE: f"amplitude of the ripple of {DIFFERENCE}",
        SCATTER: f"root mean square of {DIFFERENCE}",
        NOISE: "noise of the readings of the motor's angle sensor, mechanical",
    }.get(shape.kind, DIFFERENCE)
    unit = {DRIFT: "rad/s", GAIN: ""}.get(shape.kind, "rad")
    limit = {"smallest offset worth an alarm": FIVE_DEGREES} if unit == "rad" and shape.kind != NOISE else {}
    return Estimate(quantity, shape.size, shape.deviation, unit, limit)


def _episode(root: str, drive: Drive) -> tuple[Episode, bool]:
    if isolated_by(root, drive) == NOISE:
        lasts = drive.until - drive.end < ENDED
        onset = min(drive.onset, drive.starts[root])
        return Episode("", onset, None if lasts else drive.end, declared=drive.starts[root]), True
    onset, seen = onset_of(root, drive)
    last = drive.end if root in COMPARED else drive.spells[root].last
    # A sensor that stalls the drive, or leaps, is no longer seen by its own test.
    lasts = drive.until - max(each.last for each in drive.spells.values()) < ENDED
    return Episode("", onset, None if lasts else last, declared=drive.starts[root]), seen


def _when(episode: Episode, seen: bool) -> str:
    begin = f"{episode.start:.2f} s{'' if seen else ' at the latest'}"
    late = "" if episode.belated is None else f", declared at {episode.belated:.2f} s"
    if episode.end is None:
        return f"since {begin}{late}"
    if episode.end - episode.start < 0.01:
        return f"at {begin}"
    return f"from {begin} to {episode.end:.2f} s{late}"


def _evidence(drive: Drive) -> dict[str, float]:
    found = {
        "turning_s": drive.known,
        "turning_share": drive.known / max(drive.seconds, 1e-9),
        "angle_residual_rms_electrical_rad": drive.rms if drive.counted else math.nan,
        "nis_mean": drive.nis,
        "sensor_turns_per_observed_turn": drive.slope,
        "sensor_noise_mechanical_rad": drive.noise,
        "smallest_named_sensor_noise_mechanical_rad": drive.noise_limit,
        "resistance_over_nominal": drive.resistance,
        "flux_over_nominal": drive.flux,
    }
    if drive.lost is not None:
        found["inverter_voltage_loss_v"] = drive.lost.voltage_loss
        found["inverter_knee_current_a"] = drive.lost.knee_current
        found["inverter_knee_over_nominal"] = math.exp(drive.lost.apart)
    found = {name: value for name, value in found.items() if math.isfinite(value)}
    for name in (each.name for each in ALARMS if each.name in drive.starts):
        found[f"{name.removeprefix('electrical.')}_alarm_from_s"] = drive.starts[name]
    return found


LEAST_INCREMENTS = 30  # least number of 10 ms windows for the scale of the angle
# Correlation of the increments of sensor and observer from which a wrong scale is an error of the recording or file,
# not a fault.
AGREEMENT = 0.98
# Relative tolerance within which a scale is attributed to a number of pole pairs, which are whole numbers.
SCALE_MARGIN = 0.1
# Factor and number of standard deviations beyond which the knee differs from that of the vehicle file.
KNEE_APART, KNEE_SIGMAS = 1.4, 4.0


def wrong_scale(drive: Drive, pole_pairs: float) -> tuple[str, str] | None:
    """Cause and action of a scale that is wrong throughout, so that the error grows with the angle."""
    if drive.windows < LEAST_INCREMENTS or drive.agreement < AGREEMENT:
        return None
    slope = drive.slope

    def near(value: float) -> bool:
        return abs(slope / value - 1.0) < SCALE_MARGIN / max(pole_pairs, 2.0)

    if pole_pairs > 1.5 and near(pole_pairs):
        cause = (
            f"the angle changes by {slope:.2f} turns per turn of the shaft: it is electrical, but named as mechanical"
        )
        return cause, "name the channel motor_angle_electrical in the channel map, or divide by the pole pairs"
    for pairs in range(1, 41):
        if abs(pairs - pole_pairs) > 0.5 and near(pole_pairs / pairs):
            cause = (
                f"the error grows with the angle: the sensor turns {slope:.3f} times as far as the observer, as with "
                f"{pairs} pole pairs, but motor_pole_pairs is {pole_pairs:g}"
            )
            return cause, "correct motor_pole_pairs in the vehicle file"
    return None


def inverter_remarks(lost: InverterLoss | None, voltages: str) -> tuple[str, ...]:
    """Remarks on the voltages behind a finding, and on an inverter that differs from the vehicle file.

    Args:
        lost: estimated voltage loss of the inverter; None where the voltages were measured
    """
    if lost is None:
        return ()
    rests_on = (
        f"the voltages are {IN_WORDS[voltages]}: {lost.voltage_loss:.2f} V per phase, with a knee at "
        f"{lost.knee_current:.2g} A; measured voltages give the angle more accurately"
    )
    if abs(lost.apart) < max(math.log(KNEE_APART), KNEE_SIGMAS * lost.knee_deviation):
        return (rests_on,)
    wrong = (
        f"the inverter's knee is at {lost.knee_current:.2g} A, not at {lost.nominal_knee:.2g} A as in the vehicle "
        "file: correct inverter_knee_current; until the knee is learnt, the angle is less accurate"
    )
    return (rests_on, wrong)


def knee_beyond(lost: InverterLoss) -> tuple[str, str] | None:
    """Cause and action where the knee may lie outside the range that is learnt; None where it does not."""
    if not lost.beyond:
        return None
    return (
        f"the inverter's knee lies outside the range that can be learnt: {lost.knee_current:.2g} A, vehicle file "
        f"{lost.nominal_knee:.2g} A",
        "find inverter_knee_current with 'tierod identify inverter', or record the voltages",
    )
