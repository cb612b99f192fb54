import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.errors import ParameterError
from tierod_lab.ground import Sensor, SensorSet
from tierod_lab.ground.sensors.sensor import gauss_markov, lost_frames, random_walk


def chance(seed=0):
    return np.random.default_rng(seed)


def test_ideal_sensor_reads_the_truth():
    truth = np.linspace(-1.0, 1.0, 50)
    assert np.array_equal(Sensor().read(truth, chance()), truth)
    taken, stamps = Sensor(rate=50.0).instants(1.0, chance())
    assert np.array_equal(taken, np.arange(50) / 50.0)
    assert np.array_equal(stamps, taken)
    assert all(sensor == Sensor(rate=50.0) for _, sensor in SensorSet.ideal(50.0).items())


def test_gain_bias_and_quantum():
    reading = Sensor(gain=2.0, bias=0.5, quantum=0.25).read(np.array([0.0, 0.1, 1.0]), chance())
    np.testing.assert_allclose(reading, [0.5, 0.75, 2.5])


@given(st.floats(-1e3, 1e3), st.floats(1e-3, 1.0))
def test_rounding_errs_by_half_a_quantum_at_most(value, quantum):
    (reading,) = Sensor(quantum=quantum).read(np.array([value]), chance())
    assert abs(reading - value) <= 0.5 * quantum * (1.0 + 1e-9) + 1e-12
    assert reading / quantum == pytest.approx(round(reading / quantum), abs=1e-6)


def test_rounding_noise_has_the_deviation_of_a_uniform_one():
    truth = 10.0 * chance(1).random(50_000)
    error = Sensor(quantum=0.5).read(truth, chance()) - truth
    assert np.std(error) == pytest.approx(0.5 / math.sqrt(12.0), rel=0.02)


def test_delay_is_the_age_of_what_is_read():
    taken, stamps = Sensor(delay=0.05).instants(1.0, chance())
    np.testing.assert_allclose(stamps[5:] - taken[5:], 0.05)
    assert not taken[:5].any()


def test_noise_has_its_deviation():
    reading = Sensor(noise=0.3).read(np.zeros(20_000), chance())
    assert np.std(reading) == pytest.approx(0.3, rel=0.03)
    assert abs(np.corrcoef(reading[1:], reading[:-1])[0, 1]) < 0.03


def test_jitter_of_instants_and_of_stamps():
    exact = np.arange(20_000) / 100.0
    taken, stamps = Sensor(jitter=1e-3).instants(200.0, chance())
    assert np.array_equal(stamps, exact)
    assert np.std(taken[1:] - exact[1:]) == pytest.approx(1e-3, rel=0.03)
    taken, stamps = Sensor(stamp_jitter=1e-3).instants(200.0, chance())
    assert np.array_equal(taken, exact)
    assert np.std(stamps[1:] - exact[1:]) == pytest.approx(1e-3, rel=0.03)


def test_even_great_jitter_keeps_the_order():
    taken, stamps = Sensor(jitter=1.0, stamp_jitter=1.0).instants(20.0, chance())
    assert (np.diff(taken) > 0.0).all()
    assert (np.diff(stamps) > 0.0).all()


@pytest.mark.parametrize(("share", "run"), [(0.01, 1.0), (0.05, 4.0), (0.3, 2.0), (0.9, 20.0)])
def test_lost_frames_have_their_share_and_their_runs(share, run):
    lost = lost_frames(400_000, share, run, chance())
    assert lost.mean() == pytest.approx(share, rel=0.05)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], lost, [False]]).astype(int)))
    runs = edges[1::2] - edges[::2]
    assert runs.mean() == pytest.approx(run, rel=0.05)


def test_lost_frames_are_absent():
    taken, stamps = Sensor(loss=0.2, delay=0.02).instants(1000.0, chance())
    assert len(stamps) == len(taken) == pytest.approx(80_000, rel=0.02)
    assert not len(Sensor(loss=0.2).instants(0.0, chance())[0])


def test_repeats_carry_the_reading_of_the_frame_before():
    truth = np.arange(100_000.0)
    reading = Sensor(repeats=0.1).read(truth, chance())
    assert (np.diff(reading) == 0.0).mean() == pytest.approx(0.1, rel=0.05)
    assert ((truth - reading) >= 0.0).all()
    assert np.isin(reading, truth).all()


