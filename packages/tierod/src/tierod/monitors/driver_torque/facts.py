"""Decisions and verdict of the monitor of the driver's hands: the hands, and whether file and recording fit."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

from tierod.core.facts import Fact, Verdict
from tierod.core.findings import Estimate, Status
from tierod.methods.detectors import Detector
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.rule_design import RuleDesign, RunLengthLine, alarms_at
from tierod.methods.detectors.stopping_rules import CusumRule, HoldRule
from tierod.monitors.decision import Decision, Demonstrated
from tierod.monitors.driver_torque.column import described
from tierod.monitors.driver_torque.design import usual_tuning
from tierod.monitors.driver_torque.evidence import Drive
from tierod.monitors.driver_torque.hands import THRESHOLDS
from tierod.vehicles import Vehicle
from tierod.vehicles.classes import torque_gain_deviation

# Relative standard deviations of fault-free cars from their vehicle files [-]: the wheel's inertia as weighed and
# learnt; bars scatter, or have a gear in series; gains of angle sensors, for a design value; the motor's inertia, which
# a sweep to 30 Hz makes 1.2 times as large.
INERTIA_SPREAD, STIFFNESS_SPREAD, RATIO_SPREAD, MOTOR_INERTIA_SPREAD = 0.026, 0.064, 0.005, 0.104
# Standard deviation of a torque offset beyond the learnt one, which hands may imitate [N*m]; a sixth of the torque that
# reveals them.
OFFSET_SPREAD: Annotated[float, "N*m"] = 0.026
# Standard deviation of a signal's lag [s]; 1 ms costs a sixth of the accuracy, and at low rates samples are held
# longer.
LAG_SPREAD: Annotated[float, "s"] = 5e-4
# Standard deviation of the logarithm of the mean NIS per measurement [-]; three times the expected noise is 3.7 of them
# away.
MISFIT_SPREAD = 0.62
# Threshold of these standard deviations for a remark on the mean NIS; one fault-free recording in 44 exceeds it by
# chance.
DOUBTED = 2.0

FIT_DESIGN = RuleDesign(HoldRule(1), values=1e4, shift=6.0, spacing=math.inf)
# One decision at the end of a recording.
MISFIT_DESIGN = RuleDesign(HoldRule(1, sides="upper"), values=1e4, shift=6.0, spacing=math.inf)

OFF_DESIGN = RuleDesign(
    CusumRule(0.0, sides="upper"),
    values=3.60e8,
    shift=0.094,
    spacing=1e-3,
    line=RunLengthLine(start=8.629, slope=0.3421, observed=3.65e6),
)
"""Design of the CUSUM for hands off at 1 kHz: counted on 2 h of benches that are 2 % off, by `design_thresholds` of the
study of the column. 100 h between false alarms while holding need 32.4 nats; 33 are used. Hands that
leave give a nat in 10.6 ms (thresholds from 8 to 45)."""


# Names of the decisions on the agreement of vehicle file and recording.
COLUMN, INNOVATIONS = "column as the vehicle file says", "innovations as expected"


@dataclass(frozen=True)
class FitRules:
    """Rules that decide whether vehicle file and recording agree."""

    either: Detector = field(default_factory=FIT_DESIGN.block)  # rule for a distance with a sign
    above: Detector = field(default_factory=MISFIT_DESIGN.block)  # rule for a distance that can only be too large

    def apart(self, difference: float, spread: float) -> bool:
        """Whether a difference exceeds what chance explains."""
        return alarms_at(self.either, difference / spread)

    def misfit(self, nis: float) -> bool:
        """Whether a mean NIS per measurement exceeds that of a matching column; NaN does not."""
        return nis > 0.0 and alarms_at(self.above, misfit(nis))

    def beyond(self, name: str, distance: float) -> bool:
        """Whether the decision of this name alarms at a distance [standard deviations]."""
        return alarms_at(self.above if name == INNOVATIONS else self.either, distance)


def misfit(nis: float) -> float:
    """Distance of a mean NIS per measurement from that of a matching column [standard deviations]."""
    return math.log(nis) / MISFIT_SPREAD


_BENCHES = "benches with parameter errors of 2 %, 10 h and another 2 h (tierod study column)"

DECISIONS = (
    Decision(
        name="hands on",
        distance="log-likelihood ratio of hands on against hands off, nats per sample",
        rule=Cusum(0.0, THRESHOLDS[0], THRESHOLDS[0], "upper"),
        place="block.hands.to_on",
        mean_time_between_false_alarms=None,
        demonstrated=Demonstrated(12.0),
        source=f"{_BENCHES}; 100 h need 6 nats by the fitted line; 30 nats allow for larger parameter errors",
        statistic="evidence_for_hands",
        levels=(1.0,),
    ),
    Decision(
        name="hands off",
        distance="log-likelihood ratio of hands off against hands on, nats per sample",
        rule=Cusum(0.0, THRESHOLDS[1], THRESHOLDS[1], "lower"),
        place="block.hands.to_off",
        mean_time_between_false_alarms=100.0,
        demonstrated=Demonstrated(12.0, 1),
        source=f"{_BENCHES}; extrapolated to over a thousand times the measured distance",
        design=OFF_DESIGN,
        statistic="evidence_for_hands",
        levels=(-1.0,),
    ),
    Decision(
        name=COLUMN,
        distance="inertia of wheel and motor, stiffness, ratio, offset and lag of a signal, each less its expected "
        "value, in standard deviations over fault-free cars",
        rule=FIT_DESIGN.block(),
        place="rules.either",
        mean_time_between_false_alarms=1e4,
        demonstrated=Demonstrated(24.0),
        source="Gaussian scatter of each quantity; benches with parameter errors of 2 %, a minute each (inertia 2 to "
        "5 % off, stiffness 4 to 8 %)",
        unit="recording",
        design=FIT_DESIGN,
    ),
    Decision(
        name=INNOVATIONS,
        distance="log of the mean NIS per measurement, in standard deviations over fault-free columns",
        rule=MISFIT_DESIGN.block(),
        place="rules.above",
        mean_time_between_false_alarms=1e4,
        demonstrated=Demonstrated(24.0),
        source="lognormal NIS; benches with parameter errors of 2 %, a minute each (0.68 to 2.1)",
        unit="recording",
        design=MISFIT_DESIGN,
    ),
)
"""Decisions of every variant."""


LEAST_READY = 5.0  # least time with a known torque for a finding [s]; some seconds of every state
# Ranges of torque [N*m] and angle [rad] below which the wheel stood still; noise and rounding of its sensors.
STILL_TORQUE, STILL_ANGLE = 0.1, math.radians(0.5)
LOCKED_TORQUE = 5.0  # range of the bar's torque above which a still wheel is locked rather than held by hands [N m]
# Duration above which stretches without hands are listed one by one [s]; driver assistance warns there or later.
LONG_OFF = 5.0
MOST_LISTED = 20  # largest number of listed stretches, the longest ones
# Factor between an angle in degrees and in radians, and tolerance on the logarithm of a ratio near that factor.
DEGREES, UNIT_MARGIN = math.degrees(1.0), 0.1

_STATED = "its angle changed by {angle:.2f} degrees, the torque of the bar by {torque:.2f} N·m"
_CORRECT = "correct the vehicle file, or identify the column; if the file is right, check gain and delay of the sensors"
CASES = {
    each.name: each
    for each in (
        Fact("sign", "{cause}", "a signal has the wrong sign", "correct the channel map and judge the recording again"),
        Fact(
            "too short",
            f"the driver torque could be estimated for {{ready:.1f}} s only; {LEAST_READY:g} s are needed",
            "estimated for {ready:.1f} s only",
            "record longer, with steering_wheel_angle and driver_torque throughout",
        ),
        Fact(
            "still",
            f"the wheel stood still: {_STATED}",
            "the wheel stood still",
            "record a drive, or let the motor turn the column",
        ),
        Fact(
            "locked",
            f"the wheel was locked: {_STATED}",
            "the wheel was locked",
            "record with the wheel free or in a driver's hands",
        ),
        Fact(
            "unit",
            "{larger} is {factor:.1f} times too large relative to {smaller} for a motor_ratio of {ratio:.4g}: one of "
            "them has degrees and radians confused",
            "degrees and radians are confused",
            _CORRECT,
        ),
        Fact(
            "inertia",
            "steering_wheel_inertia is {given:.3g} kg·m², but the motion without hands shows {there:.3g} "
            "(driver_torque over the acceleration of steering_wheel_angle)",
            "steering_wheel_inertia does not fit",
            _CORRECT,
        ),
        Fact(
            "ratio",
            "motor_ratio is {given:.4g}, but the ratio of the angles is {there:.4g} (motor_angle_mechanical over "
            "steering_wheel_angle)",
            "motor_ratio does not fit",
            _CORRECT,
        ),
        Fact("late", "{name} is about {lag:.0f} ms {when} relative to {others}", "{name} is {when}", _CORRECT),
        Fact(
            "stiffness",
            "torsion_bar_stiffness is {given:.3g} N·m/rad, but the twist of the bar shows {there:.3g} (driver_torque "
            "over steering_wheel_angle less motor_angle_mechanical)",
            "torsion_bar_stiffness does not fit",
            _CORRECT,
        ),
        Fact(
            "offset",
            "driver_torque is {offset:.2f} N·m too {way} for the twist of the bar (or steering_wheel_angle and "
            "motor_angle_mechanical, which should agree on the unloaded bar, differ by {turn:.2f} degrees); correct "
            "the offset in the channel map",
            "driver_torque has an offset",
            _CORRECT,
        ),
        Fact(
            "innovations",
            "the innovations of {signals} are {ratio:.2g} times as large as the observer expects; a signal may be "
            "late, have an offset or the wrong sign, or motor_inertia, gear_stiffness or the noise of the sensors may "
            "be wrong",
            "innovations are {ratio:.2g} times too large",
            _CORRECT,
        ),
        Fact("contradiction", "{cause}", "signals of the column contradict each other", _CORRECT),
        Fact(
            "no third",
            "steering_wheel_angle or driver_torque may be wrong; motor_angle_mechanical, named in the channel map or "
            "recorded, would show which",
        ),
        Fact("motor torque", "the angles and the torque of the bar fit each other, so that {motor} is suspected"),
        Fact(
            "motor inertia",
            "motor_inertia with that of the gear is {given:.2g} kg·m² at the motor's shaft, but the recording shows "
            "{there:.2g}; the disturbance torque is wrong by as much, the torque of the hands hardly affected",
            action="correct the vehicle file before the disturbance torque is used",
        ),
        Fact(
            "doubtful deviation",
            "the innovations of {signals} are {ratio:.1f} times as large as the observer expects: the standard "
            "deviation of the torque of the hands may be too small by this factor",
        ),
        Fact(
            "unchecked",
            "without motor_angle_mechanical gain and offset of driver_torque and of steering_wheel_angle are not "
            "checked",
        ),
        Fact("unsigned", "without motor_torque and motor_angle_mechanical the sign of driver_torque is not checked"),
        Fact(
            "ratio unknown",
            "motor_angle_mechanical is not used: motor_ratio is {given:.4g} ± {deviation:.2g} in the vehicle file, "
            "and the angles at the beginning do not determine it",
        ),
        Fact(
            "ratio found",
            "motor_ratio is {given:.4g} ± {deviation:.2g} in the vehicle file, but the ratio of the angles is "
            "{there:.4g}, which is used: enter motor_ratio = {there:.4g}",
        ),
    )
}
"""Sentences of the findings, by case."""


def judge(drive: Drive, vehicle: Vehicle, name: str, rules: FitRules, remarks: tuple[Fact, ...] = ()) -> Verdict:
    """The verdict over a drive; `remarks` are those on the adaptation of the observer."""
    evidence = _evidence(drive, vehicle, rules)
    if found := _obstacle(drive):
        return Verdict(name, found[0], found[1:], evidence=evidence)
    if wrong := misfits(drive, vehicle, rules):
        hidden = Fact("withheld", "the torque of the hands, and when they were on the wheel, are withheld")
        decided_by = tuple(each for each, distance in distances(drive, vehicle).items() if rules.beyond(each, distance))
        because = (*wrong, *_suspected(drive, wrong))
        return Verdict(
            name, Status.INCONSISTENT, because, evidence=evidence, decided_by=decided_by, facts=(hidden, *remarks)
        )
    evidence |= _value(drive)
    estimate, gain = None, torque_gain_deviation(vehicle)  # without a deviation there is no interval
    if drive.hand_deviation > 0.0:
        whole = math.hypot(drive.hand_deviation, gain.value * drive.hand_rms)
        assumed, given = gain.parts(drive.hand_rms)
        quantity = "torque of the driver's hands, rms"
        estimate = Estimate(quantity, drive.hand_rms, whole, "N*m", assumed=assumed, given=given)
    contradicts = drive.contradiction is not None and bool(drive.contradiction.names)
    status = Status.ESTIMATED if contradicts or drive.contradiction is None else Status.CONSISTENT
    share = drive.on / drive.ready if drive.ready > 0.0 else 0.0
    value = ", {estimate}" if estimate is not None else ""
    because = (Fact("hands", "", f"on the wheel {share:.0%}{value}", "none"),)
    details, facts = _details(drive, estimate, gain.value), (*_notes(drive, vehicle, rules), *remarks)
    return Verdict(name, status, because, estimate, evidence=evidence, details=details, facts=facts)


def _details(drive: Drive, estimate: Estimate | None, gain: float) -> tuple[str, ...]:
    share = drive.on / drive.ready if drive.ready > 0.0 else 0.0
    longest = max((each.duration for each in drive.stretches), default=0.0)
    unsure = f", {drive.uncertain / drive.ready:.0%} uncertain" if drive.uncertain > 0.005 * drive.ready else ""
    off = f"off for {longest:.1f} s at the longest" if longest > 0.0 else "never off"
    hands = f"hands on the wheel {share:.0%} of the time, {off}{unsure}"
    if estimate is None:
        return (hands, f"they give {drive.hand_rms:.2f} N·m rms, up to {abs(drive.peak):.2f} N·m")
    # With the same share of the gain, which scales every torque alike.
    deviation = math.hypot(drive.peak_deviation, gain * drive.peak)
    torque = f"they give {{estimate}} rms, up to {abs(drive.peak):.2f} ± {deviation:.2f} N·m"
    return (hands, torque, f"torque gain ± {100.0 * gain:.2g} % included")


def _notes(drive: Drive, vehicle: Vehicle, rules: FitRules) -> tuple[Fact, ...]:
    """What hardly affects the torque of the hands, or what the recording cannot reveal."""
    notes = []
    if drive.motor_inertia is not None and is_zeroed(vehicle) and "motor_inertia" in vehicle:
        gear = vehicle["gear_inertia"] / vehicle["motor_ratio"] ** 2 if "gear_inertia" in vehicle else 0.0
        expected = vehicle["motor_inertia"] + gear
        if rules.apart(math.log(drive.motor_inertia / expected), MOTOR_INERTIA_SPREAD):
            notes.append(CASES["motor inertia"].filled(given=expected, there=drive.motor_inertia))
    if drive.nis > 0.0 and misfit(drive.nis) > DOUBTED:
        notes.append(CASES["doubtful deviation"].filled(signals=_signals(drive), ratio=math.sqrt(drive.nis)))
    if drive.contradiction is None:
        unsigned = tuple(Fact("sign", each) for each in drive.doubts) or (CASES["unsigned"],)
        notes += (*(() if drive.motor else unsigned), CASES["unchecked"])
    elif drive.contradiction.names:
        notes.append(Fact("contradiction", described(drive.contradiction)))
    return tuple(notes)


def _obstacle(drive: Drive) -> tuple[Status, Fact] | None:
    if drive.turned:
        return Status.NOT_TESTABLE, CASES["sign"].filled(cause="; ".join(drive.turned))
    if drive.ready < LEAST_READY:
        return Status.NOT_ENABLED, CASES["too short"].filled(ready=drive.ready)
    if drive.angle_span < STILL_ANGLE and not STILL_TORQUE <= drive.torque_span <= LOCKED_TORQUE:
        case = CASES["still" if drive.torque_span < STILL_TORQUE else "locked"]
        return Status.NOT_ENABLED, case.filled(angle=math.degrees(drive.angle_span), torque=drive.torque_span)
    return None


def misfits(drive: Drive, vehicle: Vehicle, rules: FitRules) -> list[Fact]:
    """Contradictions between the vehicle file and the data."""
    if unit := _wrong_unit(drive, vehicle):
        return [unit]
    wrong = _of_the_column(drive, vehicle, rules)
    # A slow change of a gain or zero appears as a wrong stiffness, an offset or a delay, whichever fits best.
    found = drive.contradiction
    if wrong and found is not None and found.creeps:
        return [CASES["contradiction"].filled(cause=described(found))]
    # Signals that contradict each other make large innovations suspicious that alone would only be remarked on.
    if not wrong and found is not None and found.names and drive.nis > 0.0 and misfit(drive.nis) > DOUBTED:
        return [_surprising(drive)]
    return wrong


def _of_the_column(drive: Drive, vehicle: Vehicle, rules: FitRules) -> list[Fact]:
    """Contradictions on the assumption that each signal had a constant gain, offset and delay."""
    if is_late(drive, vehicle, rules):
        return _misshapen(drive, vehicle, rules)
    wrong, inertia = [], vehicle["steering_wheel_inertia"]
    if rules.apart(_departures(drive, vehicle)["inertia"], 1.0):
        wrong.append(CASES["inertia"].filled(given=inertia, there=inertia + drive.inertia_error))
    wrong += _misshapen(drive, vehicle, rules)
    if rules.misfit(drive.nis) and (drive.geometry is None or not wrong):
        wrong.append(_surprising(drive))
    return wrong


def _surprising(drive: Drive) -> Fact:
    return CASES["innovations"].filled(signals=_signals(drive), ratio=math.sqrt(drive.nis))


def _signals(drive: Drive) -> str:
    third = "" if drive.contradiction is None else ", motor_angle_mechanical"
    return f"steering_wheel_angle{third} and driver_torque"


def _suspected(drive: Drive, wrong: list[Fact]) -> tuple[Fact, ...]:
    """Signals that may be wrong instead of the vehicle file."""
    found = drive.contradiction
    if found is None:
        return (CASES["no third"],)
    if found.creeps:
        return ()
    if found.names:
        return (CASES["contradiction"].filled(cause=described(found)),)
    if drive.motor and all(each.name == "innovations" for each in wrong):
        return (CASES["motor torque"].filled(motor=drive.motor),)
    return ()


def _misshapen(drive: Drive, vehicle: Vehicle, rules: FitRules) -> list[Fact]:
    """Contradictions between angles and torque of the bar; a late signal distorts stiffness and offset."""
    found = drive.geometry
    if found is None:
        return []
    wrong, apart = [], _departures(drive, vehicle)
    if rules.apart(apart["ratio"], 1.0):
        wrong.append(CASES["ratio"].filled(given=vehicle["motor_ratio"], there=found.ratio))
    if is_late(drive, vehicle, rules):
        others = "the others" if found.lag > 0.0 else "both others, which may themselves be late"
        when = "late" if found.lag > 0.0 else "early"
        return [*wrong, CASES["late"].filled(name=found.late, lag=1e3 * abs(found.lag), when=when, others=others)]
    if rules.apart(apart["stiffness"], 1.0):
        wrong.append(CASES["stiffness"].filled(given=vehicle["torsion_bar_stiffness"], there=found.stiffness))
    elif rules.apart(apart.get("offset", 0.0), 1.0):
        offset, turn = found.torque_offset, math.degrees(abs(found.torque_offset) / found.stiffness)
        wrong.append(CASES["offset"].filled(offset=abs(offset), way="high" if offset > 0.0 else "low", turn=turn))
    return wrong


def is_late(drive: Drive, vehicle: Vehicle, rules: FitRules) -> bool:
    """Whether a signal is late by more than the sampling interval, and the observer's innovations confirm it."""
    unfit = math.isnan(drive.nis) or rules.misfit(drive.nis)
    return drive.geometry is not None and unfit and rules.apart(_departures(drive, vehicle)["lag"], 1.0)


