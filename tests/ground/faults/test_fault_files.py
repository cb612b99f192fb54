import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.rigs import SENSORS, Car
from tierod.core.errors import ParameterError
from tierod.core.toml import build
from tierod.core.toml_document import Document
from tierod_lab.ground import EpsCar, Scatter
from tierod_lab.ground.faults import (
    Always,
    AtDistance,
    AtTime,
    Course,
    Effect,
    Fault,
    Gain,
    Intermittent,
    Offset,
    Schedule,
    Step,
    Stuck,
    TotalLoss,
    When,
    Within,
    fault_of,
    load,
    trigger_of,
)
from tierod_lab.ground.sensors import SensorSet


def faults_of(document):
    return tuple(fault_of(each, document, ("faults", at)) for at, each in enumerate(document.content["faults"]))


def read(text):
    document = Document.parse(text, "drive.toml")
    return faults_of(document)


def one(text):
    (fault,) = read("[[faults]]\n" + text)
    return fault


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("element = 'yaw_rate'\nbehaviour = 'total-loss'", Fault("yaw_rate", TotalLoss())),
        (
            "element = 'yaw_rate'\nbehaviour = 'offset'\nsize = '0.3 rad/s'\nstart = '1 min'\n"
            "duration = '20 s'\nname = 'x'",
            Fault("yaw_rate", Offset(0.3), AtTime(60.0), 20.0, "x"),
        ),
        (
            "element = 'sensor.driver_torque'\nbehaviour = { kind = 'offset', size = '-300 N*cm' }\nstart = 5\nend = 8",
            Fault("sensor.driver_torque", Offset(-3.0), AtTime(5.0), 3.0),
        ),
        (
            "element = 'yaw_rate'\nbehaviour = 'stuck'\ntrigger = { kind = 'within', earliest = 3, latest = '6 s' }",
            Fault("yaw_rate", Stuck(), Within(3.0, 6.0)),
        ),
        (
            "element = 'yaw_rate'\nbehaviour = { kind = 'intermittent', behaviour = { kind = 'gain' } }\nsize = 3",
            Fault("yaw_rate", Intermittent(Gain(3.0))),
        ),
        (
            "element = 'road.adhesion_left'\nbehaviour = { kind = 'course', times = [0, '1 min'],"
            " values = ['20 %', 1] }",
            Fault("road.adhesion_left", Course((0.0, 60.0), (0.2, 1.0))),
        ),
        (
            "element = 'a'\nbehaviour = 'gain'\nsize = 2\n[[faults.also]]\nelement = 'b'\nbehaviour = 'step'\nsize = 1",
            Fault("a", Gain(2.0), also=(Effect("b", Step(1.0)),)),
        ),
    ],
)
def test_a_table_becomes_a_fault(text, expected):
    assert one(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("always", Always()),
        ("at 0.5 min", AtTime(30.0)),
        (" at 500 m ", AtDistance(500.0)),
        ("between 10 s and 1 min", Within(10.0, 60.0)),
        ("|yaw_rate| < 5 deg/s and roll_rate > 1 for 2 s", When("|yaw_rate| < 5 deg/s and roll_rate > 1", 2.0)),
    ],
)
def test_a_trigger_in_words(text, expected):
    assert trigger_of(text) == expected


