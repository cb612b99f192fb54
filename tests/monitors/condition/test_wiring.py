"""What is wired, scaled or timed wrongly is found from made-up motion; faults on the way are left alone."""

import numpy as np
import pytest

from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.definition import CONDITION
from tierod.monitors.condition.wiring import CLOSE_LATE, CLOSE_SCALE, Wiring
from tierod.vehicles import load

CAR = load("smartload").parameters_for(AutomatedVehicle.Parameters)
RATE, SECONDS, SPEED = 100.0, 120.0, 8.0


def turning(seconds=SECONDS, speed=SPEED):
    """A car without slip that weaves as chance has it, its signals without error."""
    rng = np.random.default_rng(4)
    count = round(seconds * RATE)
    rough = np.convolve(rng.normal(size=count + 400), np.hanning(200) / 100.0, "same")[200:-200]
    yaw_rate = 0.3 * rough / rough.std()
    angle = yaw_rate / max(speed, 0.1) * (CAR.front_distance + CAR.rear_distance) / CAR.steering_ratio
    force = 4000.0 * yaw_rate
    torque = CAR.rack_ratio * (force + CAR.rack_ratio * CAR.rack_stiffness * angle)
    half = 0.5 * CAR.track_width * yaw_rate
    return {
        "wheel_speed_rear_left": CAR.wheel_speed_scale * (speed - half),
        "wheel_speed_rear_right": CAR.wheel_speed_scale * (speed + half),
        "yaw_rate": yaw_rate,
        "steering_wheel_angle": angle,
        "steering_shaft_torque": torque,
        "tie_rod_force": force,
        "lateral_acceleration": speed * yaw_rate,
        "steering_motor_1_target_torque": 0.5 * torque,
        "steering_motor_2_target_torque": 0.5 * torque,
    }


def problems(signals, piece=1000, calibrated=False):
    wiring = Wiring(CAR, RATE, calibrated)
    for start in range(0, len(signals["yaw_rate"]), piece):
        wiring.add({name: values[start : start + piece] for name, values in signals.items()})
    return wiring.problems()


def changed(**factors):
    signals = turning()
    return signals | {name: factor * signals[name] for name, factor in factors.items()}


def test_nothing_is_wrong_with_what_is_right():
    assert problems(turning()) == ()


def test_the_lead_of_the_lateral_acceleration_at_low_speed_is_no_shift():
    signals = turning(speed=3.0)
    ahead = signals["lateral_acceleration"] + CAR.rear_distance * np.gradient(signals["yaw_rate"]) * RATE
    assert problems(signals | {"lateral_acceleration": ahead}) == ()


def test_swapped_wheels_are_reported():
    signals = turning()
    left, right = "wheel_speed_rear_left", "wheel_speed_rear_right"
    (problem,) = problems(signals | {left: signals[right], right: signals[left]})
    assert problem.elements == (left, right)
    assert "swapped" in problem.cause


@pytest.mark.parametrize(
    "name", ["yaw_rate", "steering_wheel_angle", "steering_shaft_torque", "tie_rod_force", "lateral_acceleration"]
)
def test_a_wrong_sign_is_reported(name):
    (problem,) = problems(changed(**{name: -1.0}))
    assert problem.kind == "sign"
    assert problem.elements in ((name,), ())
    assert name.split("_")[0] in problem.cause


@pytest.mark.parametrize(
    ("name", "factor", "result"),
    [
        ("steering_wheel_angle", 1.5, "steering ratio"),
        ("steering_wheel_angle", 0.6, "steering ratio"),
        ("yaw_rate", 57.3, "yaw rate has the wrong unit"),
        ("lateral_acceleration", 1 / 9.81, "lateral acceleration has the wrong unit"),
    ],
)
def test_a_wrong_scale_is_reported_with_its_size(name, factor, result):
    (problem,) = problems(changed(**{name: factor}))
    assert problem.kind == "scale"
    assert result in problem.cause
    assert f"it is {factor:.3g} times" in problem.cause


@pytest.mark.parametrize(("factor", "result"), [(3.6, "3.6 times"), (1.0 / 3.6, "0.278 times"), (1.609, "1.61 times")])
@pytest.mark.parametrize("calibrated", [False, True])
def test_wheel_speeds_in_another_unit_are_reported_and_not_the_yaw_rate(factor, result, calibrated):
    signals = leading() if calibrated else turning()
    wheels = ("wheel_speed_rear_left", "wheel_speed_rear_right")
    (problem,) = problems(signals | {name: factor * signals[name] for name in wheels}, calibrated=calibrated)
    assert problem.elements == wheels
    assert "wheel speeds have the wrong unit" in problem.cause
    assert result in problem.cause


@pytest.mark.parametrize("factor", [0.8, 1.25])
def test_what_tyres_and_radii_do_is_no_wrong_scale(factor):
    assert problems(changed(steering_wheel_angle=factor)) == ()


@pytest.mark.parametrize(("late", "result"), [(0.4, "late"), (-0.4, "early")])
def test_a_bus_with_a_clock_of_its_own_is_reported(late, result):
    signals = turning()
    shift = round(late * RATE)
    (problem,) = problems(signals | {"yaw_rate": np.roll(signals["yaw_rate"], shift)})
    assert problem.kind == "time"
    assert problem.elements == ("yaw_rate",)
    assert result in problem.cause