def _wrong_unit(drive: Drive, vehicle: Vehicle) -> Fact | None:
    ratio = vehicle["motor_ratio"]
    factor = 1.0 if drive.geometry is None else drive.geometry.ratio / ratio
    if abs(abs(math.log(factor)) - math.log(DEGREES)) > UNIT_MARGIN:
        return None
    names = ("motor_angle_mechanical", "steering_wheel_angle")
    larger, smaller = names if factor > 1.0 else names[::-1]
    return CASES["unit"].filled(larger=larger, smaller=smaller, factor=DEGREES, ratio=ratio)


def distances(drive: Drive, vehicle: Vehicle) -> dict[str, float]:
    """Distances of the recording from the vehicle file [standard deviations], by the name of the decision."""
    furthest = max(_departures(drive, vehicle).values(), key=abs)
    innovations = {INNOVATIONS: misfit(drive.nis)} if drive.nis > 0.0 else {}
    return {COLUMN: furthest} | innovations


def ratio_spread(vehicle: Vehicle) -> float:
    """Relative standard deviation of the motor ratio; 0 where the file gives none, since `RATIO_SPREAD` is added."""
    known = vehicle.parameters["motor_ratio"]
    return (known.standard_deviation or 0.0) / known.value


def _departures(drive: Drive, vehicle: Vehicle) -> dict[str, float]:
    """Distance of each property of the column from that of the vehicle file [standard deviations]."""
    apart = {"inertia": drive.inertia_error / (INERTIA_SPREAD * vehicle["steering_wheel_inertia"])}
    if (found := drive.geometry) is None:
        return apart
    spread = math.hypot(RATIO_SPREAD, found.ratio_uncertainty, ratio_spread(vehicle))
    apart["ratio"] = (found.ratio / vehicle["motor_ratio"] - 1.0) / spread
    apart["lag"] = found.lag / LAG_SPREAD if abs(found.lag) > drive.sample_time else 0.0
    bar = found.stiffness / vehicle["torsion_bar_stiffness"]
    apart["stiffness"] = math.log(bar) / STIFFNESS_SPREAD if bar > 0.0 else -math.inf
    if is_zeroed(vehicle):
        apart["offset"] = (found.torque_offset - drive.torque_offset) / OFFSET_SPREAD
    return apart


