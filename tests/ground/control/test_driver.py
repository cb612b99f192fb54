import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

from tierod.core.block import Ring
from tierod.core.graph import scan
from tierod.core.graph.derivatives import jacobian
from tierod_lab.ground.control.driver import HumanDriver, Pedals
from tierod_lab.ground.parts import Demand, Hand, Intent, Seen

DRIVER = HumanDriver()
DEMAND = Demand(20.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)
SEEN = Seen(20.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, Hand(0.0, 0.0))


class Lane:
    inertia, damping, aligning = 0.1, 0.8, 0.6

    def __init__(self, driver, speed, offset=0.0, car_mass=None):
        self.driver, self.speed, self.offset = driver, speed, offset
        self.mass = car_mass or driver.mass
        self.motion, self.memory = driver.init(), driver.remembered()
        self.line = [0.0] * driver.delay_steps
        self.heading = self.angle = self.rate = self.acceleration = self.distance = 0.0

    def step(self, demand, curvature=0.0, grade=0.0):
        driver, dt = self.driver, self.driver.step_time
        head = self.memory.offset_ahead._replace(oldest=self.line[0])
        yaw_rate = self.speed * math.tan(driver.steering_ratio * self.angle)
        yaw_rate /= driver.wheelbase + driver.understeer_gradient * self.speed**2
        hand = Hand(self.angle, self.rate)
        seen = Seen(self.speed, self.acceleration, 0.0, yaw_rate, self.offset, self.heading, curvature, hand)
        self.memory, intent = driver.decide(self.memory._replace(offset_ahead=head), seen, demand)
        self.line = [*self.line[1:], self.memory.offset_ahead.newest]
        torque = driver.hand_torque(self.motion, hand, demand)
        slopes = driver.derivative(self.motion, intent, hand, demand)
        self.motion = type(self.motion)(*(x + dt * slope for x, slope in zip(self.motion, slopes, strict=True)))
        centring = self.aligning * yaw_rate * self.speed
        self.rate += dt * (torque - self.damping * self.rate - centring) / self.inertia
        self.angle += dt * self.rate
        self.offset += dt * self.speed * self.heading
        self.heading += dt * (yaw_rate - curvature * self.speed)
        self.acceleration = intent.force / self.mass - 9.81 * grade
        stopped = self.speed + dt * self.acceleration < 0.0
        self.acceleration = 0.0 if stopped else self.acceleration
        self.speed = 0.0 if stopped else self.speed + dt * self.acceleration
        self.distance += dt * self.speed
        return torque


@pytest.mark.parametrize(
    "speed", [5.0, *(pytest.param(each, marks=pytest.mark.slow) for each in (10.0, 20.0, 30.0)), 40.0]
)
def test_an_offset_is_corrected_and_stays_so_at_every_speed(speed):
    lane = Lane(DRIVER, speed, offset=0.5)
    offsets = []
    for _ in range(20_000):
        lane.step(DEMAND._replace(speed=speed))
        offsets.append(lane.offset)
    assert np.max(np.abs(offsets)) < 0.6
    assert np.max(np.abs(offsets[-5000:])) < 0.02


@pytest.mark.parametrize("speed", [5.0, pytest.param(20.0, marks=pytest.mark.slow), 40.0])
def test_a_bend_is_followed_within_the_lane(speed):
    lane, offsets = Lane(DRIVER, speed), []
    peak = 3.0 / speed**2
    shape = lambda place: peak * (0.5 - 0.5 * math.cos(math.pi * min(max(place, 0.0), 1.0)))  # noqa: E731
    for k in range(15_000):
        here = shape((1e-3 * k - 2.0) / 2.0)
        ahead = shape((1e-3 * k - 2.0 + DRIVER.anticipation) / 2.0)
        lane.step(DEMAND._replace(speed=speed, curvature_ahead=ahead), curvature=here)
        offsets.append(lane.offset)
    assert np.max(np.abs(offsets)) < 0.6
    assert abs(offsets[-1]) < 0.3


def test_nothing_is_corrected_before_the_reaction_time():
    memory, line = DRIVER.remembered(), [0.0] * DRIVER.delay_steps
    angles = []
    for _ in range(2 * DRIVER.delay_steps):
        head = memory.offset_ahead._replace(oldest=line[0])
        memory, intent = DRIVER.decide(memory._replace(offset_ahead=head), SEEN._replace(lateral_offset=1.0), DEMAND)
        line = [*line[1:], memory.offset_ahead.newest]
        angles.append(intent.steering_wheel_angle)
    assert np.all(np.array(angles[:150]) == 0.0)
    assert np.all(np.array(angles[150:]) < 0.0), "a car to the left of its path is steered to the right"