def test_an_encoder_runs_over_and_a_transducer_stays_at_its_limit():
    truth = np.array([-4.0, -math.pi, 0.0, 3.0, math.pi, 10.0])
    wrapped = Sensor(wrap=(-math.pi, math.pi)).read(truth, chance())
    np.testing.assert_allclose(wrapped, np.angle(np.exp(1j * truth)) * np.where(truth == math.pi, -1.0, 1.0), atol=1e-9)
    assert (wrapped < math.pi).all()
    np.testing.assert_array_equal(Sensor(saturation=(-1.0, 2.0)).read(truth, chance()), np.clip(truth, -1.0, 2.0))


def test_a_transducer_at_its_limit_is_rounded_as_any_reading():
    sensor = Sensor(quantum=0.25, saturation=(-1.1, 2.0))
    np.testing.assert_array_equal(sensor.represented(np.array([-9.0, -1.0, 1.9, 9.0])), [-1.0, -1.0, 2.0, 2.0])


def test_what_is_rounded_to_the_end_of_a_turn_begins_anew():
    sensor = Sensor(quantum=math.radians(0.17578125), wrap=(-math.pi, math.pi))
    ends = sensor.represented(np.radians([179.9, 179.95, -179.95, 180.0]))
    np.testing.assert_allclose(np.degrees(ends), [179.82421875, -180.0, -180.0, -180.0], atol=1e-9)


@given(st.integers(-10_000, 10_000), st.integers(2, 12))
def test_a_wrapped_count_stays_among_its_values(count, bits):
    period = 2.0 * math.pi
    quantum = period / 2**bits
    (reading,) = Sensor(quantum=quantum, wrap=(0.0, period)).read(np.array([count * quantum]), chance())
    assert 0.0 <= reading < period
    assert round(reading / quantum) % 2**bits == count % 2**bits


def test_a_wandering_bias_has_its_deviation_and_its_time():
    series = gauss_markov(400_000, 50.0, chance())
    assert np.std(series) == pytest.approx(1.0, rel=0.05)
    assert np.corrcoef(series[50:], series[:-50])[0, 1] == pytest.approx(math.exp(-1.0), abs=0.03)
    reading = Sensor(instability=0.2, instability_time=0.5).read(np.zeros(400_000), chance())
    assert np.std(reading) == pytest.approx(0.2, rel=0.05)
    assert np.corrcoef(reading[50:], reading[:-50])[0, 1] == pytest.approx(math.exp(-1.0), abs=0.03)


def test_a_walk_grows_with_the_root_of_time():
    ends = [random_walk(101, 0.04, chance(seed))[-1] for seed in range(2000)]
    assert np.std(ends) == pytest.approx(2.0, rel=0.06)
    reading = Sensor(random_walk=3.0, rate=25.0).read(np.zeros(50_000), chance())
    assert reading[0] == 0.0
    assert np.std(np.diff(reading)) == pytest.approx(3.0 / 5.0, rel=0.03)


def test_chance_is_repeated_and_one_source_does_not_move_another():
    full = Sensor(noise=0.1, jitter=1e-3, loss=0.1, repeats=0.1, instability=0.1, random_walk=0.1)
    first, second = [], []
    for results in (first, second):
        generator = chance(3)
        taken, _ = full.instants(10.0, generator)
        results.append(full.read(np.sin(taken), generator))
    assert np.array_equal(first[0], second[0])
    with_more, without = chance(4), chance(4)
    Sensor(jitter=1e-3, loss=0.1).instants(10.0, with_more)
    Sensor().instants(10.0, without)
    noisy = Sensor(noise=1.0)
    assert np.array_equal(noisy.read(np.zeros(9), with_more), noisy.read(np.zeros(9), without))


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"rate": 0.0}, "'rate' is 0 Hz"),
        ({"noise": -1.0}, "'noise' is -1"),
        ({"quantum": -0.1}, "'quantum' is -0.1"),
        ({"delay": -1.0}, "'delay' is -1 s"),
        ({"jitter": -1e-3}, "'jitter' is -0.001 s"),
        ({"noise": math.nan}, "'noise' is nan"),
        ({"wrap": (1.0, 1.0)}, "the wrap of a sensor"),
        ({"saturation": (2.0, 1.0)}, "the saturation of a sensor"),
        ({"loss": 0.9}, "raise loss_run"),
    ],
)
def test_impossible_sensors_are_refused(wrong, words):
    with pytest.raises(ParameterError, match=words):
        Sensor(**wrong)


def test_every_field_says_its_unit():
    hints = Sensor.__annotations__
    assert all("Annotated" in str(hints[field.name]) for field in dataclasses.fields(Sensor))
