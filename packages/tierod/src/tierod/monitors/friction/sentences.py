"""The words of every fact on friction: cause, remedy and reason, with the figures of a run in braces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

TOO_LOW = (
    "the gains of driver_torque and motor_torque or motor_ratio may be too low, or the vehicle file is that of another "
    "car; a fault may then be judged healthy"
)
"""What a friction far below that of a fault-free car means."""

SETTLE = (
    "calibrate driver_torque and motor_torque, judge against this car's baseline from an earlier fault-free drive, or "
    "measure the friction in a lock-to-lock test"
)


class Words(NamedTuple):
    """Words of a fact with the figures of a run in braces: cause, remedy, and the reason in a headline."""

    cause: str
    action: str = ""
    reason: str = ""


OBSTACLES: Mapping[str, Words] = {
    "no_signals": Words(
        "the signals were never all present at once for the settling time",
        "find the missing signal with 'tierod inspect', and check the channel map",
        "signals were never all present",
    ),
    "raw_counts": Words(
        "the torques are raw counts, not N·m, so friction has no unit and no nominal value",
        "give the torque per count in the channel map (calibrate against a torque wrench or a lock-to-lock recording)",
        "the torques are raw counts",
    ),
    "wrong_sign": Words(
        "driver and motor torque have opposite signs for {opposed:.0%} of the time in which the driver turned the "
        "wheel: one of them has the wrong sign",
        "check the signs in the channel map: both are positive towards the left",
        "one torque has the wrong sign",
    ),
    "opposed": Words(
        "driver and motor torque act against each other for {opposed:.0%} of the time in which the driver turned the "
        "wheel, as under lane keeping",
        "record with lane keeping and other steering functions switched off",
        "driver and motor oppose each other",
    ),
    "never_enabled": Words(
        "the enabling conditions never held at the same time: {closed_by}",
        "{remedy}",
        "the enabling conditions never held",
    ),
    "too_little_time": Words(
        "the enabling conditions held for {enabled:.1f} s only, {ready:.0f} s are needed: {closed_by}",
        "record longer; {remedy}",
        "{enabled:.0f} of {ready:.0f} s needed",
    ),
    "negative": Words(
        "the estimated {negative} is negative, which is physically impossible: a signal has the wrong sign",
        "check the signs in the channel map; in a left turn angle, yaw rate, lateral acceleration and both torques are "
        "positive",
        "the {negative} is negative",
    ),
    "damping": Words(
        "the learnt damping is {damping:.1f} N·m·s/rad, too low for any steering: the signals contradict each other",
        "check the sign of the steering wheel rate against the angle, the units of yaw rate (rad/s) and lateral "
        "acceleration (m/s²), and the delays between the signals",
        "the signals contradict each other",
    ),
    "aligning": Words(
        "the self-aligning torque is {aligning:.2f} times the value from the vehicle file; a wrong trail explains only "
        "factors from 1/3 to 3",
        "check the units of yaw rate (rad/s) and lateral acceleration (m/s²), and whether the vehicle file (mass, "
        "trail, steering ratio) belongs to this car",
        "the self-aligning torque does not fit",
    ),
    "unfit": Words(
        "the torque balance does not fit: its residual is {residual:.1f} N·m (root mean square)",
        "check with 'tierod inspect' for a signal that is stuck, has the wrong sign or unit (rad, rad/s, m/s², N·m), "
        "or is late, and whether the vehicle file belongs to this car",
        "the torque balance does not fit",
    ),
    "short_strokes": Words(
        "the strokes of the steering wheel are shorter than friction needs to build up (mean build-up "
        "{excitation:.0%}), so friction cannot be distinguished from stiffness",
        "drive bends with strokes of several degrees: city or country roads",
        "the steering strokes are too short",
    ),
    "uncertain": Words(
        "the standard deviation is {uncertainty:.0%} of the friction, above {allowed:.0%}{misfit}",
        "record longer on bends; if that does not help, check the vehicle file and the delays between the signals",
        "the standard deviation is {uncertainty:.0%} of it",
    ),
}

GROUNDS: Mapping[str, Words] = {
    "by_limit": Words(
        "friction is above the limit of the vehicle file by more than {margin} of {limit.uncertain}: "
        "{limit.absolute:.4g} N·m, with this margin {limit.absolute_from:.2f} N·m"
    ),
    "by_baseline": Words(
        "friction rose to {ratio:.2f} times {level}; {status} from {limit.ratio:.4g} times "
        "({limit.relative_from:.2f} N·m)"
    ),
    "fault": Words(
        "", "inspect column joints, bearings, steering gear and motor for corrosion, water or damage before driving on"
    ),
    "within_fault_margin": Words(
        "it is above the fault limit of {fault.absolute:.4g} N·m, but within the margin of {fault.uncertain} (up to "
        "{fault.absolute_from:.2f} N·m)",
        f"have the steering inspected now, and to find out whether it is a fault, {SETTLE}",
    ),
    "close": Words(
        "",
        "friction is close to a fault, which begins at {fault.acts_from:.2f} N·m: inspect the boots of the steering "
        "gear, joints and bearings now, and record again",
    ),
    "watch": Words(
        "", "watch it: record again within days, and inspect the boots of the steering gear at the next service"
    ),
    "implausible": Words(
        "friction is implausible: {share:.2f} times nominal, below the plausible minimum of {least:.2g}; motor_torque "
        "or driver_torque may be clipped or its gain too low, or motor_ratio may be wrong",
        "check range and gain of both torques, and motor_ratio in the vehicle file, and record again; until then a "
        "fault may stay undetected",
        "implausibly low, {{estimate}}",
    ),
    "pending": Words(
        "at the end friction was {above}; the recording ended, or signals were lost, before this was confirmed",
        reason="above a limit at the end",
    ),
    "episode": Words(
        "friction was above a limit for {alarm:.0f} s of enabled time and fell back",
        reason="was above a limit, and fell",
    ),
    "again": Words(
        "",
        "record again, with all signals to the end; if the excess returns, inspect column joints, steering gear and "
        "boots for water",
    ),
    "fallen": Words(
        "friction stayed below every limit, but it is only {ratio:.2f} times {level}: the gains of driver_torque or "
        "motor_torque may have changed since, or that level was learnt in the cold or on another car; a fault may then "
        "be judged healthy",
        "check the gains of driver_torque and motor_torque, judge a lock-to-lock test, and learn the baseline anew if "
        "the lower level is right",
    ),
    "low": Words(
        f"friction stayed below every limit, but it is only {{share:.2f}} times nominal: {TOO_LOW}",
        f"before this level is stored as that of a fault-free car, {SETTLE}",
    ),
    "within_margin": Words(
        "friction is {within}",
        f"before this level is stored as that of a fault-free car, find out whether it has risen: {SETTLE}",
    ),
    "within_margin_of_baseline": Words(
        "friction is {within}; compared with the given baseline it has not risen",
        "none if the baseline comes from a fault-free car; otherwise calibrate driver_torque and motor_torque, or make "
        "a lock-to-lock test",
    ),
    "below_limits": Words("friction stayed below every limit", "none; store the learnt level for the next recording"),
    "below_limits_of_baseline": Words("friction stayed below every limit", "none"),
}

ANOTHER = "or the map is that of another car"
TOGETHER = "motor_torque over driver_torque is {ratio:.2g} times what the map gives"
CONTRADICT = "driver_torque, motor_torque and the assist map of the vehicle file contradict each other"

DEFECTS: Mapping[str, Words] = {
    "changed": Words(
        "motor_torque differs by up to {changed:.0%} from what it was at the beginning of the drive for the same "
        "driver_torque, vehicle_speed and steering_wheel_angle: gain or zero of one of them, or the assist mode, has "
        "changed",
        reason="the assist changed in the drive",
    ),
    "gain": Words(
        "{name} has {gain:.2f} times the gain that fits the assist map of the vehicle file: "
        f"{TOGETHER}; the gain is wrong, {ANOTHER}",
        reason="{name} has a wrong gain",
    ),
    "gains": Words(
        f"{CONTRADICT}: {TOGETHER}, which a gain of one torque alone does not explain; gains of both are wrong, "
        f"{ANOTHER}",
        reason="torques and assist map contradict each other",
    ),
    "bend": Words(
        f"{CONTRADICT}: the assist bends at another torque, as with gains of {{driver:.2g}} and {{motor:.2g}}; both "
        f"gains are wrong, {ANOTHER}",
        reason="torques and assist map contradict each other",
    ),
}
"""Defects of the torques over a drive."""

NOTES: Mapping[str, str] = {
    "gain": "a gain error common to both torques scales the estimate and cannot be detected: 10 % of torque gives 10 % "
    "of friction. The standard deviation includes {gain} of it ({gain_source}); it cancels in the ratio to the "
    "baseline",
    "no_level": "the baseline is not learnt (too little time, or friction above its limit): only the absolute limits "
    "apply",
    "rigid_bar": "the vehicle file gives no torsion_bar_stiffness, so the column is assumed rigid: with a bar of 140 "
    "N·m/rad the estimate is then right at 4 N·m and 0.2 to 0.5 N·m too high at 12.5 N·m, and the build-up angle is "
    "too long",
    "negative_inertia": "the learnt inertia is negative ({inertia:.3f} kg·m²): a signal is probably late. Torques that "
    "are 50 ms late lower the friction estimate by 0.2 to 0.4 N·m, 100 ms by 0.5 to 0.8 N·m; a lateral acceleration "
    "that is 0.5 s late raises it by 0.9 to 1.9 N·m",
    "large_inertia": "the learnt inertia is {inertias:.1f} times that of the vehicle file: the angle is probably about "
    "100 ms later than the torques, and the friction estimate slightly too high",
    "large_damping": "the learnt damping is {dampings:.1f} times that of the vehicle file: either this car has more "
    "damping, or yaw rate and lateral acceleration are late; a delay of 200 ms raises the friction estimate by 0.5 to "
    "0.6 N·m",
    "aligning": "the self-aligning torque is {aligning:.2f} times the value from the vehicle file: check that mass, "
    "trail and steering ratio belong to this car",
    "absent": "signals were missing, or had just begun, for {absent:.0%} of the recording: the verdict covers only "
    "the rest",
    "one_sided": "{left:.0%} of the enabled time was spent in left turns: sensor offsets may bias the friction "
    "estimate",
    "other_assist": "motor_torque depends on vehicle_speed otherwise than the assist map of the vehicle file for the "
    "same driver_torque: the gains of both torques are not checked by this map",
    "opposed": "driver and motor torque opposed each other for {opposed:.0%} of the time in which the driver turned "
    "the wheel: check whether lane keeping was active",
}
"""Notes beside a verdict."""
