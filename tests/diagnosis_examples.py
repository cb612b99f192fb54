"""Diagnoses as a pipeline would give them, for the tests of report and command line."""

import numpy as np

from tierod.core.findings import (
    ChannelQuality,
    Diagnosis,
    Element,
    Episode,
    Estimate,
    Finding,
    ParameterEffect,
    Status,
    Trace,
)


def trace(name, unit, time, values, spread=0.0):
    return Trace(name, unit, time, values - spread, values + spread, values)


def friction_fault(duration=3600.0, bins=2000, seed=1):
    """A simulated drive whose friction rises from 4 to 12.5 Nm half-way."""
    rng = np.random.default_rng(seed)
    time = np.linspace(0.0, duration, bins, endpoint=False)
    enabled = np.clip(np.convolve(rng.random(bins) > 0.6, np.ones(9) / 9, "same"), 0.0, 1.0)
    truth = np.where(time < duration / 2, 4.0, 12.5)
    friction, deviation = learnt(truth, enabled)
    speed = 20.0 + 8.0 * np.sin(time / 400.0)
    gap = (time > 0.3 * duration) & (time < 0.34 * duration)
    yaw_rate = np.where(gap, np.nan, 0.1 * np.sin(time / 37.0))
    angle = 0.6 * np.sin(np.linspace(0.0, 20.0 * np.pi, 1200)) * np.linspace(0.4, 1.0, 1200)
    return Diagnosis(
        findings=(fault_finding(duration),),
        traces={
            "friction": trace("friction", "N*m", time, friction, 0.05),
            "friction_standard_deviation": trace("friction_standard_deviation", "N*m", time, deviation),
            "true_friction": trace("true_friction", "N*m", time, truth),
            "enabled": trace("enabled", "", time, enabled),
            "vehicle_speed": trace("vehicle_speed", "m/s", time, speed, 1.0),
            "steering_wheel_angle": trace("steering_wheel_angle", "rad", time, 0.5 * np.sin(time / 11.0), 0.3),
            "yaw_rate": trace("yaw_rate", "rad/s", time, yaw_rate, 0.02),
            "driver_torque": trace("driver_torque", "N*m", time, 3.0 * np.sin(time / 13.0), 0.5),
            "normalised_innovation": trace("normalised_innovation", "", time, rng.normal(0.0, 0.3, bins), 2.0),
        },
        histograms=histograms(rng),
        loops={
            "before": (angle, 6.0 * np.tanh(angle) + 4.0 * np.sign(np.gradient(angle))),
            "after": (angle, 6.0 * np.tanh(angle) + 12.5 * np.sign(np.gradient(angle))),
        },
        consistency={"mean_nis": 0.97, "nis_within_95_percent_share": 0.948, "degrees_of_freedom": 1.0},
        quality=qualities(duration),
        parameters=(
            ("mass", 1600.0, "kg", 120.0, "assumed: typical mid-size car with driver and fuel"),
            ("yaw_inertia", 2800.0, "kg*m**2", 300.0, "assumed: typical for this mass and wheelbase"),
            ("front_cornering_stiffness", 110e3, "N/rad", 20e3, "assumed: both front tyres together"),
            ("steering_ratio", 1 / 15.5, "", None, "assumed: 1/15.5"),
            ("nominal_friction", 4.0, "N*m", 0.5, "Mohtat et al., Table 1: healthy vehicle"),
        ),
        recording={"name": "drive.parquet", "duration_s": duration, "rate_hz": 100.0, "start_time": "2026-11-21 09:00"},
        vehicle={"name": "midsize-eps", "torque_unit": "N*m", "not_good_for": ["a friction in N*m of a real car"]},
        version="0.1.0",
        command="tierod diagnose drive.parquet --vehicle midsize-eps",
        created="2026-11-21T10:00:00+00:00",
    )


def learnt(truth, enabled):
    estimate, value = [], 3.0
    for goal, share in zip(truth, enabled, strict=True):
        value += 0.06 * share * (goal - value)
        estimate.append(value)
    return np.array(estimate), 0.08 + 4.9 / (1.0 + 3.0 * np.cumsum(enabled))


def fault_finding(duration):
    return Finding(
        monitor="friction, dahl",
        status=Status.FAULT,
        headline="The friction of the steering rose to three times what it was.",
        since=duration / 2 + 11.0,
        estimate=Estimate(
            "friction torque at the steering wheel axis",
            12.43,
            0.11,
            "N*m",
            {"nominal": 4.0, "learnt level": 4.05, "rising level": 4.8, "fault level": 7.5},
        ),
        evidence={"enabled_seconds": 1310.0, "enabled_share": 0.364, "ratio_to_learnt_level": 3.07, "mean_nis": 0.97},
        cause="The estimate passed the fault level of 7.5 Nm and stayed above it, both sides excited.",
        action="Inspect the intermediate shaft's joints and the rack; then repeat lock to lock.",
        warnings=("Torque gains are not identifiable: a common 10 % error of both torques is 10 % of the friction.",),
    )


