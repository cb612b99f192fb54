"""Scenario files: what they may say, how a slip is reported before anything is driven, and one run described whole."""

import re
from pathlib import Path

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.toml import Document
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.faults import AtTime, Fault, Intermittent, Offset, Ramp, Step, TotalLoss, When, Within
from tierod_lab.ground.faults.reading import fault_in_words
from tierod_lab.ground.scenarios import from_document, load
from tierod_lab.ground.steering.friction import LuGre

FILE = """\
name = "mine"
description = "A drive of my own."
seconds = "2 min"
seed = 4

[car]
name = "midsize-eps"
tyres = "winter"
[car.parts]
"steering.friction.law" = "lu-gre"
[car.parameters]
steering.friction.level = "5 N*m"
"chassis.mass" = "1.7 t"

[course]
name = "country"
wait = "1 s"

[sensors]
preset = "bench"
[sensors.yaw_rate]
noise = "0.2 deg/s"

[[faults]]
element = "steering.friction.level"
behaviour = { kind = "ramp", to = "9 N*m", over = "30 s" }
start = "40 s"

[[faults]]
use = "yaw-rate-outlier"
start = "1 min"
"""


@pytest.fixture
def write(tmp_path):
    def put(text, name="mine.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return put


def test_a_whole_file(write):
    scenario = load(write(FILE))
    assert (scenario.name, scenario.duration, scenario.seed) == ("mine", 120.0, 4)
    assert scenario.car.chassis.mass == 1700.0
    assert scenario.car.chassis.front.tyre.cornering_stiffness == 18.0
    assert isinstance(scenario.car.steering.friction.law, LuGre)
    assert scenario.car.steering.friction.level == 5.0
    assert (scenario.course.name, scenario.course.wait, scenario.course.seed) == ("country", 1.0, 4)
    assert scenario.sensors["yaw_rate"].noise == pytest.approx(3.49e-3, rel=1e-3)
    assert scenario.sensors["yaw_rate"].rate == 1000.0
    ramp, outlier = scenario.faults
    assert isinstance(ramp.behaviour, Ramp)
    assert ramp.trigger == AtTime(40.0)
    assert outlier.trigger == AtTime(60.0)


def test_files_are_looked_for_beside_the_scenario(write, monkeypatch, tmp_path_factory):
    write('kind = "slalom"\ndescription = "Mine."\nspeed = "20 km/h"\ncones = 3', "cones.toml")
    write("time [s],speed [km/h]\n0,10\n5,10\n9,20", "speeds.csv")
    mine = 'name = "mine"\ndescription = "My car."\nsource = "me"\nkind = "eps-car"\n'
    write(mine + 'good_for = ["a"]\nnot_good_for = ["b"]', "car.toml")
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    begin = 'name = "x"\ndescription = "X."\ncar = "car.toml"\n'
    scenario = load(write(begin + 'course = "cones.toml"'))
    assert scenario.course.cones == 3
    assert set(scenario.files) == {"car.toml", "cones.toml"}
    assert load(write(begin + 'course = "speeds.csv"')).duration == 9.0
    table = load(write(begin + 'course = { kind = "time-table", file = "speeds.csv" }'))
    assert (table.course.name, table.duration) == ("time-table", 9.0)
    assert set(table.files) == {"car.toml", "speeds.csv"}


SLIPS = [
    ("midsize-eps", "midsize-esp", 7, "no virtual car is called 'midsize-esp'; did you mean 'midsize-eps'"),
    ('"winter"', '"wintre"', 8, "no tyres are called 'wintre'; did you mean 'winter'"),
    ("friction.law", "friction.low", 10, "'steering.friction.low'; did you mean 'steering.friction.law'"),
    ("steering.friction.level = ", "steering.frictoin.level = ", 12, "did you mean 'steering.friction.level'"),
    ("5 N*m", "5 N", 12, "is '5 N', but is measured in 'N\\*m'"),
    ('"country"', '"cuntry"', 16, "there is no course 'cuntry'; did you mean 'country'"),
    ("wait =", "wiat =", 17, "'wiat' is not known here; did you mean 'wait'"),
    ('"bench"', '"banch"', 20, "no set of sensors is called 'banch'; did you mean 'bench'"),
    ("0.2 deg/s", "0.2 m", 22, "is '0.2 m', but is measured in 'rad/s'"),
    ('noise = "0.2 deg/s"', "rate = 5000", 22, "reads 5000 times a second, but the car is computed only 1000 times"),
    ('sensors.yaw_rate]\nnoise = "0.2 deg/s"', "sensors.motor_current_a]", 21, "has no channel 'motor_current_a'"),
    ('level"\nbeh', 'levl"\nbeh', 25, "did you mean 'steering.friction.level'"),
    ("yaw-rate-outlier", "yaw-rate-outlayer", 30, "did you mean 'yaw-rate-outlier'"),
    ('start = "1 min"', 'start = "3 min"', 31, "the fault begins at 180 s, but the run ends at 120 s"),
    ('"2 min"', "1e9", 3, "cannot last 1e\\+09 s; .* at most 14400 s"),
    ('"chassis.mass" = "1.7 t"', "step_time = 0.002", 6, "is computed every 0.002 s, but .* 'driver.step_time'"),
    ("[course]", "[cuorse]", 15, "'cuorse' is not known here; did you mean 'course'"),
]


@pytest.mark.parametrize(("old", "new", "line", "words"), SLIPS, ids=[f"{new[-25:]}" for _, new, _, _ in SLIPS])
def test_a_slip_or_a_contradiction_is_reported_with_its_line(write, old, new, line, words):
    with pytest.raises(ParameterError, match=f"mine.toml, line {line}: .*{words}"):
        load(write(FILE.replace(old, new, 1)))


BEGIN = 'name = "x"\ndescription = "X."\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BEGIN + 'car = "midsize-eps"\ncourse = "bench-sweep"', "line 4: the course 'bench-sweep' sets 'motor_torque'"),
        (BEGIN + 'car = "midsize-eps"\ncourse = "slalom"\nseconds = 500', "line 5: the course 'slalom' ends after"),
        (BEGIN + 'course = "slalom"\n[car]\ntyres = "winter"', "line 4: 'car.name' is missing; choose one of: active"),
        (BEGIN + 'car = "midsize-eps"\ncourse = 3', "line 4: 'course' has to be the name of a course, or a table"),
        ("name = 3 4", "mine.toml is not valid TOML.*no scenario can be read"),
    ],
)
def test_parts_that_do_not_fit_each_other(write, text, words):
    with pytest.raises(ParameterError, match=words):
        load(write(text))


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


