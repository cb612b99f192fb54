import math

import pytest

from tierod.core.errors import ParameterError
from tierod.core.fields import numbers
from tierod.core.signals import SIGNALS
from tierod.core.toml import Document, build
from tierod_lab.ground import Sensor
from tierod_lab.ground.drives import CHANNELS
from tierod_lab.ground.sensors import PRESETS, SensorSet


def read(text, path="drive.toml"):
    document = Document.parse(text, path)
    return build(SensorSet, document.content.get("sensors", {}), document, ("sensors",))


def test_production_has_the_seven_channels_of_the_friction_monitor():
    production = SensorSet.production()
    assert {name: production[name] for name in CHANNELS} == {
        "steering_wheel_angle": Sensor(quantum=math.radians(0.1)),
        "steering_wheel_rate": Sensor(noise=0.01),
        "driver_torque": Sensor(noise=0.05, bias=0.05),
        "motor_torque": Sensor(noise=0.005),
        "yaw_rate": Sensor(noise=3e-3, bias=2e-3),
        "lateral_acceleration": Sensor(noise=0.1, bias=0.08),
        "vehicle_speed": Sensor(noise=0.02),
    }


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_is_described_and_measures_what_a_car_has(name):
    preset = SensorSet.preset(name)
    assert preset.description
    assert {"yaw_rate", "wheel_speed_rear_left", "driver_torque", "tie_rod_force_left", "motor_speed"} <= set(
        preset.sensors
    )


@pytest.mark.parametrize("name", PRESETS)
def test_noise_and_offsets_are_small_against_the_plausible_range(name):
    for channel, sensor in SensorSet.preset(name).items():
        low, high = SIGNALS[channel].plausible
        if math.isfinite(high - low):
            assert 6.0 * sensor.noise + abs(sensor.bias) + sensor.quantum < 0.1 * (high - low), channel


def test_ideal_reads_every_signal_as_it_is():
    assert SensorSet.ideal(50.0).sensors == dict.fromkeys(SIGNALS, Sensor(rate=50.0))


def test_a_table_changes_what_it_names():
    changed = read("""
        [sensors]
        without = ["yaw_rate"]
        [sensors.steering_wheel_angle]
        noise = "0.2 deg"
        [sensors.sideslip_angle]
        quantum = 0.01
    """)
    assert "yaw_rate" not in changed
    assert changed["steering_wheel_angle"] == Sensor(noise=math.radians(0.2), quantum=math.radians(0.1))
    assert changed["sideslip_angle"] == Sensor(quantum=0.01)
    assert changed["driver_torque"] == SensorSet.production()["driver_torque"]


def test_a_preset_with_a_rate_of_all():
    changed = read("[sensors]\npreset = 'ideal'\nrate = '1 kHz'\n[sensors.yaw_rate]\nrate = 50")
    assert changed["driver_torque"] == Sensor(rate=1000.0)
    assert changed["yaw_rate"] == Sensor(rate=50.0)


def test_nothing_said_is_production():
    assert read("") == SensorSet.production()


def test_a_preset_of_ones_own(tmp_path):
    (tmp_path / "mine.toml").write_text("preset = 'ideal'\n[yaw_rate]\nnoise = 0.5\n")
    path = tmp_path / "drive.toml"
    assert read("[sensors]\npreset = 'mine.toml'", path)["yaw_rate"].noise == 0.5
    (tmp_path / "mine.toml").write_text("\n[yaw_rat]\nnoise = 0.5\n")
    with pytest.raises(ParameterError, match=r"mine.toml, line 2: .*did you mean 'yaw_rate'"):
        read("[sensors]\npreset = 'mine.toml'", path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[sensors]\npreset = 'produktion'", "line 2: no set of sensors is called 'produktion'; did you mean"),
        ("[sensors]\nwithout = ['yaw_rat']", "line 2: no sensor measures 'yaw_rat'; did you mean 'yaw_rate'"),
        ("[sensors]\nwithout = 'yaw_rate'", "line 2: 'without' has to be a list"),
        ("[sensors]\nrate = -1", "line 2: 'sensors.rate' is -1 Hz"),
        ("[sensors]\n[sensors.yawrate]", "line 2: a sensor cannot measure 'yawrate'; did you mean 'yaw_rate'"),
        ("[sensors]\nyaw_rate = 3", "line 2: 'sensors.yaw_rate' is 3, but has to be a table"),
        ("[sensors]\n[sensors.yaw_rate]\nnoise = '1 m'", "line 3: .*measured in 'rad/s'"),
        ("[sensors]\n[sensors.yaw_rate]\nnois = 1", "line 3: 'nois' is not known here; did you mean 'noise'"),
        ("[sensors.yaw_rate]\nloss = 1.0", "line 2: 'sensors.yaw_rate.loss' is 1"),
        ("[sensors.yaw_rate]\nwrap = [3, 1]", "line 1: the wrap of a sensor needs"),
        ("[sensors.yaw_rate]\nwrap = [3]", "line 2: .*needs 2"),
        ("[sensors.yaw_rate]\nrandom_walk = '1 rad/s'", "line 2: .*cannot become"),
    ],
)
def test_a_slip_is_named_with_its_line(text, words):
    with pytest.raises(ParameterError, match=words):
        read(text)


def test_wrong_names_in_python():
    with pytest.raises(ParameterError, match="cannot measure 'yaw'"):
        SensorSet({"yaw": Sensor()})
    with pytest.raises(ParameterError, match="no sensor measures 'sideslip_angle'"):
        SensorSet.production()["sideslip_angle"]
    with pytest.raises(ParameterError, match="did you mean 'worn'"):
        SensorSet.preset("wron")


def test_fields_are_reached_by_path():
    known = numbers(SensorSet.production())
    assert known["sensors.driver_torque.bias"].value == 0.05
    assert known["sensors.motor_angle_electrical.wrap.1"].value == pytest.approx(math.pi)
