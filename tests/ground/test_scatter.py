import math
from dataclasses import replace
from operator import attrgetter

import numpy as np
import pytest

from tierod.core.toml import Document, build
from tierod_lab.ground.cars.road_cars import ActiveFrontCar, DemonstratorCar, EpsCar, SteerByWireCar
from tierod_lab.ground.chassis import SingleTrack, TwoTrack
from tierod_lab.ground.scatter import Scatter, Spread
from tierod_lab.ground.sensors import SensorSet
from tierod_lab.ground.steering.column_eps import ColumnEps
from tierod_lab.ground.steering.rack_eps import RackEps

CARS = {
    "two-track": EpsCar(TwoTrack(), ColumnEps()),
    "single-track": EpsCar(SingleTrack(), ColumnEps()),
    "rack": EpsCar(TwoTrack(), RackEps()),
    "superposed": ActiveFrontCar(),
    "demonstrator": DemonstratorCar(),
    "by wire": SteerByWireCar(),
}
SENSORS = SensorSet.production()
NOTHING = Scatter(*[0.0] * 10)


def draws(scatter, car=CARS["two-track"], count=200):
    generator = np.random.default_rng(0)
    return [scatter.draw(car, SENSORS, generator) for _ in range(count)]


def value(instance, path):
    return attrgetter(path)(instance)


def ratio(car, path, name="two-track"):
    return value(car, path) / value(CARS[name], path)


def test_spread_is_the_one_asked_for():
    drawn = draws(Scatter())
    logs = {
        0.4: [math.log(ratio(car, "steering.damping")) for car, _ in drawn],
        0.3: [math.log(ratio(car, "steering.motor.inertia")) for car, _ in drawn],
        0.1: [math.log(sensors["driver_torque"].gain) for _, sensors in drawn],
    }
    for deviation, values in logs.items():
        assert np.std(values) == pytest.approx(deviation, rel=0.15)
        assert np.mean(values) == pytest.approx(0.0, abs=0.2 * deviation)
    assert np.std([sensors["driver_torque"].bias for _, sensors in drawn]) == pytest.approx(0.3, rel=0.15)
    assert np.std([sensors["lateral_acceleration"].bias for _, sensors in drawn]) == pytest.approx(0.3, rel=0.15)


@pytest.mark.parametrize(
    ("name", "together"),
    [
        ("two-track", ("chassis.kingpins.mechanical_trail", "chassis.front.tyre.trail")),
        ("rack", ("steering.pinion_damping", "steering.rack_damping", "steering.motor.damping")),
        (
            "demonstrator",
            ("steering.rack.rack_mass", "steering.rack.wheel_inertia", "steering.steering_motor_2.inertia"),
        ),
    ],
)
def test_what_belongs_together_scatters_together(name, together):
    car, _ = draws(Scatter(), CARS[name], 1)[0]
    ratios = [ratio(car, path, name) for path in together]
    assert ratios[0] != 1.0
    np.testing.assert_allclose(ratios, ratios[0])


def test_one_does_not_move_another():
    usual = draws(Scatter(), count=1)[0][0]
    with_mass = draws(Scatter(mass=0.1), count=1)[0][0]
    assert with_mass.steering == usual.steering
    more = {"chassis.drag_area": Spread(0.2), "sensors.yaw_rate.gain": Spread(0.05)}
    assert draws(Scatter(parameters=more), count=1)[0][0].steering == usual.steering
    one, other = ({name: more[name] for name in names} for names in (more, reversed(more)))
    assert draws(Scatter(parameters=one), count=3) == draws(Scatter(parameters=other), count=3)
    alone = draws(Scatter(parameters={"sensors.yaw_rate.gain": Spread(0.05)}), count=1)[0][1]
    assert alone == draws(Scatter(parameters=more), count=1)[0][1]


def test_any_parameter_of_car_and_sensors():
    scatter = replace(
        NOTHING,
        parameters={
            "chassis.mass": Spread(0.1, also=("chassis.yaw_inertia",)),
            "chassis.centre_height": Spread("30 mm", "normal"),
            "sensors.yaw_rate.bias": Spread("0.5 deg/s", "normal"),
        },
    )
    drawn = draws(scatter)
    masses = [math.log(ratio(car, "chassis.mass")) for car, _ in drawn]
    assert np.std(masses) == pytest.approx(0.1, rel=0.15)
    np.testing.assert_allclose(masses, [math.log(ratio(car, "chassis.yaw_inertia")) for car, _ in drawn], atol=1e-12)
    assert np.std([car.chassis.centre_height for car, _ in drawn]) == pytest.approx(0.03, rel=0.15)
    biases = [sensors["yaw_rate"].bias for _, sensors in drawn]
    assert np.std(biases) == pytest.approx(math.radians(0.5), rel=0.15)
    assert np.mean(biases) == pytest.approx(SENSORS["yaw_rate"].bias, abs=1.5e-3)


def read(text):
    document = Document.parse(text, "drive.toml")
    return build(Scatter, document.content["scatter"], document, ("scatter",))


def test_a_table():
    scatter = read("""
        [scatter]
        torque_gain = "5 %"
        torque_delay = "20 ms"
        [scatter.parameters]
        "chassis.mass" = { deviation = 0.08, also = ["chassis.yaw_inertia"] }
        steering.friction.level = 0.2
        "sensors.yaw_rate.bias" = { deviation = "0.2 deg/s", kind = "normal" }
    """)
    assert scatter == Scatter(
        torque_gain=0.05,
        torque_delay=0.02,
        parameters={
            "chassis.mass": Spread(0.08, also=("chassis.yaw_inertia",)),
            "steering.friction.level": Spread(0.2),
            "sensors.yaw_rate.bias": Spread("0.2 deg/s", "normal"),
        },
    )
    assert read("[scatter]") == Scatter()
