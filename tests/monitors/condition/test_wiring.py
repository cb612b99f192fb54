"""What is wired, scaled or timed wrongly from the start is named as such, and no element is accused for it."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.core.statuses import Status
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.limits import NAME
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load

VEHICLE = load("smartload")
CALIBRATED = replace(VEHICLE, thresholds=VEHICLE.thresholds | {NAME: {**VEHICLE.thresholds[NAME], "calibrated": 1.0}})
CAR = VEHICLE.parameters_for(AutomatedVehicle.Parameters)
RATE, SECONDS, SPEED = 100.0, 60.0, 8.0
LEFT, RIGHT = "wheel_speed_rear_left", "wheel_speed_rear_right"


def turning(speed=SPEED):
    """A car without slip that weaves as chance has it, its signals without error."""
    rng = np.random.default_rng(4)
    count = round(SECONDS * RATE)
    rough = np.convolve(rng.normal(size=count + 400), np.hanning(200) / 100.0, "same")[200:-200]
    yaw_rate = 0.3 * rough / rough.std()
    angle = yaw_rate / speed * (CAR.front_distance + CAR.rear_distance) / CAR.steering_ratio
    force = 4000.0 * yaw_rate
    torque = CAR.rack_ratio * (force + CAR.rack_ratio * CAR.rack_stiffness * angle)
    half = 0.5 * CAR.track_width * yaw_rate
    return {
        LEFT: CAR.wheel_speed_scale * (speed - half),
        RIGHT: CAR.wheel_speed_scale * (speed + half),
        "yaw_rate": yaw_rate,
        "steering_wheel_angle": angle,
        "steering_shaft_torque": torque,
        "tie_rod_force": force,
        "longitudinal_acceleration": np.zeros(count),
        "lateral_acceleration": speed * yaw_rate,
        "steering_motor_1_target_torque": 0.5 * torque,
        "steering_motor_2_target_torque": 0.5 * torque,
        "target_drive_torque_left": np.zeros(count),
        "target_drive_torque_right": np.zeros(count),
    }


def leading():
    """The car, its angle a tenth of a second ahead of all motion, as that of a real one is."""
    signals = turning()
    return signals | {"steering_wheel_angle": np.roll(signals["steering_wheel_angle"], -10)}


def found(signals, vehicle=VEHICLE):
    time = np.arange(len(signals["yaw_rate"])) / RATE
    channels = {name: Channel(name, time, values, SIGNALS[name].unit) for name, values in signals.items()}
    return diagnose(Recording(channels), vehicle, "condition", spread=False)


def cause(signals, vehicle=VEHICLE):
    """Cause of a finding that names wrong wiring, which accuses no element; "" where it names none."""
    diagnosis = found(signals, vehicle)
    finding = diagnosis.findings[0]
    if finding.status is not Status.NOT_TESTABLE or not ("channel map" in finding.action or "time" in finding.action):
        return ""
    assert {each.status for each in diagnosis.elements} <= {Status.NOT_TESTABLE, Status.NOT_AVAILABLE}
    return finding.cause


def scaled(signals, **factors):
    return signals | {name: factor * signals[name] for name, factor in factors.items()}


def test_nothing_is_wrong_with_what_is_right_nor_with_what_tyres_and_radii_do():
    assert cause(turning()) == ""
    assert cause(scaled(turning(), steering_wheel_angle=1.25)) == ""


@pytest.mark.parametrize(
    ("factors", "said"),
    [
        ({"yaw_rate": -1.0}, "the yaw rate has the wrong sign"),
        ({"steering_wheel_angle": -1.0}, "the steering angle has the wrong sign"),
        ({"steering_shaft_torque": -1.0}, "torque"),
        ({"tie_rod_force": -1.0}, "tie"),
        ({"lateral_acceleration": -1.0}, "the lateral acceleration has the wrong sign"),
        ({"steering_wheel_angle": 1.5}, "the steering ratio .* is wrong: it is 1.5 times"),
        ({"steering_wheel_angle": 0.6}, "the steering ratio .* is wrong: it is 0.6 times"),
        ({"lateral_acceleration": 1 / 9.81}, "the lateral acceleration has the wrong unit or scale: it is 0.102 times"),
        ({LEFT: 3.6, RIGHT: 3.6}, "the wheel speeds have the wrong unit or scale: they are 3.6 times"),
        ({LEFT: 1 / 3.6, RIGHT: 1 / 3.6}, "the wheel speeds have the wrong unit or scale: they are 0.278 times"),
        ({LEFT: 1.609, RIGHT: 1.609}, "the wheel speeds have the wrong unit or scale: they are 1.61 times"),
    ],
)
def test_a_wrong_sign_or_scale_is_named_with_its_size(factors, said):
    assert re.search(said, cause(scaled(turning(), **factors)))


def test_wheel_speeds_in_km_h_are_named_without_the_lateral_acceleration_too():
    signals = scaled(turning(), **{LEFT: 3.6, RIGHT: 3.6, "lateral_acceleration": np.nan})
    assert cause(signals).startswith("the values of wheel speed rear left and wheel speed rear right look like km/h")


def test_swapped_wheels_are_named():
    signals = turning()
    assert "left and right rear wheel speeds are swapped" in cause(
        signals | {LEFT: signals[RIGHT], RIGHT: signals[LEFT]}
    )


@pytest.mark.parametrize(
    ("late", "said"), [(0.4, "yaw rate sensor: 0.30 s late"), (-0.4, "yaw rate sensor: 0.50 s early")]
)
def test_a_bus_with_a_clock_of_its_own_is_named(late, said):
    signals = turning()
    assert said in cause(signals | {"yaw_rate": np.roll(signals["yaw_rate"], round(late * RATE))})


@pytest.mark.slow  # compiles the bank of a calibrated vehicle
@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda s: scaled(s, lateral_acceleration=1.3), ""),
        (lambda s: scaled(s, steering_wheel_angle=1.25), "it is 1.2"),
        (lambda s: s | {"yaw_rate": np.roll(s["yaw_rate"], 6)}, "yaw rate sensor: 0.06 s late"),
    ],
)
def test_a_calibrated_vehicle_has_tighter_limits(change, said):
    assert said in cause(change(leading()), CALIBRATED)
    assert cause(change(leading())) == ""
    assert said or not cause(change(leading()), CALIBRATED)


@pytest.mark.parametrize(("step", "first"), [(2, 0), (10, 3)], ids=["50 Hz", "10 Hz"])
def test_buses_slower_than_the_grid_are_looked_at_too(step, first):
    slow = {LEFT, RIGHT, "yaw_rate", "steering_wheel_angle", "lateral_acceleration"}
    places = np.arange(round(SECONDS * RATE))

    def slower(signals):
        return {
            name: np.where((places % step == first) | (name not in slow), values, np.nan)
            for name, values in signals.items()
        }

    assert cause(slower(leading())) == ""
    assert "the yaw rate has the wrong sign" in cause(slower(scaled(turning(), yaw_rate=-1.0)))


def test_a_bus_that_loses_frames_and_a_wheel_alone_are_looked_at_too():
    rng, signals = np.random.default_rng(7), scaled(turning(), yaw_rate=-1.0)
    lossy = {
        name: np.where((rng.random(len(values)) < 0.1) & ("target" not in name), np.nan, values)
        for name, values in signals.items()
    }
    assert "the yaw rate has the wrong sign" in cause(lossy)
    assert "the yaw rate has the wrong sign" in cause(signals | {LEFT: np.full(len(signals[LEFT]), np.nan)})


def test_what_becomes_wrong_on_the_way_is_left_to_the_monitor():
    signals = turning()
    angle = signals["steering_wheel_angle"].copy()
    angle[len(angle) // 2 :] *= -1.0
    assert cause(signals | {"steering_wheel_angle": angle}) == ""
