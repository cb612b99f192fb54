import math
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import pytest

from chassis_replay import energy_error, unresisted
from ground.chassis.bench import Bench, Inputs, columns, drive, finite, surroundings
from tierod.core.graph import scan
from tierod_lab.ground.chassis import TYRES, TwoTrack, demonstrator
from tierod_lab.ground.integration import runge_kutta
from tierod_lab.ground.parts import Road, Steer, Wheels, Wind

G = 9.81
CAR = TwoTrack()


def test_energy_goes_where_it_is_accounted_for():
    assert energy_error(CAR) < 1e-3
    assert energy_error(demonstrator()) < 1e-3


def test_loads_of_a_steady_turn_balance_weight_and_moments():
    out = drive(unresisted(CAR), 8.0, 20.0, steer=0.02).at(-1).reaction
    loads = out.loads
    assert sum(loads) == pytest.approx(CAR.mass * G, rel=1e-9)
    moved = [0.5 * (right - left) * axle.track for left, right, axle in (
        (loads.front_left, loads.front_right, CAR.front), (loads.rear_left, loads.rear_right, CAR.rear)
    )]  # fmt: skip
    overturning = CAR.mass * (out.lateral_acceleration * CAR.centre_height + G * CAR.roll_arm * out.roll_angle)
    assert sum(moved) == pytest.approx(overturning, rel=2e-3)
    assert moved[0] > moved[1]


def test_the_body_rolls_by_its_moment_over_its_stiffness():
    out = drive(unresisted(CAR), 8.0, 20.0, steer=0.02).at(-1).reaction
    lever = CAR.mass * CAR.roll_arm
    stiffness = CAR.front.roll_stiffness + CAR.rear.roll_stiffness - lever * G
    assert out.roll_angle == pytest.approx(lever * out.lateral_acceleration / stiffness, rel=2e-3)
    assert math.radians(2.0) < out.roll_angle / out.lateral_acceleration * G < math.radians(6.0)


def test_braking_loads_the_front_axle_by_its_moment():
    out = drive(unresisted(CAR), 1.0, 30.0, brake=400.0).at(-1).reaction
    front = out.loads.front_left + out.loads.front_right
    moved = -CAR.mass * out.longitudinal_acceleration * CAR.centre_height / CAR.wheelbase
    assert out.longitudinal_acceleration < -2.0
    assert front - CAR.front_load == pytest.approx(moved, rel=0.01)


def test_a_hill_loads_the_rear_axle():
    out = drive(CAR, 6.0, 0.0, grade=0.1, brake=500.0).at(-1).reaction
    rear = out.loads.rear_left + out.loads.rear_right
    expected = CAR.rear_load * math.cos(0.1) + CAR.mass * G * math.sin(0.1) * CAR.centre_height / CAR.wheelbase
    assert rear == pytest.approx(expected, rel=1e-3)


def test_locked_wheels_slow_the_car_by_friction():
    out = drive(CAR, 2.0, 20.0, brake=5000.0, adhesion_left=0.5, adhesion_right=0.5)
    assert np.max(np.abs(out["reaction.wheel_speeds.front_left"][500:])) < 1e-6
    share = -out["reaction.longitudinal_acceleration"][500:1500].mean() / G
    assert 0.4 < share < 0.5 * CAR.front.tyre.longitudinal_friction


def test_brakes_on_split_ground_pull_to_the_side_that_grips():
    out = drive(CAR, 0.5, 25.0, brake=500.0, adhesion_left=1.0, adhesion_right=0.2).at(-1).reaction
    assert out.yaw_rate > 0.02


def test_a_spinning_wheel_stays_finite_and_pushes_no_more_than_it_grips():
    out = drive(CAR, 5.0, 0.0, drive_left=4000.0, drive_right=4000.0)
    assert finite(out)
    assert out["reaction.wheel_speeds.front_left"][-1] > 100.0
    assert out["reaction.longitudinal_acceleration"].max() < 1.1 * CAR.front_load / CAR.mass


def test_dragged_sideways_over_ice_the_tyres_deflect_no_further_than_their_slip_allows():
    bench = Bench(CAR, 0.0)
    state = bench.init()._replace(lateral_speed=15.0, yaw_rate=3.0)
    out = scan(bench, columns(8.0, adhesion_left=0.2, adhesion_right=0.2), state)
    assert finite(out)
    bound = CAR.front.tyre.greatest_slip * CAR.front.tyre.lateral_relaxation
    for wheel in ("front_left", "front_right", "rear_left", "rear_right"):
        assert np.max(np.abs(out[f"motion.lateral.{wheel}"])) <= bound * 1.001
    end = out.at(-1).reaction
    assert math.hypot(end.speed, end.lateral_speed) < 15.0


