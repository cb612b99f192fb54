"""A scenario is one run, described whole: the same again from what its recording holds."""

import pickle

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.toml import Document
from tierod_lab.ground.scenarios import from_document, load

TEXT = """\
name = "mine"
description = "Mine."
car = "midsize-eps-light"
course = "city"
seconds = 6.0
seed = 2

[scatter]

[[faults]]
element = "yaw_rate"
behaviour = "offset"
size = 0.1
start = "3 s"
"""


@pytest.fixture(scope="module")
def scenario():
    return from_document(Document.parse(TEXT, "mine.toml"))


def values(outcome):
    return {name: channel.values for name, channel in outcome.recording.channels.items()}


def test_the_same_scenario_gives_the_same_bits_and_another_seed_does_not(scenario):
    once, again, other = values(scenario.run()), values(scenario.run()), values(scenario.with_run(seed=3).run())
    assert once.keys() == again.keys() == other.keys()
    for name, series in once.items():
        assert np.array_equal(series, again[name])
    assert not np.array_equal(once["truth_steering_wheel_angle"], other["truth_steering_wheel_angle"])


def test_it_can_be_sent_to_another_process(scenario):
    sent = pickle.loads(pickle.dumps(scenario))
    assert sent.digest == scenario.digest
    here = values(scenario.run())
    for name, series in values(sent.run()).items():
        assert np.array_equal(series, here[name])


def test_the_recording_shows_all_that_it_takes_to_drive_it_again(scenario):
    result = scenario.with_run(seconds=4.0, seed=9).run().recording.metadata
    again = from_document(Document.parse(result["scenario_text"]))
    assert again.digest == result["scenario_sha256"] == scenario.digest
    driven = again.with_run(result["seconds"], result["seed"]).run()
    assert driven.recording.metadata["vehicle"] == result["vehicle"], "scatter included"
    assert (result["virtual_car"], result["route_seed"]) == ("midsize-eps-light", 9)
    (window,) = result["faults"]
    assert (window["element"], window["start"], window["end"]) == ("yaw_rate", 3.0, 4.0)


def test_a_longer_or_shorter_run(scenario):
    shorter = scenario.with_run(seconds=2.0)
    assert (shorter.duration, shorter.faults) == (2.0, ()), "the fault would begin later"
    assert scenario.with_run(seconds=4.0).faults == scenario.faults
    longer = scenario.with_run(seconds=2000.0)
    assert longer.course.duration == 2000.0
    with pytest.raises(ParameterError, match="the course 'slalom' ends after .* s; a run of 100 s is too long for it"):
        load("slalom-winter-tyres").with_run(seconds=100.0)
    for wrong in (0.0, -1.0, 1e-5, 1e9, float("inf"), float("nan")):
        with pytest.raises(ParameterError, match="a run cannot last .* s; give at least a step"):
            scenario.with_run(seconds=wrong)


def test_a_shorter_run_is_the_beginning_of_the_longer_one(scenario):
    part, whole = values(scenario.with_run(seconds=2.5).run()), values(scenario.run())
    assert np.array_equal(part["truth_yaw_rate"], whole["truth_yaw_rate"][:250])


def test_the_digest_is_of_what_is_said_and_not_of_how(tmp_path):
    def digest(text, course="speed = 10.0"):
        (tmp_path / "way.toml").write_text(f'kind = "slalom"\ndescription = "Mine."\n{course}', encoding="utf-8")
        return from_document(Document.parse(text, tmp_path / "mine.toml")).digest

    text = 'name = "a"\ndescription = "A."\ncar = "midsize-eps"\ncourse = "way.toml"\n'
    assert digest(text) == digest("# a remark\n" + text.replace(" = ", "  =  "))
    assert digest(text) != digest(text + "seed = 1")
    assert digest(text) != digest(text, "speed = 11.0"), "a file that it names has changed"


def test_a_run_that_diverges_says_when():
    text = 'name = "a"\ndescription = "A."\ncourse = "iso-7401-step"\n[car]\nname = "midsize-eps"\n'
    outcome = from_document(Document.parse(text + 'parameters.chassis.suspension_lag = "0.1 ms"')).run()
    assert 0.0 < outcome.diverged_at < 1.0
    assert all(np.isfinite(channel.values).all() for channel in outcome.recording.channels.values())
    assert outcome.recording.span[1] <= outcome.diverged_at
