"""The virtual car's chassis beside another simulator and beside real cars."""

import math

import numpy as np
import pytest

from agreement.plants import commonroad_agreement, commonroad_tyre, ferrari_agreement, rav4_agreement
from shared_data import shared_data
from tierod.io.derive import complete
from tierod.io.readers import read
from tierod_lab.ground.chassis.laws import combined_forces, stiffness_per_load

pytestmark = pytest.mark.usefixtures("shipped_kernels")


@pytest.fixture(scope="module")
def simulator():
    return pytest.importorskip("vehiclemodels.utils.tire_model")


@pytest.fixture(scope="module")
def published(simulator):
    from vehiclemodels.parameters_vehicle2 import parameters_vehicle2

    return parameters_vehicle2().tire


@pytest.mark.parametrize("load", [1500.0, 3000.0, 6000.0])
@pytest.mark.parametrize("slip", [-0.3, -0.05, 0.01, 0.1, 0.4])
def test_the_side_force_is_that_of_the_published_set(simulator, published, load, slip):
    tyre = commonroad_tyre()
    theirs, _ = simulator.formula_lateral(-slip, 0.0, load, published)
    stiffness = stiffness_per_load(load, tyre.nominal_load, tyre.cornering_stiffness, tyre.load_of_greatest)
    ours = combined_forces(
        (0.0, slip),
        (tyre.longitudinal_stiffness, stiffness),
        (tyre.longitudinal_friction * tyre.friction, tyre.friction),
        load,
        tyre.shape,
        tyre.curvature,
    ).lateral
    assert ours == pytest.approx(theirs, rel=1e-4)


@pytest.mark.parametrize(
    ("speed", "steer", "frequency"), [(20.0, 0.035, 0.2), (20.0, 0.035, 0.5), (20.0, 0.035, 1.0), (30.0, 0.0185, 0.5)]
)
def test_a_weave_is_that_of_the_drift_single_track(simulator, speed, steer, frequency):
    found = commonroad_agreement(speed, steer, frequency)
    assert found.peak > 3.0
    assert found.yaw_rate < 0.05
    assert found.lateral_acceleration < 0.05


def test_a_slow_weave_is_that_of_the_multibody_model(simulator):
    found = commonroad_agreement(20.0, 0.033, 0.2, multibody=True)
    assert found.peak > 4.5
    assert found.yaw_rate < 0.05
    assert found.lateral_acceleration < 0.05


def test_the_rav4_minute_turns_as_recorded():
    pytest.importorskip("cantools")
    minute = complete(read(shared_data("rav4_highway_minute", "can.log"), dbc="rav4", channel_map="rav4"))
    found = rav4_agreement(minute)
    assert found.yaw_rate_error < math.radians(0.3)
    assert found.correlation > 0.8


@pytest.mark.parametrize("second_half", [False, True])
def test_the_linear_parts_of_the_race_laps_turn_as_recorded(second_half):
    found = ferrari_agreement(read(shared_data("ferrari_250lm_race", "laps.parquet")), second_half)
    assert found.gain == pytest.approx(1.0, abs=0.1)
    assert found.correlation > 0.9
    assert np.degrees(found.yaw_rate_error) < 1.2