def test_a_car_ahead_of_its_path_to_the_left_is_steered_back_the_sooner():
    seen = SEEN._replace(lateral_offset=1.0, heading_error=0.01, lateral_speed=0.1)
    memory, _ = DRIVER.decide(DRIVER.remembered()._replace(offset_ahead=Ring(150, oldest=0.0)), seen, DEMAND)
    assert memory.offset_ahead.newest == pytest.approx(1.0 + 1.5 * (20.0 * 0.01 + 0.1))


def test_a_car_that_rolls_back_is_not_steered_ever_more():
    memory, seen = DRIVER.remembered(), SEEN._replace(speed=-3.0)
    for _ in range(10_000):
        head = memory.offset_ahead._replace(oldest=0.0)
        memory, _ = DRIVER.decide(memory._replace(offset_ahead=head), seen, DEMAND._replace(curvature_ahead=0.01))
    assert memory.curvature == pytest.approx(0.01)


def test_hands_off_gives_exactly_no_torque():
    free = DEMAND._replace(grip=0.0)
    motion = DRIVER.init()._replace(angle=0.7, rate=-2.0)
    assert DRIVER.hand_torque(motion, Hand(-0.3, 1.0), free) == 0.0
    assert DRIVER.hand_torque(motion, Hand(-0.3, 1.0), free._replace(hand_torque=0.4)) == 0.4


def test_arms_are_a_spring_and_damper_within_the_torque_limit():
    motion = DRIVER.init()._replace(angle=0.1, rate=0.2)
    assert DRIVER.hand_torque(motion, Hand(0.0, 0.0), DEMAND) == pytest.approx(4.0 + 0.4)
    assert DRIVER.hand_torque(motion, Hand(0.0, 0.0), DEMAND._replace(grip=0.25)) == pytest.approx(1.1)
    assert DRIVER.hand_torque(motion._replace(angle=3.0), Hand(0.0, 0.0), DEMAND) == 15.0
    assert DRIVER.hand_torque(motion._replace(angle=-3.0), Hand(0.0, 0.0), DEMAND) == -15.0


def test_muscles_have_one_double_pole():
    matrix = jacobian(lambda m: DRIVER.derivative(m, Intent(0.3, 0.0), Hand(0.0, 0.0), DEMAND), DRIVER.init())
    rates = np.linalg.eigvals(np.array(matrix, float)[:2, :2])
    assert rates == pytest.approx([-1.0 / 0.08] * 2, rel=1e-6)


def test_a_person_given_an_angle_reaches_it_against_a_spring():
    result = DEMAND._replace(attention=0.0, steering_wheel_angle=0.5)
    lane = Lane(DRIVER, 20.0)
    for _ in range(8000):
        lane.step(result)
    assert lane.angle == pytest.approx(0.5, abs=1e-3)
    hasty = Lane(HumanDriver(persistence=0.0), 20.0)
    for _ in range(8000):
        hasty.step(result)
    spring = Lane.aligning * 20.0**2 * hasty.driver.steering_ratio / (2.83 + hasty.driver.understeer_gradient * 20.0**2)
    shared = 0.5 * 40.0 / (40.0 + spring)
    assert hasty.angle == pytest.approx(shared, rel=1e-3), "without patience spring and arms share the angle"


def test_no_lane_is_no_correction():
    memory = DRIVER.remembered()._replace(offset_ahead=Ring(150, oldest=2.0))
    _, intent = DRIVER.decide(memory, SEEN, DEMAND._replace(attention=0.0))
    assert intent.steering_wheel_angle == 0.0


@pytest.mark.parametrize(
    ("factor", "grade"),
    [
        (1.3, -0.08),
        *(pytest.param(a, b, marks=pytest.mark.slow) for a in (0.8, 1.0, 1.3) for b in (0.0, 0.08)),
    ],
)
def test_speed_is_kept_and_the_car_stops_and_starts_again(grade, factor):
    lane = Lane(DRIVER, 15.0, car_mass=factor * DRIVER.mass)
    speeds = []
    for k in range(45_000):
        time = 1e-3 * k
        target = np.interp(time, [0.0, 15.0, 22.5, 30.0, 37.5], [15.0, 15.0, 0.0, 0.0, 11.25])
        acceleration = -2.0 if 15.0 < time < 22.5 else 1.5 if 30.0 < time < 37.5 else 0.0
        lane.step(DEMAND._replace(speed=target, acceleration=acceleration), grade=grade)
        speeds.append(lane.speed)
    assert speeds[15_000] == pytest.approx(15.0, abs=0.05)
    assert np.all(np.array(speeds[24_500:30_000]) == 0.0), "holds the brake on the slope"
    assert speeds[-1] == pytest.approx(11.25, abs=0.15)
    assert np.max(speeds) < 16.5


