import math
from dataclasses import replace
from operator import attrgetter

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.toml import Document, build
from tierod_lab.ground.cars.active_front_car import ActiveFrontCar
from tierod_lab.ground.cars.demonstrator_car import DemonstratorCar
from tierod_lab.ground.cars.eps_car import EpsCar
from tierod_lab.ground.cars.steer_by_wire_car import SteerByWireCar
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
        ("single-track", ("chassis.mechanical_trail", "chassis.contact_half_length")),
        ("two-track", ("steering.wheel_inertia", "steering.column_inertia", "steering.motor.inertia")),
        ("rack", ("steering.wheel_inertia", "steering.rack_mass", "steering.motor.inertia")),
        ("two-track", ("steering.damping", "steering.motor.damping")),
        ("rack", ("steering.pinion_damping", "steering.rack_damping", "steering.motor.damping")),
        ("superposed", ("steering.column.damping", "steering.column.motor.damping")),
        ("superposed", ("steering.column.wheel_inertia", "steering.column.motor.inertia")),
        (
            "demonstrator",
            ("steering.rack.rack_mass", "steering.rack.wheel_inertia", "steering.steering_motor_2.inertia"),
        ),
        ("by wire", ("steering.inertia", "steering.motor.inertia")),
    ],
)
def test_what_belongs_together_scatters_together(name, together):
    car, _ = draws(Scatter(), CARS[name], 1)[0]
    ratios = [ratio(car, path, name) for path in together]
    assert ratios[0] != 1.0
    np.testing.assert_allclose(ratios, ratios[0])


def test_all_else_stays():
    car, sensors = draws(Scatter(), count=1)[0]
    assert car.chassis.mass == EpsCar().chassis.mass
    assert value(car, "chassis.rear.tyre.trail") == value(EpsCar(), "chassis.rear.tyre.trail")
    assert sensors["steering_wheel_rate"].noise == 0.02
    assert sensors["yaw_rate"] == SENSORS["yaw_rate"]
    assert car.driver == EpsCar().driver


@pytest.mark.parametrize("name", CARS)
def test_the_harder_form(name):
    hard = replace(NOTHING, tyre_stiffness=0.2, mass=0.08, torque_delay=0.05)
    car, sensors = draws(hard, CARS[name], 1)[0]
    front, rear = (
        ("chassis.front_stiffness", "chassis.rear_stiffness")
        if name == "single-track"
        else ("chassis.front.tyre.cornering_stiffness", "chassis.rear.tyre.cornering_stiffness")
    )
    assert len({ratio(car, front, name), ratio(car, rear, name), 1.0}) == 3
    assert ratio(car, "chassis.mass", name) == pytest.approx(ratio(car, "chassis.yaw_inertia", name))
    assert ratio(car, "chassis.mass", name) != 1.0
    assert sensors["motor_torque"].delay == sensors["driver_torque"].delay == 0.05


@pytest.mark.parametrize("car", CARS.values(), ids=list(CARS))
def test_no_scatter_is_the_nominal_car(car):
    assert NOTHING.draw(car, SENSORS, np.random.default_rng(0))[0] == car


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


def test_a_parameter_that_scatters_already_scatters_more():
    both = draws(replace(NOTHING, damping=0.3, parameters={"steering.damping": Spread(0.4)}))
    logs = [math.log(ratio(car, "steering.damping")) for car, _ in both]
    assert np.std(logs) == pytest.approx(0.5, rel=0.1)


def test_a_draw_stays_in_its_range():
    wide = replace(NOTHING, parameters={"steering.friction.load_share": Spread(0.5, "normal")})
    shares = [value(car, "steering.friction.load_share") for car, _ in draws(wide)]
    assert min(shares) >= 0.0
    assert max(shares) <= 1.0
    huge = replace(NOTHING, parameters={"steering.friction.load_share": Spread(1e9, "normal")})
    with pytest.raises(ParameterError, match="of 1000 draws none gave 'steering.friction.load_share'"):
        draws(huge, count=30)


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


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[scatter]\ndampin = 1", "line 2: 'dampin' is not known here; did you mean 'damping'"),
        ("[scatter]\ndamping = -1", "line 2: 'scatter.damping' is -1"),
        ("[scatter]\ndriver_torque_offset = '1 m'", "line 2: .*measured in"),
        ("[scatter]\nparameters = 3", "line 2: 'parameters' has to be a table"),
        ("[scatter.parameters]\n'chassis.mass' = 'x'", "line 2: .*has to be a number"),
        (
            "[scatter.parameters]\n'chassis.mass' = { deviation = 1, kind = 'uniform' }",
            "line 2: .*not among log-normal",
        ),
        ("[scatter.parameters]\n'chassis.mass' = { kind = 'normal' }", "line 2: 'deviation' is missing"),
        ("[scatter.parameters]\n'chassis.mass' = -0.1", "line 2: .*at least 0"),
        ("[scatter.parameters]\n'chassis.mas' = 0.1", "line 2: neither car nor sensors .*did you mean 'chassis.mass"),
        ("[scatter.parameters]\nsensors.yaw.bias = 0.1", "line 2: .*did you mean 'sensors.yaw_rate.bias'"),
        ("[scatter.parameters]\n'chassis.mass' = { deviation = 1, also = ['x'] }", "line 2: .*parameter 'x'"),
        (
            "[scatter.parameters]\n'sensors.yaw_rate.delay' = 0.1",
            "line 2: 'sensors.yaw_rate.delay' is 0, which no factor",
        ),
        ("[scatter.parameters]\n'chassis.mass' = '3 kg'", "line 2: .*has to be a number without unit"),
        ("[scatter.parameters]\n'chassis.mass' = { deviation = '3 m', kind = 'normal' }", "line 2: .*measured in 'kg'"),
    ],
)
def test_a_slip_is_named_with_its_line(text, words):
    with pytest.raises(ParameterError, match=r"drive.toml, " + words):
        draws(read(text), EpsCar(), 1)


def test_a_slip_in_python():
    with pytest.raises(ParameterError, match="neither car nor sensors have a parameter 'mass'"):
        draws(Scatter(parameters={"mass": Spread(0.1)}))
    with pytest.raises(ParameterError, match="'damping' is -1"):
        Scatter(damping=-1.0)
