import math

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.monitors.motor_angle.observer import MotorAngleSample, MotorVoltages
from tierod.physics.clarke_park import StatorVector, inverse_clarke

WANTED = StatorVector(3.0, -2.0)
DUTY = [0.5 + value / 13.0 for value in inverse_clarke(WANTED)]


def row(**values):
    return [values.get(name, math.nan) for name in MotorAngleSample._fields]


SAMPLES = np.array(
    [
        row(motor_duty_cycle_a=DUTY[0], motor_duty_cycle_b=DUTY[1], motor_duty_cycle_c=DUTY[2]),
        row(
            motor_voltage_alpha=1.0,
            motor_voltage_beta=2.0,
            motor_target_voltage_alpha=1.5,
            motor_target_voltage_beta=2.5,
            **dict(zip(("motor_duty_cycle_a", "motor_duty_cycle_b", "motor_duty_cycle_c"), DUTY, strict=True)),
            supply_voltage=13.0,
        ),
        row(motor_duty_cycle_a=DUTY[0], motor_duty_cycle_b=DUTY[1], motor_duty_cycle_c=DUTY[2]),
        row(motor_duty_cycle_b=DUTY[1], motor_duty_cycle_c=DUTY[2]),
    ]
)


@pytest.mark.parametrize(("source", "expected"), [("measured", (1.0, 2.0)), ("commanded", (1.5, 2.5))])
def test_voltages_of_the_stator_are_taken_as_they_are(source, expected):
    found = scan(MotorVoltages(source), SAMPLES)
    assert (found["alpha"][1], found["beta"][1]) == expected
    assert np.isnan(found["alpha"][[0, 2]]).all()


def test_duty_cycles_take_the_last_supply_and_nothing_before_the_first():
    found = scan(MotorVoltages("duty cycles"), SAMPLES)
    for k in (1, 2):
        assert (found["alpha"][k], found["beta"][k]) == pytest.approx(tuple(WANTED))
    assert np.isnan(found["alpha"][[0, 3]]).all()


def test_an_unknown_source_is_refused():
    with pytest.raises(ParameterError, match="'guessed'; expected one of measured, commanded, duty cycles"):
        MotorVoltages("guessed")
