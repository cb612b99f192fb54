from dataclasses import replace

import numpy as np
import pytest

from monitors.motor_angle.motor_drives import NOISE, RATE, drive, held, observed
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.vehicles import load

OBSERVER = MotorAngleObserver.of_vehicle(load("motor-bench"), 1.0 / RATE)


def with_parameters(**factors):
    p = OBSERVER.parameters
    return replace(OBSERVER, parameters=replace(p, **{name: f * getattr(p, name) for name, f in factors.items()}))


def error(found, signals):
    return found["motor_angle"] - signals["truth_angle"]


def rms(values):
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("seed", [20, 21])
def test_it_follows_the_angle_under_load_and_its_band_holds(seed):
    signals = drive(seed)
    found = observed(OBSERVER, signals)
    away = error(found, signals)
    assert rms(away) < 0.006
    assert np.abs(away).max() < 0.07
    assert np.mean(np.abs(away) < 1.96 * found["motor_angle_standard_deviation"]) > 0.95
    assert rms(found["motor_speed"] - signals["truth_speed"]) < 1.0


def test_wrong_parameters_are_learnt_or_borne():
    random = np.random.default_rng(8)
    figures = []
    for k in range(8):
        observer = with_parameters(
            motor_resistance=1.0 / random.uniform(0.8, 1.3),
            motor_flux=1.0 / random.uniform(0.94, 1.02),
            motor_inductance=random.uniform(0.93, 1.07),
        )
        signals = drive(20 + k % 2)
        figures.append(rms(error(observed(observer, signals), signals)))
    assert np.median(figures) < 0.006
    assert max(figures) < 0.01


@pytest.mark.parametrize("resistance", [1.0, 1.0 / 1.2])
def test_standing_it_knows_that_it_knows_nothing(resistance):
    signals = drive(22, course=held)
    found = observed(with_parameters(motor_resistance=resistance), signals)
    away, deviation = error(found, signals), found["motor_angle_standard_deviation"]
    assert np.abs(signals["truth_speed"][70_000:150_000]).max() < 0.1
    assert np.hypot(signals["motor_current_alpha"], signals["motor_current_beta"])[70_000:150_000].mean() > 10.0
    assert found["standing"][60_000:150_000].min() == 1.0
    # White noise of the sensor, not a drift: the first and the last second are compared.
    assert abs(away[140_000:150_000].mean() - away[70_000:80_000].mean()) < 0.001
    assert deviation[149_000] > 3.0 * deviation[60_000]
    assert found["motor_flux"][149_000] == pytest.approx(found["motor_flux"][60_000], rel=0.02)
    assert rms(away[155_000:]) < 0.006


def test_missing_samples_never_reach_the_state():
    signals = {name: values[:60_000].copy() for name, values in drive(20).items()}
    lost = np.random.default_rng(3).random(60_000) < 0.02
    for name in (*NOISE, "sensor"):
        signals[name][np.roll(lost, len(name))] = np.nan
    signals["motor_current_alpha"][:50] = np.nan
    signals["sensor"][30_000:30_200] = np.nan
    found = observed(OBSERVER, signals)
    assert np.isfinite(found["motor_angle"]).all()
    assert rms(error(found, signals)[5_000:]) < 0.02
