import numpy as np
import pytest

from tierod.proving_ground import EpsCar, Scatter, SensorNoise


def draws(scatter, count=400):
    generator = np.random.default_rng(0)
    return [scatter.draw(EpsCar(), SensorNoise(), generator) for _ in range(count)]


def test_spread_is_the_one_asked_for():
    cars = draws(Scatter())
    logs = {
        0.4: [np.log(car.steering.damping / 0.8) for car, _ in cars],
        0.3: [np.log(car.steering.inertia / 0.1) for car, _ in cars],
        0.1: [np.log(noise.driver_torque.gain) for _, noise in cars],
    }
    for deviation, values in logs.items():
        assert np.std(values) == pytest.approx(deviation, rel=0.15)
        assert np.mean(values) == pytest.approx(0.0, abs=0.2 * deviation)
    assert np.std([noise.driver_torque.bias for _, noise in cars]) == pytest.approx(0.3, rel=0.15)


def test_both_parts_of_the_trail_scatter_together_and_the_mass_stays():
    car, noise = draws(Scatter(), 1)[0]
    assert car.chassis.mechanical_trail / 0.025 == pytest.approx(car.chassis.contact_half_length / 0.075)
    assert car.chassis.mass == EpsCar().chassis.mass
    assert noise.steering_wheel_rate.noise == 0.02
    assert noise.yaw_rate == SensorNoise().yaw_rate


def test_no_scatter_is_the_nominal_car():
    none = Scatter(*[0.0] * 10)
    assert none.draw(EpsCar(), SensorNoise(), np.random.default_rng(0))[0] == EpsCar()