def histograms(rng):
    edges = np.linspace(0.0, 15.0, 61)
    levels = (("0 to 15 min", 3.9), ("15 to 30 min", 4.0), ("30 to 45 min", 12.1), ("45 to 60 min", 12.4))
    return {name: (edges, np.histogram(rng.normal(level, 0.2, 4000), edges)[0]) for name, level in levels}


def qualities(duration):
    count = int(100 * duration)
    nan = float("nan")
    return (
        ChannelQuality("steering_wheel_angle", "rad", "CAN EPS_1.Angle", count, 100.0, 0.0, 0.01, -8.1, 7.9),
        ChannelQuality(
            "yaw_rate", "rad/s", "CAN IMU_1.Yaw", count, 100.0, 0.04, 144.0, -0.4, 0.4, ("the longest gap lasts 144 s",)
        ),
        ChannelQuality("motor_torque", "N*m", "", 0, nan, 1.0, nan, nan, nan, ("holds no samples",)),
    )


def healthy():
    """A healthy finding with an estimate and little else."""
    estimate = Estimate(
        "friction torque at the steering wheel axis", 4.02, 0.05, "N*m", {"nominal": 4.0, "fault level": 7.5}
    )
    finding = Finding(
        "friction, dahl", Status.HEALTHY, "The friction of the steering is as it should be.", estimate=estimate
    )
    return Diagnosis(findings=(finding,), recording={"name": "healthy.csv"}, version="0.1.0")


def not_identifiable():
    """What a minute on a motorway with raw torques gives: no value."""
    finding = Finding(
        monitor="friction, dahl",
        status=Status.NOT_IDENTIFIABLE,
        headline="The friction cannot be identified on this drive.",
        evidence={"enabled_seconds": 2.6, "needed_seconds": 50.0, "nis": float("nan")},
        cause="The enabling conditions held for 2.6 s only; torques are raw counts; <lane keeping> was active.",
        action="Record ten minutes with town driving, lane keeping off; give the scale of the torques.",
        warnings=("Torques are raw counts: no friction in Nm can be given.",),
    )
    return Diagnosis(findings=(finding,), vehicle={"name": "rav4", "torque_unit": "count"})


def several_elements():
    """Six states: a sensor with two faults, two actuators not isolable from each other, and one not judged."""
    offset = Estimate("offset of the yaw rate", 0.29, 0.004, "rad/s")
    shorter = Episode("outlier", 12.0, 12.4)
    longer = Episode("positive offset", 31.2, None, offset)
    together = Episode("", 40.0, 44.5, None, ("steering_motor_2",))
    elements = (
        Element("yaw_rate", "sensor", Status.FAULT, "", (shorter, longer), "angle and speed (0.008 rad/s)", "C1A33-64"),
        Element("steering_wheel_angle", "sensor", Status.HEALTHY),
        Element("tie_rod_force", "sensor", Status.NOT_AVAILABLE, "the recording has no tie_rod_force"),
        Element("wheel_speed_rear_left", "sensor", Status.NOT_TESTABLE, "the vehicle stood throughout"),
        Element("steering_motor_1", "actuator", Status.SUSPECT, "", (together,)),
    )
    finding = Finding("condition, bank", Status.FAULT, "The yaw rate sensor has an offset since 31.2 s.", 31.2)
    return Diagnosis(findings=(finding,), elements=elements, recording={"name": "lap.mf4"}, version="0.1.0")


def estimated():
    """A sideslip that nothing confirms, whose band a guessed distance decides."""
    estimate = Estimate("largest sideslip angle at the centre of gravity", -0.246, 0.061, "rad")
    finding = Finding(
        "sideslip, combined", Status.ESTIMATED, "Sideslip angle up to −14.09 ± 3.49 degrees.", estimate=estimate
    )
    return Diagnosis(
        findings=(finding,),
        parameter_effects=(
            ParameterEffect("rear_distance", 1.2, 0.3, "m", 0.0605, "rad", 0.99),
            ParameterEffect("steering_ratio", 0.0662, 0.005, "", -0.0019, "rad", 0.01),
        ),
        remarks={"parameters": "mass has no standard deviation; that of the class 'midsize' is assumed."},
        vehicle={"name": "my-car", "torque_unit": "N*m"},
    )


def nothing():
    """No monitor ran."""
    return Diagnosis(findings=())


EXAMPLES = {
    "friction_fault": friction_fault,
    "healthy": healthy,
    "not_identifiable": not_identifiable,
    "several_elements": several_elements,
    "estimated": estimated,
    "nothing": nothing,
}
