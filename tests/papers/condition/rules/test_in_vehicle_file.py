"""Calibrations of the residuals go into a vehicle file and come back."""

import dataclasses
import math

import pytest

from tierod.core.errors import ParameterError
from tierod.vehicles import load
from tierod.vehicles.vehicle import SHIPPED
from tierod.vehicles.writer import with_thresholds
from tierod_lab.papers.condition.rules.storage import calibration_of, name_of, shipped_calibration, table_of

TEXT = (SHIPPED / "smartload.toml").read_text(encoding="utf-8")


@pytest.fixture
def car(tmp_path):
    def made(table, printed=False):
        path = tmp_path / "car.toml"
        path.write_text(with_thresholds(TEXT, name_of(printed), table), encoding="utf-8")
        return load(path)

    return made


@pytest.mark.parametrize("printed", [False, True])
def test_a_calibration_comes_back_as_it_was(car, printed):
    before = shipped_calibration(1.0, printed)
    after = calibration_of(car(table_of(before, "an hour"), printed), printed)
    assert after.printed == printed
    assert after.samples == before.samples
    for name, value in dataclasses.asdict(before.coefficients).items():
        assert getattr(after.coefficients, name) == pytest.approx(value, rel=1e-5)
    for name, threshold in before.thresholds.items():
        expected = dataclasses.asdict(threshold)
        assert dataclasses.asdict(after.thresholds[name]) == pytest.approx(expected, rel=1e-5)


def test_a_vehicle_without_one_has_the_shipped_one_widened():
    assert calibration_of(load("smartload")) == shipped_calibration()
    assert shipped_calibration().thresholds["r2"].base == 1.5 * shipped_calibration(1.0).thresholds["r2"].base


def test_a_residual_that_was_never_there_is_never_judged(car):
    calibration = shipped_calibration(1.0)
    never = dataclasses.replace(calibration.thresholds["r2"], base=math.inf)
    without = dataclasses.replace(calibration, thresholds={**calibration.thresholds, "r2": never})
    assert calibration_of(car(table_of(without, "an hour"))).thresholds["r2"].base == math.inf


@pytest.mark.parametrize(("part", "name"), [("base", "r77"), ("coefficients", "angel")])
def test_a_calibration_that_does_not_fit_is_refused_by_name(car, part, name):
    table = table_of(shipped_calibration(1.0), "an hour")
    table[part] = {**table[part], name: 1.0}
    with pytest.raises(ParameterError, match=rf"does not fit at '{name}'.*tierod identify thresholds"):
        calibration_of(car({**table, "source": "an hour"}))