def leading():
    """The car, its angle a tenth of a second ahead of all motion, as that of a real one is."""
    signals = turning()
    return signals | {"steering_wheel_angle": np.roll(signals["steering_wheel_angle"], -10)}


def test_a_calibrated_vehicle_has_tighter_limits():
    signals = leading()
    assert problems(signals | {"lateral_acceleration": 1.3 * signals["lateral_acceleration"]}, calibrated=True) == ()
    geared = signals | {"steering_wheel_angle": 1.25 * signals["steering_wheel_angle"]}
    (problem,) = problems(geared, calibrated=True)
    assert (problem.kind, problem.elements) == ("scale", ("steering_wheel_angle",))
    assert "it is 1.2" in problem.cause
    assert problems(geared) == ()


@pytest.mark.parametrize(("late", "result"), [(0.06, "0.06 s late"), (-0.07, "0.07 s early")])
def test_a_small_shift_is_reported_between_two_steps_for_a_calibrated_vehicle(late, result):
    signals = leading()
    shifted = signals | {"yaw_rate": np.roll(signals["yaw_rate"], round(late * RATE))}
    (problem,) = problems(shifted, calibrated=True)
    assert problem.elements == ("yaw_rate",)
    assert result in problem.cause
    assert problems(shifted) == ()


@pytest.mark.parametrize("every", [(2, 0), (10, 3)], ids=["50 Hz", "10 Hz"])
def test_buses_slower_than_the_grid_are_looked_at_too(every):
    step, first = every

    def slower(signals):
        places = np.arange(len(signals["yaw_rate"]))
        return {name: np.where(places % step == first, values, np.nan) for name, values in signals.items()}

    with np.errstate(all="raise"):
        assert problems(slower(leading()), calibrated=True) == ()
    assert [each.elements for each in problems(slower(changed(yaw_rate=-1.0)))] == [("yaw_rate",)]


def test_a_bus_that_loses_a_tenth_of_its_frames_is_looked_at_too():
    rng = np.random.default_rng(7)
    signals = changed(steering_wheel_angle=1.6)
    lossy = {name: np.where(rng.random(len(values)) < 0.1, np.nan, values) for name, values in signals.items()}
    (problem,) = problems(lossy)
    assert "steering ratio" in problem.cause


def test_what_becomes_wrong_on_the_way_is_left_to_the_monitor():
    signals = turning()
    angle = signals["steering_wheel_angle"].copy()
    angle[len(angle) // 2 :] *= -1.0
    assert problems(signals | {"steering_wheel_angle": angle}) == ()


def test_a_long_halt_hides_nothing():
    signals = changed(steering_wheel_angle=1.6)
    halted = {name: np.concatenate([values, np.zeros(round(SECONDS * RATE))]) for name, values in signals.items()}
    (problem,) = problems(halted)
    assert problem.elements == ("steering_wheel_angle",)


def test_an_acceleration_that_is_off_for_a_while_hides_no_sensor_of_a_calibrated_vehicle():
    signals = leading()
    banked = signals["lateral_acceleration"] * np.where(np.arange(len(signals["yaw_rate"])) < 3000, 0.65, 1.0)
    geared = {"steering_wheel_angle": 1.25 * signals["steering_wheel_angle"], "lateral_acceleration": banked}
    (problem,) = problems(signals | geared, calibrated=True)
    assert problem.elements == ("steering_wheel_angle",)


def test_without_turning_nothing_is_reported():
    signals = turning()
    straight = {name: 0.01 * values for name, values in signals.items()} | {
        name: np.full(len(signals["yaw_rate"]), SPEED) for name in ("wheel_speed_rear_left", "wheel_speed_rear_right")
    }
    assert problems(straight | {"yaw_rate": -straight["yaw_rate"]}) == ()
    assert Wiring(CAR, RATE).problems() == ()


def test_a_missing_sensor_and_a_lost_one_are_no_wrong_wiring():
    signals = turning()
    missing = np.full(len(signals["yaw_rate"]), np.nan)
    assert problems(signals | {"tie_rod_force": missing}) == ()
    assert problems(signals | {"lateral_acceleration": missing}) == ()
    assert problems(signals | {"steering_wheel_angle": 0.0 * missing}) == ()
    assert problems(signals | {"steering_wheel_angle": np.zeros(len(missing))}) == ()


@pytest.mark.parametrize("gone", ["wheel_speed_rear_left", "wheel_speed_rear_right"])
def test_one_wheel_alone_shows_the_speed(gone):
    signals = changed(yaw_rate=-1.0)
    (problem,) = problems(signals | {gone: np.full(len(signals[gone]), np.nan)})
    assert problem.elements == ("yaw_rate",)


def test_the_closer_limits_of_a_calibrated_vehicle_are_those_that_its_rule_shows():
    rules = [each.rule for each in CONDITION.variants["bank"].decisions if each.place == "_wiring"]
    assert rules[0].stated.endswith(f"{CLOSE_SCALE:g} and {CLOSE_LATE:g} s once calibrated")