def stopped(braking, downhill=0.0):
    """When a mass that is to brake from 10 m/s stops, on a road that falls away just before; and how hard."""
    foot, speed, time, end = DRIVER.pedals.remembered(), 10.0, 0.0, 10.0 / braking
    while speed > 0.0:
        planned = -braking if time < end else 0.0
        foot, pressed = DRIVER.pedals.press(foot, speed, max(10.0 - braking * time, 0.0), planned, 1e-3)
        acceleration = pressed + (downhill if time > end - 1.0 else 0.0)
        speed, time = speed + 1e-3 * acceleration, time + 1e-3
        assert time < end + 8.0
    return time - end, -acceleration


def test_a_stop_is_eased_unless_it_is_an_emergency():
    late, hardness = stopped(2.0)
    assert late < 0.3
    assert 0.2 < hardness < 1.1
    assert stopped(8.0)[1] > 3.0


@pytest.mark.parametrize("downhill", [0.2, 0.5])
def test_an_unexpected_slope_does_not_keep_a_car_from_stopping(downhill):
    late, hardness = stopped(2.0, downhill)
    assert late < 1.5
    assert hardness < 1.3


def test_poles_of_the_speed_loop_are_double():
    pedals = Pedals(foot_time=1e-2)
    assert pedals.proportional**2 == pytest.approx(4.0 * pedals.integral)


class Sample(NamedTuple):
    seen: Seen
    demand: Demand


@dataclass(frozen=True)
class Decisions:
    driver: HumanDriver
    Sample = Sample

    def init(self):
        return self.driver.remembered(), self.driver.init()

    def step(self, state, sample):
        memory, muscles = state
        memory, intent = self.driver.decide(memory, sample.seen, sample.demand)
        torque = self.driver.hand_torque(muscles, sample.seen.hand, sample.demand)
        slopes = self.driver.derivative(muscles, intent, sample.seen.hand, sample.demand)
        moved = type(muscles)(*(x + 1e-3 * slope for x, slope in zip(muscles, slopes, strict=True)))
        return (memory, moved), (*intent, torque)


def test_kernel_agrees_with_floats():
    chance = np.random.default_rng(0)
    seen = chance.normal(0.0, 1.0, (400, 9)) * [3.0, 1.0, 0.5, 0.2, 0.5, 0.05, 0.02, 1.0, 2.0] + [2.0, *[0.0] * 8]
    demand = np.column_stack([chance.normal(0.0, 1.0, (400, 5)) * [3.0, 1.0, 0.02, 0.5, 1.0], chance.random((400, 2))])
    block = Decisions(HumanDriver(delay_steps=20))
    compiled = scan(block, np.hstack([seen, demand])).values
    (memory, muscles), line = block.init(), [0.0] * 20
    for row, right in zip(np.hstack([seen, demand]), compiled, strict=True):
        row = [float(value) for value in row]
        sample = Sample(Seen(*row[:7], Hand(*row[7:9])), Demand(*row[9:]))
        memory = memory._replace(offset_ahead=memory.offset_ahead._replace(oldest=line[0]))
        (memory, muscles), output = block.step((memory, muscles), sample)
        line = [*line[1:], memory.offset_ahead.newest]
        assert np.allclose(output, right, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("speed", [5.0, 40.0])
def test_a_lasting_offset_beyond_the_greatest_is_not_corrected_harder(speed):
    seen = SEEN._replace(speed=speed, lateral_offset=100.0)
    memory, _ = DRIVER.decide(DRIVER.remembered()._replace(offset_ahead=Ring(150, oldest=0.0)), seen, DEMAND)
    assert memory.offset_ahead.newest == DRIVER.greatest_offset


def test_a_standing_driver_does_not_turn_the_wheel_for_an_offset():
    memory = DRIVER.remembered()._replace(offset_ahead=Ring(150, oldest=1.0))
    _, intent = DRIVER.decide(memory, SEEN._replace(speed=0.0), DEMAND._replace(speed=0.0))
    assert intent.steering_wheel_angle == 0.0