def is_zeroed(vehicle: Vehicle) -> bool:
    """Whether the angles are zero on the unloaded bar, so that they reveal the offset of its torque."""
    return usual_tuning(vehicle).offset is None


def _value(drive: Drive) -> dict[str, float]:
    found = {
        "hands_on_s": drive.on,
        "hands_off_s": drive.off,
        "hands_uncertain_s": drive.uncertain,
        "longest_hands_off_s": max((each.duration for each in drive.stretches), default=0.0),
        "hands_off_stretches": float(len(drive.stretches)),
        "hand_torque_rms_Nm": drive.hand_rms,
        "hand_torque_peak_Nm": drive.peak,
    }
    if math.isfinite(drive.error):
        found["error_against_truth_rms_Nm"] = drive.error
    long = sorted((each for each in drive.stretches if each.duration > LONG_OFF), key=lambda each: -each.duration)
    for number, each in enumerate(sorted(long[:MOST_LISTED]), start=1):
        found[f"hands_off_{number}_from_s"] = each.start
        found[f"hands_off_{number}_for_s"] = each.duration
    return found


def _evidence(drive: Drive, vehicle: Vehicle, rules: FitRules) -> dict[str, float]:
    found = {
        "ready_s": drive.ready,
        "torsion_bar_torque_span_Nm": drive.torque_span,
        "steering_wheel_angle_span_rad": drive.angle_span,
        "learnt_torque_offset_Nm": drive.torque_offset,
        "learnt_inertia_error_kgm2": drive.inertia_error,
    }
    if math.isfinite(drive.nis):
        found["nis_mean"] = drive.nis
    if drive.geometry is not None:
        found["motor_ratio_in_recording"] = drive.geometry.ratio
        found["stiffness_in_recording_Nm_per_rad"] = drive.geometry.stiffness
        if is_zeroed(vehicle):
            found["torque_offset_in_recording_Nm"] = drive.geometry.torque_offset
        if is_late(drive, vehicle, rules):
            found[f"{drive.geometry.late}_lag_s"] = drive.geometry.lag
    return found
