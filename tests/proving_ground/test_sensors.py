import numpy as np
import pytest

from tierod.errors import ParameterError
from tierod.proving_ground import Sensor, SensorNoise

CHANCE = np.random.default_rng(0)


def test_ideal_sensor_reads_the_truth():
    truth = np.linspace(-1.0, 1.0, 50)
    assert np.array_equal(Sensor().measure(truth, CHANCE), truth)
    assert all(sensor == Sensor(rate=50.0) for _, sensor in SensorNoise.ideal(50.0).items())


def test_gain_bias_and_quantum():
    reading = Sensor(gain=2.0, bias=0.5, quantum=0.25).measure(np.array([0.0, 0.1, 1.0]), CHANCE)
    np.testing.assert_allclose(reading, [0.5, 0.75, 2.5])


def test_delay_shifts_in_time():
    truth = np.arange(100.0)
    late = Sensor(delay=0.05, rate=100.0).measure(truth, CHANCE)
    np.testing.assert_allclose(late[5:], truth[:-5])
    np.testing.assert_allclose(late[:5], 0.0)


def test_noise_has_its_deviation():
    assert np.std(Sensor(noise=0.3).measure(np.zeros(20_000), CHANCE)) == pytest.approx(0.3, rel=0.03)


@pytest.mark.parametrize("wrong", [{"rate": 0.0}, {"noise": -1.0}, {"quantum": -0.1}, {"delay": -1.0}])
def test_impossible_sensors_are_refused(wrong):
    with pytest.raises(ParameterError, match="a sensor needs"):
        Sensor(**wrong)
