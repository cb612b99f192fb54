"""Motors of which a data sheet is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tierod.core.claims import Claim
from tierod.core.findings import Status
from tierod_lab.papers.own_car import motors
from tierod_lab.papers.own_car.judging import BROCHURE, IDENTIFIED, TRUE, Judged
from tierod_lab.studies.registry import STUDIES


def test_motors_differ_from_their_data_sheet_as_far_as_it_is_known():
    apart = []
    for number in range(30):
        motor = motors.drawn(number, 3)
        for name in ("motor_resistance", "motor_inductance", "motor_inertia"):
            sheet = motor.brochure.parameters[name]
            apart.append(math.log(motor.true[name] / sheet.value) / (sheet.standard_deviation / sheet.value))
            assert motor.true.parameters[name].standard_deviation == 0.0
    assert np.std(apart) == pytest.approx(1.0, abs=0.25)
    assert motors.drawn(0, 3).true["motor_flux"] == motors.drawn(0, 3).true["motor_flux"]
    assert motors.drawn(0, 3).true["motor_flux"] != motors.drawn(0, 4).true["motor_flux"]


def test_a_data_sheet_gives_a_band_that_holds_the_angle():
    motor = motors.drawn(1, 3)
    seen = motor.truth.driven(9, 8.0)
    for vehicle in (motor.brochure, motor.true):
        each = motors.judged(motor.name, BROCHURE, vehicle, seen)
        assert each.samples > 50
        assert each.held > 0.9 * each.samples
        assert each.status is Status.HEALTHY
        assert 0.0 < each.squares / each.samples < 0.05**2


def test_every_motor_counts_in_the_claims():
    files = (BROCHURE, IDENTIFIED, TRUE)
    made = [Judged("motor 1", motors.MONITOR, file, Status.HEALTHY, "", 100, 95, 4.0, math.nan) for file in files]

    class Effort:
        quick = True

        def made(self, function, tasks):
            return [made for _ in tasks]

    claims = {each.id: each for each in motors.items(Effort(), seed=1) if isinstance(each, Claim)}
    assert claims["unknown.motor-angle-band"].measured == pytest.approx(0.95)
    assert claims["identified.motor-angle-error"].measured == pytest.approx(1.0)
    assert claims["verdicts.motor-angle"].measured == 0
    assert {each.group for each in claims.values()} < set(STUDIES["own-car"].groups)


@pytest.mark.slow
def test_a_drive_of_ten_seconds_identifies_a_motor():
    found = {each.file: each for each in motors.studied((0, 3))}
    assert found[IDENTIFIED].squares <= 1.3**2 * found[TRUE].squares
    assert found[IDENTIFIED].held > 0.92 * found[IDENTIFIED].samples
