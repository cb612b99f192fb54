import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from monitors.motor_angle.motor_drives import NOISE, RATE, drive, held, observed
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver, MotorAngleTuning, Pace, Surprise
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


def test_it_finds_the_resistance_of_a_warm_winding():
    found = observed(with_parameters(motor_resistance=1.0 / 1.2), drive(20))
    assert found["motor_resistance"][-1] == pytest.approx(OBSERVER.parameters.motor_resistance, rel=0.06)


def test_an_offset_of_the_sensor_shows_and_does_not_enter():
    signals = drive(20)
    sensor = signals["sensor"].copy()
    sensor[100_000:] += 0.05
    found = observed(OBSERVER, signals, sensor)
    assert rms(error(found, signals)) < 0.006
    turning = np.abs(signals["truth_speed"]) > 10.0
    before, after = turning[50_000:100_000], turning[100_001:]
    residual = found["angle_residual_electrical"]
    assert np.median(residual[50_000:100_000][before]) == pytest.approx(0.0, abs=0.01)
    assert np.median(residual[100_001:][after]) == pytest.approx(4.0 * 0.05, abs=0.01)


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


def test_it_recovers_from_a_wrong_beginning_as_soon_as_it_turns():
    signals = drive(20)
    settled = []
    for begin in range(20_000, 180_000, 16_000):
        piece = {name: values[begin : begin + 15_000] for name, values in signals.items()}
        if abs(piece["truth_speed"][0]) < 20.0:
            continue
        found = observed(OBSERVER, piece, piece["sensor"] + 0.3)
        away = (error(found, piece) * 4.0 + np.pi) % (2.0 * np.pi) / 4.0 - np.pi / 4.0
        late = np.flatnonzero(np.abs(away) > 0.03)
        settled.append((late[-1] + 1) / RATE if len(late) else 0.0)
    assert len(settled) >= 5
    assert np.median(settled) < 0.1


def test_an_angle_that_begins_anew_every_turn_is_no_jump():
    signals = drive(20)
    whole, wrapped = observed(OBSERVER, signals), observed(OBSERVER, signals, signals["sensor"] % (2.0 * np.pi))
    turns = (whole["motor_angle"] - wrapped["motor_angle"]) / (2.0 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-3)


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


def test_a_gap_of_the_sensor_is_no_speed():
    signals = {name: values[:60_000] for name, values in drive(20).items()}
    slow = np.abs(signals["truth_speed"]) < 5.0
    runs = [
        at for at in range(10_000, 59_000, 50) if slow[at - 20 : at + 60].all() and abs(signals["truth_speed"][at]) > 2
    ]
    assert runs
    sensor = signals["sensor"].copy()
    for at in runs[::3]:
        sensor[at : at + 30] = np.nan
    found = observed(OBSERVER, signals, sensor)
    # Three measurements: beyond 20 in one of 6000 samples. Thirty increments taken for one give hundreds.
    assert np.median(found["nis"][[at + 30 for at in runs[::3]]]) < 20.0


def test_before_it_has_begun_it_shows_no_difference():
    rows = np.array([[np.nan, 1.0, 0.0, 0.0, 2.0]] * 3 + [[0.0, 1.0, 0.0, 0.0, 2.0]])
    found = scan(OBSERVER, rows)["angle_residual_electrical"]
    np.testing.assert_allclose(found, 0.0, atol=1e-3)


def test_floats_and_compiled_code_agree():
    signals = {name: values[:40] for name, values in drive(20).items()}
    found = observed(OBSERVER, signals)
    state = OBSERVER.init()
    for k in range(40):
        sample = OBSERVER.Sample(*(float(signals[name][k]) for name in (*NOISE, "sensor")))
        state, output = OBSERVER.step(state, sample)
        assert output.motor_angle == pytest.approx(found["motor_angle"][k], rel=1e-9, abs=1e-12)
    assert scan(OBSERVER, np.full((5, 5), np.nan))["motor_angle"][-1] == 0.0


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"motor_inductance": 0.0}, "motor_inductance is 0.0"),
        ({"motor_inductance": 1e-6}, "too fast for samples"),
        ({"sample_time": -1.0}, "sample_time is -1.0"),
    ],
)
def test_parameters_that_cannot_be_are_refused(changes, says):
    given = {**vars(OBSERVER.parameters), **changes}
    with pytest.raises(ParameterError, match=says):
        MotorAngleObserver(SampledMotorParameters(**given))


def test_a_tuning_that_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="current_noise"):
        MotorAngleTuning(current_noise=0.0)


def test_surprises_are_forgotten_with_the_memory_s_time_constant():
    """A first-order memory without input decays as an exponential: after one time constant 1/e is left."""
    block = OBSERVER
    samples = round(block.tuning.step_memory / block.parameters.sample_time)
    surprise = Surprise(0.0, 5.0)
    for _ in range(samples):
        surprise = block._surprise(surprise, SimpleNamespace(nis=0.0), 1.0)
    assert surprise.often == pytest.approx(5.0 / math.e, rel=0.02)
    assert block._surprise(surprise, SimpleNamespace(nis=1e9), 1.0).often > surprise.often + 0.9


def test_what_the_inverter_takes_keeps_a_commanded_motor_standing():
    """The signs of three phases add up to a vector of 4/3 at the most; their drop is taken twice, as any other is."""
    observer = MotorAngleObserver.of_vehicle(load("motor-bench"), 1.0 / RATE, commanded=True)
    p, deviation = observer.parameters, 0.3
    least = observer.tuning.standing_speed + 2.0 * 4.0 / 3.0 * deviation / (p.motor_pole_pairs * p.motor_flux)
    uncertain = SimpleNamespace(variance=SimpleNamespace(log_resistance=0.0, voltage_loss=deviation**2))
    for factor, standing in ((0.99, 1.0), (1.01, 0.0)):
        speed = -1.5 * factor * least
        after = SimpleNamespace(mean=SimpleNamespace(speed=speed, current_alpha=9.0, current_beta=0.0))
        assert observer._pace(Pace(speed, 1.0, 0.0, 0.0), after, uncertain).standing == standing
