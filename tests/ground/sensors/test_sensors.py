import math

import numpy as np
import pytest

from tierod.core.toml import Document, build
from tierod_lab.ground import Sensor
from tierod_lab.ground.sensors import SensorSet, gauss_markov, lost_frames, random_walk


def chance(seed=0):
    return np.random.default_rng(seed)


def test_jitter_of_instants_and_of_stamps():
    exact = np.arange(20_000) / 100.0
    taken, stamps = Sensor(jitter=1e-3).instants(200.0, chance())
    assert np.array_equal(stamps, exact)
    assert np.std(taken[1:] - exact[1:]) == pytest.approx(1e-3, rel=0.03)
    taken, stamps = Sensor(stamp_jitter=1e-3).instants(200.0, chance())
    assert np.array_equal(taken, exact)
    assert np.std(stamps[1:] - exact[1:]) == pytest.approx(1e-3, rel=0.03)


@pytest.mark.parametrize(("share", "run"), [(0.05, 4.0), (0.9, 20.0)])
def test_lost_frames_have_their_share_and_their_runs(share, run):
    lost = lost_frames(400_000, share, run, chance())
    assert lost.mean() == pytest.approx(share, rel=0.05)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], lost, [False]]).astype(int)))
    runs = edges[1::2] - edges[::2]
    assert runs.mean() == pytest.approx(run, rel=0.05)


def test_an_encoder_runs_over_and_a_transducer_stays_at_its_limit():
    truth = np.array([-4.0, -math.pi, 0.0, 3.0, math.pi, 10.0])
    wrapped = Sensor(wrap=(-math.pi, math.pi)).read(truth, chance())
    np.testing.assert_allclose(wrapped, np.angle(np.exp(1j * truth)) * np.where(truth == math.pi, -1.0, 1.0), atol=1e-9)
    assert (wrapped < math.pi).all()
    np.testing.assert_array_equal(Sensor(saturation=(-1.0, 2.0)).read(truth, chance()), np.clip(truth, -1.0, 2.0))


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


def read(text, path="drive.toml"):
    document = Document.parse(text, path)
    return build(SensorSet, document.content.get("sensors", {}), document, ("sensors",))


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
