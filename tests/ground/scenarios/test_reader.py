"""Scenario files: what they may say, and how a slip is reported before anything is driven."""

import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground.chassis import SingleTrack
from tierod_lab.ground.faults import AtTime, Ramp
from tierod_lab.ground.scenarios import load, shipped
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


def test_car_and_course_may_be_names_alone(write):
    scenario = load(write('name = "short"\ndescription = "Short."\ncar = "midsize-eps-light"\ncourse = "slalom"'))
    assert isinstance(scenario.car.chassis, SingleTrack)
    assert scenario.duration == scenario.course.duration
    assert scenario.faults == ()
    assert scenario.scatter is None


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


def test_a_course_of_any_length_lasts_as_long_as_the_scenario(write):
    begin = 'name = "x"\ndescription = "X."\ncar = "midsize-eps"\n'
    assert load(write(begin + 'course = "straight"\nseconds = "10 min"')).course.duration == 600.0
    shorter = load(write(begin + 'course = "straight"\nseconds = "10 s"'))
    assert (shorter.course.duration, shorter.duration) == (60.0, 10.0)


def test_a_course_keeps_a_seed_of_its_own(write):
    begin = 'name = "x"\ndescription = "X."\ncar = "midsize-eps"\nseed = 3\n'
    follows = load(write(begin + 'course = "city"'))
    keeps = load(write(begin + 'course = { name = "city", seed = 8 }'))
    assert (follows.course.seed, keeps.course.seed) == (3, 8)
    assert (follows.with_run(seed=5).course.seed, keeps.with_run(seed=5).course.seed) == (5, 8)


SLIPS = [
    ("midsize-eps", "midsize-esp", 7, "no virtual car is called 'midsize-esp'; did you mean 'midsize-eps'"),
    ('"winter"', '"wintre"', 8, "no tyres are called 'wintre'; did you mean 'winter'"),
    ("friction.law", "friction.low", 10, "'steering.friction.low'; did you mean 'steering.friction.law'"),
    ('"lu-gre"', '"lugre"', 10, "no steering.friction.law is called 'lugre'; did you mean 'lu-gre'"),
    ("steering.friction.level = ", "steering.frictoin.level = ", 12, "did you mean 'steering.friction.level'"),
    ("5 N*m", "5 N", 12, "is '5 N', but is measured in 'N\\*m'"),
    ("5 N*m", "-5 N*m", 12, "has to be at least 0 N\\*m"),
    ('"country"', '"cuntry"', 16, "there is no course 'cuntry'; did you mean 'country'"),
    ("wait =", "wiat =", 17, "'wiat' is not known here; did you mean 'wait'"),
    ('"1 s"', '"1 m"', 17, "is '1 m', but is measured in 's'"),
    ('"bench"', '"banch"', 20, "no set of sensors is called 'banch'; did you mean 'bench'"),
    ("sensors.yaw_rate", "sensors.yaw_rat", 21, "a sensor cannot measure 'yaw_rat'; did you mean 'yaw_rate'"),
    ("0.2 deg/s", "0.2 m", 22, "is '0.2 m', but is measured in 'rad/s'"),
    ('noise = "0.2 deg/s"', "rate = 5000", 22, "reads 5000 times a second, but the car is computed only 1000 times"),
    ('sensors.yaw_rate]\nnoise = "0.2 deg/s"', "sensors.motor_current_a]", 21, "has no channel 'motor_current_a'"),
    ("[[faults]]\nelement = \"steering.friction.level\"", "[[faults]]\nelement = \"steering.friction.levl\"", 25,
     "did you mean 'steering.friction.level'"),
    ("[[faults]]\nelement = \"steering.friction.level\"", "[[faults]]\nelement = \"steering_motor_1_torque\"", 25,
     "steering_motor_1_torque"),
    ('kind = "ramp"', 'kind = "rump"', 26, "no kind is called 'rump'; did you mean 'ramp'"),
    ("yaw-rate-outlier", "yaw-rate-outlayer", 30, "did you mean 'yaw-rate-outlier'"),
    ('start = "1 min"', 'start = "1 min"\nend = "50 s"', 32, "the fault ends at 50 s, before it begins at 60 s"),
    ('start = "1 min"', 'start = "3 min"', 31, "the fault begins at 180 s, but the run ends at 120 s"),
    ("seed = 4", "seed = -4", 4, "'seed' is -4, but has to be at least 0"),
    ('"2 min"', '"2 N"', 3, "is '2 N', but is measured in 's'"),
    ('"2 min"', "0", 3, "'seconds' is 0 s, but has to be above 0 s"),
    ('"2 min"', "1e-5", 3, "cannot last 1e-05 s; give at least a step of the car, 0.001 s"),
    ('"2 min"', "1e9", 3, "cannot last 1e\\+09 s; .* at most 14400 s"),
    ('"lu-gre"', "3", 10, "no steering.friction.law is called '3'; known: coulomb"),
    ('"chassis.mass" = "1.7 t"', "step_time = 0.002", 6, "is computed every 0.002 s, but .* 'driver.step_time'"),
    ("[course]", "[cuorse]", 15, "'cuorse' is not known here; did you mean 'course'"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "line", "words"), SLIPS, ids=[f"{new[-25:]}" for _, new, _, _ in SLIPS])
def test_a_slip_or_a_contradiction_is_reported_with_its_line(write, old, new, line, words):
    with pytest.raises(ParameterError, match=f"mine.toml, line {line}: .*{words}"):
        load(write(FILE.replace(old, new, 1)))


BEGIN = 'name = "x"\ndescription = "X."\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BEGIN + 'car = "midsize-eps"\ncourse = "bench-sweep"', "line 4: the course 'bench-sweep' sets 'motor_torque'"),
        (BEGIN + 'car = "column-bench"\ncourse = "city"', "line 4: the course 'city' sets 'road"),
        (BEGIN + 'car = "midsize-eps"\ncourse = "slalom"\nseconds = 500', "line 5: the course 'slalom' ends after"),
        (BEGIN + 'course = "slalom"\n[car]\ntyres = "winter"', "line 4: 'car.name' is missing; choose one of: active"),
        (BEGIN + 'car = "midsize-eps"\n[course]\nspeed = 3', "line 4: 'course.name' is missing; choose one of: bench"),
        (BEGIN + 'car = "midsize-eps"\ncourse = 3', "line 4: 'course' has to be the name of a course, or a table"),
        (BEGIN + 'car = "midsize-eps"', "'course' is missing; add it"),
        (BEGIN + 'course = "mine.csv"\ncar = "midsize-eps"', "line 3: .*mine.csv"),
        ("name = 3 4", "mine.toml is not valid TOML.*no scenario can be read"),
    ],
)  # fmt: skip
def test_parts_that_do_not_fit_each_other(write, text, words):
    with pytest.raises(ParameterError, match=words):
        load(write(text))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("steady-circel", "no scenario is called 'steady-circel'; did you mean 'steady-circle'"),
        ("absent.toml", "there is no scenario file absent.toml; 'tierod scenarios' lists those that are shipped"),
    ],
)
def test_a_scenario_that_is_not_there(name, words):
    with pytest.raises(ParameterError, match=words):
        load(name)


def test_a_file_wins_over_no_shipped_name(write, monkeypatch):
    path = write(FILE, shipped()[0])
    monkeypatch.chdir(path.parent)
    assert load(shipped()[0]).name == shipped()[0]