def test_the_recording_shows_all_that_it_takes_to_drive_it_again(scenario):
    result = scenario.with_run(seconds=4.0, seed=9).run().recording.metadata
    again = from_document(Document.parse(result["scenario_text"]))
    assert again.digest == result["scenario_sha256"] == scenario.digest
    driven = again.with_run(result["seconds"], result["seed"]).run()
    assert driven.recording.metadata["vehicle"] == result["vehicle"], "scatter included"
    assert (result["virtual_car"], result["route_seed"]) == ("midsize-eps-light", 9)
    (window,) = result["faults"]
    assert (window["element"], window["start"], window["end"]) == ("yaw_rate", 3.0, 4.0)


def test_a_run_that_diverges_says_when():
    text = 'name = "a"\ndescription = "A."\ncourse = "iso-7401-step"\n[car]\nname = "midsize-eps"\n'
    outcome = from_document(Document.parse(text + 'parameters.chassis.suspension_lag = "0.1 ms"')).run()
    assert 0.0 < outcome.diverged_at < 1.0
    assert all(np.isfinite(channel.values).all() for channel in outcome.recording.channels.values())
    assert outcome.recording.span[1] <= outcome.diverged_at


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (Fault("yaw_rate", Offset(0.1), AtTime(3.0)), "yaw_rate offset 0.1 rad/s, at 3 s"),
        (Fault("yaw_rate", TotalLoss(), Within(1.0, 2.0)), "yaw_rate total-loss, at random between 1 s and 2 s"),
        (Fault("driver_torque", Intermittent(Offset(2.0))), "driver_torque intermittent 2 N*m, from the beginning"),
        (
            Fault("steering.friction.level", Step("8 N*m"), When("vehicle_speed > 3 m/s", 0.5), name="rusty"),
            "rusty: steering.friction.level step 8 N*m, when vehicle_speed > 3 m/s for 0.5 s",
        ),
    ],
)
def test_a_fault_in_words(fault, words):
    assert fault_in_words(fault) == words


GUIDE = (Path(__file__).parents[3] / "docs" / "how-to" / "simulate.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(toml|text)\n(.*?)```", GUIDE, re.DOTALL)


def block(words):
    return next(text for _, text in BLOCKS if words in text)


def test_the_scenario():
    scenario = from_document(Document.parse(block("country-road-after-rain"), "guide.toml"))
    assert (scenario.duration, scenario.course.seed, scenario.car.chassis.mass) == (600.0, 8, 1750.0)
    assert scenario.with_run(seconds=1.0).run().diverged_at is None


def test_the_car(tmp_path):
    path = tmp_path / "my-car.toml"
    path.write_text(block("my-car"), encoding="utf-8")
    car = catalogue.load(path)
    assert car.block.steering.friction.level == 3.2
    assert car.source_of("chassis.mass") == "scales"


FIRST_LINES = 'name = "x"\ndescription = "X."\ncar = "midsize-eps-light"\n'


def test_the_circuit():
    scenario = from_document(Document.parse(FIRST_LINES + block("A small round"), "guide.toml"))
    assert scenario.duration == 180.0
    assert scenario.with_run(seconds=1.0).run().diverged_at is None


def test_the_table(tmp_path):
    (tmp_path / "ice.csv").write_text(block("adhesion_right"), encoding="utf-8")
    scenario = from_document(Document.parse(FIRST_LINES + 'course = "ice.csv"', tmp_path / "guide.toml"))
    driven = scenario.run().recording["truth_road_friction"]
    assert driven.values[[0, -1]].tolist() == pytest.approx([1.0, 0.6], abs=1e-6)