def test_the_aligning_torque_falls_before_the_side_force():
    out = drive(unresisted(CAR), 4.0, 20.0, steer=lambda t: 0.05 * t)
    torque, force = out["reaction.self_aligning_torque"], out["reaction.front_lateral_force"]
    assert np.argmax(torque) < np.argmax(force)
    assert torque[-1] < 0.95 * torque.max()
    trails = torque[1000:] / force[1000:]
    assert trails[0] == pytest.approx(0.05, rel=0.05)
    pneumatic = trails - CAR.kingpins.mechanical_trail
    assert pneumatic[-1] < 0.6 * pneumatic[0]


def test_more_drive_on_the_right_steers_left_at_the_kingpins():
    car = demonstrator()
    given = {"drive_left": 0.0, "drive_right": 100.0}
    out = drive(car, 0.1, 5.0, **given).at(-1).reaction
    difference = 100.0 / car.front.tyre.radius
    assert out.kingpin_left + out.kingpin_right < -0.5 * car.kingpins.scrub_radius * difference
    assert out.yaw_rate > 0.01


def test_load_dependence_takes_stiffness_from_an_axle_that_leans():
    upright = replace(CAR, centre_height=0.1)
    slips = []
    for car in (CAR, upright):
        out = drive(unresisted(car), 8.0, 20.0, steer=0.045).at(-1).reaction
        slips.append(out.front_slip_angle / out.front_lateral_force)
    assert slips[0] > 1.02 * slips[1]


@pytest.mark.parametrize("name", TYRES)
def test_every_kind_of_tyre_drives_to_its_limit(name):
    car = CAR.on_tyres(TYRES[name])
    out = drive(car, 8.0, 25.0, steer=lambda t: 0.15 * np.sin(2.0 * t), drive_left=100.0, drive_right=100.0)
    assert finite(out)
    assert 6.0 < np.max(np.abs(out["reaction.lateral_acceleration"])) < 1.2 * G


def test_kinds_of_tyre_differ_as_said():
    gains = {name: car.understeer_gradient for name, car in ((name, CAR.on_tyres(TYRES[name])) for name in TYRES)}
    assert gains["sport"] < gains["summer"] < gains["winter"]
    stiffness = {name: tyre.stiffness(4500.0) for name, tyre in TYRES.items()}
    assert stiffness["low pressure"] < stiffness["summer"] < stiffness["worn"]


def test_axle_stiffness_is_what_was_asked_for():
    car = CAR.with_axle_stiffness(90e3, 120e3)
    assert car.front.stiffness(car.front_load) == pytest.approx(90e3)
    assert car.rear.stiffness(car.rear_load) == pytest.approx(120e3)
    assert CAR.front.stiffness(CAR.front_load) == pytest.approx(110e3, rel=1e-3)
    assert CAR.rear.stiffness(CAR.rear_load) == pytest.approx(130e3, rel=1e-3)


class Free(NamedTuple):
    chassis: Any
    angle: Any
    rate: Any


@dataclass(frozen=True)
class FreeSteering:
    chassis: TwoTrack = field(default_factory=TwoTrack)
    speed: float = 3.0
    inertia: float = 25.0
    damping: float = 250.0

    class Sample(NamedTuple):
        drive: float

    def init(self) -> Free:
        return Free(self.chassis.init(self.speed), 0.3, 0.0)

    def step(self, state: Free, sample: Any) -> tuple[Free, Any]:
        def slope(now: Free) -> Free:
            steer = Steer(now.angle, now.angle, now.rate, now.rate)
            reaction = self.chassis.reaction(now.chassis, steer, Road(0.0, 0.0, 0.0, 1.0, 1.0, 1.0), Wind(0.0, 0.0))
            torques = Wheels(sample.drive, sample.drive, 0.0, 0.0)
            resisting = reaction.kingpin_left + reaction.kingpin_right + self.damping * now.rate
            rates = self.chassis.derivative(now.chassis, reaction, torques, Wheels(0.0, 0.0, 0.0, 0.0))
            return Free(rates, now.rate, -resisting / self.inertia)

        return runge_kutta(slope, state, 1e-3), (state.angle, state.chassis.speed)


@pytest.mark.parametrize("speed", [1.0, 3.0, 15.0])
def test_free_steering_returns_also_at_walking_speed(speed):
    out = scan(FreeSteering(speed=speed), np.full((12_000, 1), 25.0)).values[:, 0]
    assert np.isfinite(out).all()
    assert abs(out[-1]) < 0.02
    assert out.min() > -0.15


def test_reaction_needs_no_more_than_plain_numbers():
    steer, road, wind = surroundings(Inputs(steer=0.02))
    reaction = CAR.reaction(CAR.init(20.0), steer, road, wind)
    assert all(isinstance(load, float) for load in reaction.loads)