FAULT = "[[faults]]\nelement = 'yaw_rate'\nbehaviour = 'total-loss'\n"


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (FAULT + "strat = 3", 4, "'strat' is not known here; did you mean 'start'?"),
        (FAULT + "start = '3 m'", 4, "measured in 's'"),
        (FAULT + "start = 5\nend = 3", 5, "ends at 3 s, before it begins at 5 s"),
        (FAULT + "end = 5\nduration = 3", 4, "exclude each other"),
        (FAULT + "start = 5\ntrigger = 'always'", 4, "exclude each other"),
        (FAULT + "trigger = 'at 3 m'\nend = 2", 5, "give its 'duration'"),
        (FAULT + "trigger = 'at 3 kg'", 4, "neither a time nor a distance"),
        (FAULT + "trigger = 'between 3 s and 2 s'", 4, "is not before the latest"),
        (FAULT + "trigger = 'somehow'", 4, "is not a condition; write it like"),
        (FAULT + "trigger = { kind = 'when', condition = 'yaw_rate > 3 for 2 s' }", 4, "give what follows 'for' as"),
        (FAULT + "size = 3", 4, "'total-loss' has no size"),
        ("[[faults]]\nbehaviour = 'total-loss'", 1, "'element' is missing"),
        ("[[faults]]\nelement = 'yaw_rate'", 1, "'behaviour' is missing; choose one of"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = 'totalloss'", 3, "did you mean 'total-loss'"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = { kind = 'offset', size = '3 m' }", 3, "measured in 'rad/s'"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = { kind = 'offset', size = 1 }\nsize = 2", 4, "state the same"),
        ("[[faults]]\nelement = 'yaw_rate'\n[faults.behaviour]\nkind = 'gain'\ngian = 16", 5, "did you mean 'gain'"),
        (FAULT + "[[faults.also]]\nelement = 'a'\nbehaviour = 'gain'\nsize = 2\nstart = 3", 8, "'start' is not known"),
        ("[[faults]]\nuse = 'friction-stp'", 2, "did you mean 'friction-step'"),
        ("[[faults]]\nuse = 'absent.toml'", 2, "there is no fault file"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = 'offset'\nsize = [1, 2]", 4, "has to be a number in rad/s or"),
        (
            FAULT + "duration = 2024-01-01",
            4,
            "'faults.0.duration' is datetime.date(2024, 1, 1), but has to be a number in s",
        ),
    ],
)
def test_a_slip_in_a_file_is_named_with_its_line(text, line, words):
    with pytest.raises(ParameterError) as caught:
        read(text)
    assert words in str(caught.value)
    assert str(caught.value).startswith(f"drive.toml, line {line}: ")


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("element = 'steering.levl'\nbehaviour = 'step'\nsize = 1", 2, "did you mean 'steering.level'"),
        ("element = 'sideslip_angle'\nbehaviour = 'total-loss'", 2, "no sensor records 'sideslip_angle'"),
        ("element = 'rack_force'\nbehaviour = 'total-loss'", 2, "the car has no 'rack_force'"),
        (
            "element = 'actuator.yaw_rate'\nbehaviour = 'stuck'",
            2,
            "no actuator of the car is called 'yaw_rate'; write 'sensor.yaw_rate'",
        ),
        (
            "element = 'yaw_rat | nothing'\nbehaviour = 'total-loss'",
            2,
            "would change nothing: the car has no 'yaw_rat'",
        ),
        ("element = 'motor_torque'\nbehaviour = 'stuck'", 2, "write 'actuator.motor_torque' or 'sensor.motor_torque'"),
        (
            "element = 'yaw_rate'\nbehaviour = 'stuck'\n[[faults.also]]\nelement='mass'\nbehaviour='step'\nsize = 0",
            7,
            "'mass' would become 0 kg",
        ),
        ("element = 'yaw_rate'\nbehaviour = 'torque-loss'", 3, "'torque-loss' does not fit 'yaw_rate', a recorded"),
        ("element = 'driver_torque'\nbehaviour = 'delay'\nsize = '0.1 s'", 3, "with 'sensor.driver_torque'"),
        ("element = 'mass'\nbehaviour = 'drop-out'", 3, "possible: course, drift, gain"),
        ("element = 'road.curvature'\nbehaviour = 'with-temperature'\nsize = 400", 3, "something around the car"),
        ("element = 'mass'\nbehaviour = 'step'\nsize = -3", 4, "'mass' would become -3 kg, but has to be above 0 kg"),
        ("element = 'road.bank_angle'\nbehaviour = 'step'\nsize = '91 deg'", 4, "would become 1.588"),
        ("element = 'mass'\nbehaviour = { kind = 'course', times = [0, 0.05, 0.1], values = [1, -1, 1] }", 3, "-1 kg"),
        ("element = 'yaw_rate'\nbehaviour = { kind = 'bit-flip', bit = 3 }", 3, "the sensor has no quantum"),
        ("element = 'yaw_rate'\nbehaviour = 'total-loss'\nduration = '0.5 ms'", 4, "lasts 0.0005 s, less than a step"),
        ("element = 'yaw_rate'\nbehaviour = 'total-loss'\nstart = 10", 4, "begins at 10 s, but the run ends at 10 s"),
        ("element = 'yaw_rate'\nbehaviour = 'total-loss'\ntrigger = 'speed > 3'", 4, "did you mean"),
        ("element = 'yaw_rate'\nbehaviour = 'total-loss'\ntrigger = 'yaw_rate > 3 m'", 4, "cannot be held against 3 m"),
    ],
)
def test_a_contradiction_with_the_car_is_refused_with_its_line(text, line, words):
    fault = one(text)
    with pytest.raises(ParameterError) as caught:
        Schedule([fault], Car(), SENSORS, 0, 10.0)
    assert words in str(caught.value)
    assert str(caught.value).startswith(f"drive.toml, line {line}: ")


