"""The filter of a car that is judged by its motion, and the bank of these filters."""

import math
from functools import lru_cache

import numpy as np
import pytest

from tierod.core.graph import scan
from tierod.monitors.condition.courses import FAULT
from tierod.monitors.condition.definition import rolling_monitor
from tierod.monitors.condition.limits import aligned
from tierod.monitors.condition.rolling_filter import RollingFilter, SmallestSteps
from tierod.monitors.condition.signals import FRONT_WHEELS, OF_CARS, WHEELS, ConditionSample, hypotheses_of_cars
from tierod.vehicles import load
from tierod_lab.papers.condition.drives import LOSS, OFFSET, Drive, Injected
from tierod_lab.papers.condition.recorded import recorded

RESIDUE = 1e-6


def after(readings, coarsest=0.5):
    steps = SmallestSteps.unseen((coarsest,))
    for each in readings:
        steps = steps.after((each,), (RESIDUE,))
    return steps.smallest[0]


def test_rounded_readings_show_their_step_and_its_variance():
    fine = np.random.default_rng(1).normal(0.0, 0.3, 500).cumsum()
    step = 0.0223
    rounded = step * np.round(fine / step)
    assert after(rounded.tolist()) == pytest.approx(step)
    steps = SmallestSteps.unseen((0.5,)).after((step,), (RESIDUE,))
    # The variance of the rounding error itself, over many readings.
    assert steps.variances[0] == pytest.approx(np.var(rounded - fine), rel=0.2)


def test_a_rounding_residue_is_no_step():
    assert after([0.0, 0.2, 0.2 + 1e-13, 0.4, 0.2]) == pytest.approx(0.2)


def test_readings_that_repeat_or_are_missing_show_nothing():
    assert after([0.2, 0.2, math.nan, 0.2]) == pytest.approx(0.2)
    assert after([0.0, 0.0, math.nan]) == 0.5


CAR = load("smartload")
START, END = 12.0, 20.0
MEASURED = [ConditionSample._fields.index(name) for name in (*OF_CARS, "longitudinal_acceleration")]
MEASURED.append(ConditionSample._fields.index("lateral_acceleration"))


@lru_cache(maxsize=8)
def drive(*injected):
    """Only what a car with a driver has on its bus."""
    read = aligned(recorded(Drive("short-round", 24.0, 0, 5, injected)))
    samples = np.full_like(read, np.nan)
    samples[:, MEASURED] = read[:, MEASURED]
    return samples


@pytest.fixture(scope="module")
def bank():
    return rolling_monitor(CAR)


def declared(bank, samples):
    result = scan(bank, samples)
    return {name: result[f"statements.{name}.status"] == FAULT for name in OF_CARS}, result


def test_only_sensors_of_cars_are_suspected_and_never_both_wheels():
    suspected = [each.suspects for each in hypotheses_of_cars()]
    assert len(suspected) == 20
    assert set().union(*suspected) == set(OF_CARS)
    assert not {WHEELS, FRONT_WHEELS} & {*suspected}


def test_a_fault_free_drive_is_quiet_and_the_filter_knows_what_it_does_not_know(bank):
    said, _ = declared(bank, drive())
    assert not any(each.any() for each in said.values())
    base, squares = RollingFilter.of_vehicle(CAR), {}
    for each in hypotheses_of_cars()[1:5]:
        (name,) = each.sensors
        result = scan(base.leaving_out(each), drive())
        error = drive()[:, OF_CARS.index(name)] - result[f"prediction.{name}"]
        squares[name] = np.mean((error / result[f"deviation.{name}"])[500:] ** 2)
    # Tyres near their grip, and radii that differ by more than those of a production car.
    assert max(squares.values()) < 6.0


@pytest.mark.parametrize(
    ("sensor", "kind", "size"),
    [(OF_CARS[0], LOSS, math.nan), (OF_CARS[1], OFFSET, -2.0), (OF_CARS[2], OFFSET, 0.3), (OF_CARS[3], OFFSET, 1.5)],
)
def test_a_fault_is_named_and_no_other(bank, sensor, kind, size):
    said, result = declared(bank, drive(Injected(sensor, kind, size, START, END)))
    # The steering ratio is known to some per cent: a wrong angle needs a bend to differ from a wrong ratio.
    late = 150 if sensor == "steering_wheel_angle" else 50
    inside = slice(round(START * 100) + late, round(END * 100))
    assert said[sensor][inside].all()
    assert not said[sensor][: round(START * 100)].any()
    assert not any(each.any() for name, each in said.items() if name != sensor)
    if sensor in OF_CARS[:2]:
        fault_free = drive()[inside, OF_CARS.index(sensor)]
        assert np.sqrt(np.mean((result[f"value.{sensor}"][inside] - fault_free) ** 2)) < 0.15


def test_missing_samples_leave_the_bank_unharmed(bank):
    samples = drive(Injected(OF_CARS[2], OFFSET, 0.3, START, END)).copy()
    samples[600:630] = np.nan
    samples[::2, :4] = np.nan
    said, result = declared(bank, samples)
    assert np.isfinite(result.values).all()
    assert said[OF_CARS[2]][round(START * 100) + 100 : round(END * 100)].all()
    assert not said[OF_CARS[2]][round(END * 100) + 150 :].any()  # back, though every other sample is not there
    assert not any(each.any() for name, each in said.items() if name != OF_CARS[2])


def test_a_coarse_sensor_is_trusted_less():
    fine, coarse = (RollingFilter.of_vehicle(load(name)).sensor_noise.yaw_rate for name in ("rav4", "revsted-car"))
    step = load("revsted-car")["yaw_rate_resolution"]
    assert coarse == pytest.approx(math.hypot(0.002, step / math.sqrt(12.0)))
    assert fine < 0.4 * coarse
