"""The ratio of the motor's torque by ordinary drives: found where assist shares the load, kept where it cannot be."""

import pytest

from tierod.core.recording import Channel, Recording
from tierod.monitors.own_car import identify_own_car, ratio_of_drives
from tierod_lab.papers.own_car.cars import drawn
from tierod_lab.papers.own_car.judging import driven, without_truth

SEED = 77002


@pytest.fixture(scope="module")
def car():
    return drawn(1, SEED)


@pytest.fixture(scope="module")
def drive(car):
    return without_truth(driven(car, 7.0, SEED))


def test_a_gain_of_the_motor_torque_moves_the_ratio_by_as_much(car, drive):
    motor = drive["motor_torque"]
    weaker = drive.with_channels([Channel("motor_torque", motor.time, 0.8 * motor.values, motor.unit)])
    found = [ratio_of_drives({"a": each}, car.brochure).value for each in (drive, weaker)]
    assert found[1] / found[0] == pytest.approx(1.25, rel=0.02)


def test_without_torques_or_with_too_little_driving_nothing_is_found(car, drive):
    bare = Recording({name: each for name, each in drive.channels.items() if name != "motor_torque"})
    assert ratio_of_drives({"a": bare}, car.brochure) is None
    assert ratio_of_drives({"a": drive.slice(stop=200.0)}, car.brochure) is None


@pytest.mark.slow
def test_it_goes_into_what_is_written_beside_the_motion(car, drive):
    found = identify_own_car({"a": drive}, car.brochure)
    assert not found.doubt
    (own,) = [each for each in found.found if each.name == "motor_ratio"]
    before = car.brochure.parameters["motor_ratio"]
    assert own.deviation < 0.75 * before.standard_deviation
    true = car.true["motor_ratio"]
    assert abs(own.value - true) <= max(abs(before.value - true), 0.05 * true)