def test_a_shipped_fault_is_changed_by_what_the_table_says():
    usual = load("friction-step").fault
    changed = one("use = 'friction-step'\nsize = '9 N*m'\nstart = 3\nduration = 2\nname = 'mine'")
    assert changed.element == usual.element
    assert (changed.behaviour, changed.trigger, changed.duration) == (Step("9 N*m"), AtTime(3.0), 2.0)
    assert one("use = 'friction-step'") == usual


def test_a_file_of_ones_own(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("description = 'x'\nsource = 'y'\nelement = 'yaw_rate'\nbehaviour = 'gain'\nsize = 2\n")
    document = Document.parse("[[faults]]\nuse = 'mine.toml'\nsize = 3", tmp_path / "drive.toml")
    (fault,) = faults_of(document)
    assert fault == Fault("yaw_rate", Gain(3.0), name="mine")
    path.write_text("description = 'x'\nelement = 'yaw_rate'\nbehaviour = 'gain'\n")
    with pytest.raises(ParameterError, match=r"mine.toml: 'source' is missing"):
        load(path)


def test_a_file_that_is_built_on_itself(tmp_path):
    for name, other in (("one", "two"), ("two", "one")):
        (tmp_path / f"{name}.toml").write_text(f"description = 'x'\nsource = 'y'\nuse = '{other}.toml'\n")
    document = Document.parse("[[faults]]\nuse = 'one.toml'", tmp_path / "drive.toml")
    with pytest.raises(ParameterError, match=r"one\.toml, line 3: .*two\.toml, line 3: .*one\.toml is built on itself"):
        faults_of(document)


@given(st.text("yaw_rte>< |=0123456789.mskhfornd/", max_size=40))
def test_any_text_is_a_trigger_or_a_sentence(text):
    try:
        trigger = trigger_of(text)
    except ParameterError as error:
        assert len(str(error)) > 20  # noqa: PT017
    else:
        assert trigger


def test_what_the_documentation_shows_can_be_read():
    page = Path(__file__).parents[3] / "docs" / "how-to" / "inject-faults.md"
    text = "\n".join(re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL))
    document = Document.parse(text, page)
    content, car = document.content, EpsCar()
    sensors = build(SensorSet, content["sensors"], document, ("sensors",))
    faults = faults_of(document)
    assert len(Schedule(faults, car, sensors, 0, 300.0).windows) == 8
    scatter = build(Scatter, content["scatter"], document, ("scatter",))
    scatter.draw(car, sensors, np.random.default_rng(0))
    assert len(scatter.parameters) == 2
