import math
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.faults.car_stand_in import SENSORS, Car
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
    shipped,
    trigger_of,
)
from tierod_lab.ground.faults.fault import Comparison
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
        ("element = 'yaw_rate'\nbehaviour = 'TOTAL_LOSS'", Fault("yaw_rate", TotalLoss())),
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
            "element = 'steering.level'\nbehaviour = { kind = 'step', to = '8 N*m' }\ntrigger = 'at 2 km'",
            Fault("steering.level", Step("8 N*m"), AtDistance(2000.0)),
        ),
        (
            "element = 'yaw_rate'\nbehaviour = 'stuck'\ntrigger = { kind = 'within', earliest = 3, latest = '6 s' }",
            Fault("yaw_rate", Stuck(), Within(3.0, 6.0)),
        ),
        (
            "element = 'yaw_rate'\nbehaviour.kind = 'intermittent'\nbehaviour.behaviour = { kind = 'gain', gain = 2 }\n"
            "behaviour.mean_on = '50 ms'",
            Fault("yaw_rate", Intermittent(Gain(2.0), 0.05)),
        ),
        (
            "element = 'yaw_rate'\nbehaviour = { kind = 'intermittent', behaviour = { kind = 'gain' } }\nsize = 3",
            Fault("yaw_rate", Intermittent(Gain(3.0))),
        ),
        (
            "element = 'yaw_rate'\nbehaviour = { kind = 'intermittent', behaviour = 'total-loss' }",
            Fault("yaw_rate", Intermittent(TotalLoss())),
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
        ("at 30 s", AtTime(30.0)),
        ("at 0.5 min", AtTime(30.0)),
        (" at 500 m ", AtDistance(500.0)),
        ("between 10 s and 1 min", Within(10.0, 60.0)),
        ("vehicle_speed > 10 m/s", When("vehicle_speed > 10 m/s")),
        ("vehicle_speed>10 m/s for 500 ms", When("vehicle_speed>10 m/s", 0.5)),
        (
            "|yaw_rate| < 5 deg/s and roll_rate > 1 for 2 s",
            When("|yaw_rate| < 5 deg/s and roll_rate > 1", 2.0),
        ),
    ],
)
def test_a_trigger_in_words(text, expected):
    assert trigger_of(text) == expected


def test_a_condition_in_parts():
    first, second = When("|yaw_rate| <= -5 deg/s and vehicle_speed > 1e1").comparisons
    assert first == Comparison("yaw_rate", True, "<=", -5.0, "deg/s")
    assert second == Comparison("vehicle_speed", False, ">", 10.0, "")


FAULT = "[[faults]]\nelement = 'yaw_rate'\nbehaviour = 'total-loss'\n"


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (FAULT + "strat = 3", 4, "'strat' is not known here; did you mean 'start'?"),
        (FAULT + "start = '3 m'", 4, "measured in 's'"),
        (FAULT + "start = -1", 4, "at least 0 s"),
        (FAULT + "duration = 0", 4, "above 0 s"),
        (FAULT + "start = 5\nend = 3", 5, "ends at 3 s, before it begins at 5 s"),
        (FAULT + "start = 5\nend = 5", 5, "ends at 5 s, as it begins at 5 s"),
        (FAULT + "end = 5\nduration = 3", 4, "exclude each other"),
        (FAULT + "start = 5\ntrigger = 'always'", 4, "exclude each other"),
        (FAULT + "trigger = 'at 3 s'\nend = 2", 5, "before it begins"),
        (FAULT + "trigger = 'at 3 m'\nend = 2", 5, "give its 'duration'"),
        (FAULT + "trigger = 'at 3 kg'", 4, "neither a time nor a distance"),
        (FAULT + "trigger = 'between 3 s and 2 s'", 4, "is not before the latest"),
        (FAULT + "trigger = 'between 3 s and 2 m'", 4, "is not a time"),
        (FAULT + "trigger = 'somehow'", 4, "is not a condition; write it like"),
        (FAULT + "trigger = '|yaw_rate > 3'", 4, "is not a condition"),
        (FAULT + "trigger = { kind = 'when', condition = 'yaw_rate > 3 for 2 s' }", 4, "give what follows 'for' as"),
        (FAULT + "trigger = { kind = 'at-tme' }", 4, "did you mean 'at-time'"),
        (FAULT + "trigger = { kind = 'within', earliest = 3, latest = 2 }", 4, "is not before the latest"),
        (FAULT + "size = 3", 4, "'total-loss' has no size"),
        ("[[faults]]\nbehaviour = 'total-loss'", 1, "'element' is missing"),
        ("[[faults]]\nelement = 3\nbehaviour = 'total-loss'", 2, "has to be a text"),
        ("[[faults]]\nelement = 'yaw_rate'", 1, "'behaviour' is missing; choose one of"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = 'totalloss'", 3, "did you mean 'total-loss'"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = 3", 3, "has to be a table"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = 'offset'", 3, "'size' is missing; add it, in rad/s"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = { kind = 'offset', size = '3 m' }", 3, "measured in 'rad/s'"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = { kind = 'offset', size = 'big' }", 3, "has to be a number"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = { kind = 'offset', size = 1 }\nsize = 2", 4, "state the same"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = { kind = 'drop-out', share = 2 }", 3, "at most 1"),
        (
            "[[faults]]\nelement = 'yaw_rate'\n[faults.behaviour]\nkind = 'bit-flip'\nbit = 16",
            3,
            "does not exist",
        ),
        ("[[faults]]\nelement = 'yaw_rate'\n[faults.behaviour]\nkind = 'gain'\ngian = 16", 5, "did you mean 'gain'"),
        (
            FAULT + "[[faults.also]]\nelement = 'a'\nbehaviour = 'gain'\nsize = 2\nstart = 3",
            8,
            "'start' is not known",
        ),
        (FAULT + "also = 3", 4, "has to be a list"),
        (FAULT + FAULT + "duration = '1 m'", 7, "measured in 's'"),
        ("[[faults]]\nuse = 'friction-stp'", 2, "did you mean 'friction-step'"),
        ("[[faults]]\nuse = 'absent.toml'", 2, "there is no fault file"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = 'offset'\nsize = [1, 2]", 4, "has to be a number in rad/s or"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = 'offset'\nsize = true", 4, "has to be a number in rad/s or"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = 'totalloss'\nsize = 3", 3, "did you mean 'total-loss'"),
        ("[[faults]]\nelement = 'yaw_rate'\nbehaviour = 'intermittent'\nsize = 3", 3, "'kind' is missing; choose one"),
        (FAULT + "also = ['a']", 4, "has to be a table with 'element' and 'behaviour'"),
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
        ("element = 'yaw_rat'\nbehaviour = 'total-loss'", 2, "could fail; did you mean 'yaw_rate'"),
        ("element = 'steering.levl'\nbehaviour = 'step'\nsize = 1", 2, "did you mean 'steering.level'"),
        ("element = 'road.curvture'\nbehaviour = 'step'\nsize = 1", 2, "did you mean 'road.curvature'"),
        ("element = 'sideslip_angle'\nbehaviour = 'total-loss'", 2, "no sensor records 'sideslip_angle'"),
        ("element = 'rack_force'\nbehaviour = 'total-loss'", 2, "the car has no 'rack_force'"),
        (
            "element = 'actuator.yaw_rate'\nbehaviour = 'stuck'",
            2,
            "no actuator of the car is called 'yaw_rate'; write 'sensor.yaw_rate'",
        ),
        ("element = 'sensor.mass'\nbehaviour = 'stuck'", 2, "no sensor records 'mass'; write 'car.mass'"),
        (
            "element = 'loop.motor_torque'\nbehaviour = 'stuck'",
            2,
            "write 'sensor.motor_torque' or 'actuator.motor_torque'",
        ),
        (
            "element = 'car.mss'\nbehaviour = 'gain'\nsize = 2",
            2,
            "no parameter of the car is called 'mss'; did you mean",
        ),
        ("element = 'step_time'\nbehaviour = 'gain'\nsize = 2", 2, "the car has no 'step_time'"),
        (
            "element = 'yaw_rat | nothing'\nbehaviour = 'total-loss'",
            2,
            "would change nothing: the car has no 'yaw_rat'",
        ),
        ("element = 'nothing'\nbehaviour = 'total-loss'", 2, "the fault has no element"),
        ("element = 'motor_torque'\nbehaviour = 'stuck'", 2, "write 'actuator.motor_torque' or 'sensor.motor_torque'"),
        (
            "element = 'yaw_rate'\nbehaviour = 'stuck'\n[[faults.also]]\nelement = 'mss'\nbehaviour = 'gain'\nsize = 2",
            5,
            "the car has no 'mss'",
        ),
        (
            "element = 'yaw_rate'\nbehaviour = 'stuck'\n[[faults.also]]\nelement='mass'\nbehaviour='step'\nsize = 0",
            7,
            "'mass' would become 0 kg",
        ),
        (
            "element = 'yaw_rate'\nbehaviour = 'torque-loss'",
            3,
            "'torque-loss' does not fit 'yaw_rate', a recorded",
        ),
        ("element = 'driver_torque'\nbehaviour = 'delay'\nsize = '0.1 s'", 3, "with 'sensor.driver_torque'"),
        ("element = 'driver_torque'\nbehaviour = 'bit-flip'\nsize = 3", 3, "which a control unit of the car reads"),
        ("element = 'steering.level'\nbehaviour = 'stuck'", 3, "'stuck' does not fit 'steering.level', a parameter"),
        ("element = 'mass'\nbehaviour = 'drop-out'", 3, "possible: course, drift, gain"),
        ("element = 'yaw_rate'\nbehaviour = 'step'\nsize = 1", 3, "does not fit"),
        ("element = 'road.curvature'\nbehaviour = 'with-temperature'\nsize = 400", 3, "something around the car"),
        ("element = 'mass'\nbehaviour = 'step'\nsize = -3", 4, "'mass' would become -3 kg, but has to be above 0 kg"),
        (
            "element = 'road.adhesion_left'\nbehaviour = 'step'\nsize = -1",
            4,
            "would become -1, but has to be at least 0",
        ),
        ("element = 'road.support'\nbehaviour = { kind = 'ramp', to = 2, over = 1 }", 3, "'road.support' would become"),
        ("element = 'road.bank_angle'\nbehaviour = 'step'\nsize = '91 deg'", 4, "would become 1.588"),
        ("element = 'mass'\nbehaviour = { kind = 'step', to = -3 }", 3, "would become -3 kg"),
        ("element = 'mass'\nbehaviour = 'drift'\nsize = -200", 4, "'mass' would become"),
        ("element = 'mass'\nbehaviour = { kind = 'ramp', to = 0, over = 3 }", 3, "would become 0 kg"),
        ("element = 'mass'\nbehaviour = 'step'\nsize = '3 m'", 4, "'to' is '3 m', but is measured in 'kg'"),
        ("element = 'mass'\nbehaviour = { kind = 'course', times = [0, 0.05, 0.1], values = [1, -1, 1] }", 3, "-1 kg"),
        ("element = 'yaw_rate'\nbehaviour = { kind = 'bit-flip', bit = 3 }", 3, "the sensor has no quantum"),
        ("element = 'yaw_rate'\nbehaviour = 'total-loss'\nduration = '0.5 ms'", 4, "lasts 0.0005 s, less than a step"),
        ("element = 'yaw_rate'\nbehaviour = 'total-loss'\nstart = 10", 4, "begins at 10 s, but the run ends at 10 s"),
        ("element = 'yaw_rate'\nbehaviour = 'total-loss'\ntrigger = 'between 3 s and 12 s'", 4, "begins at 12 s"),
        ("element = 'yaw_rate'\nbehaviour = 'total-loss'\ntrigger = 'speed > 3'", 4, "did you mean"),
        ("element = 'yaw_rate'\nbehaviour = 'total-loss'\ntrigger = 'yaw_rate > 3 m'", 4, "cannot be held against 3 m"),
        ("element = 'yaw_rate'\nbehaviour = 'sluggish'\nsize = 1", 3, "does not fit"),
    ],
)
def test_a_contradiction_with_the_car_is_refused_with_its_line(text, line, words):
    fault = one(text)
    with pytest.raises(ParameterError) as caught:
        Schedule([fault], Car(), SENSORS, 0, 10.0)
    assert words in str(caught.value)
    assert str(caught.value).startswith(f"drive.toml, line {line}: ")


@pytest.mark.parametrize("text", ["duration = 5", "start = '5 s'", "trigger = 'between 6 s and 8 s'"])
def test_a_drift_is_held_against_the_range_for_as_long_as_it_can_last(text):
    drift = "element = 'mass'\nbehaviour = 'drift'\nsize = -200\n"
    assert Schedule([one(drift + text)], Car(), SENSORS, 0, 10.0).parameters == ("mass",)
    with pytest.raises(ParameterError, match="'mass' would become"):
        Schedule([one(drift + text)], Car(mass=700.0), SENSORS, 0, 10.0)


def test_a_fault_made_in_python_is_called_by_its_name():
    with pytest.raises(ParameterError, match="fault 'yaw_rat total-loss': the car has no 'yaw_rat'"):
        Schedule([Fault("yaw_rat", TotalLoss())], Car(), SENSORS, 0, 10.0)


def test_the_first_of_several_elements_that_the_car_has():
    fault = Fault("steering.friction.level | steering.level", Step(6.0))
    assert Schedule([fault], Car(), SENSORS, 0, 10.0).parameters == ("steering.level",)


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


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_fault_is_described(name):
    file = load(name)
    assert file.description.endswith(".")
    assert len(file.source) > 10
    assert file.fault.label == name


@given(st.text("yaw_rte>< |=0123456789.mskhfornd/", max_size=40))
def test_any_text_is_a_trigger_or_a_sentence(text):
    try:
        trigger = trigger_of(text)
    except ParameterError as error:
        assert len(str(error)) > 20  # noqa: PT017
    else:
        assert trigger


def test_amounts_without_a_car_are_checked_as_far_as_they_go():
    assert one("element = 'road.bank_angle'\nbehaviour = 'step'\nsize = '5 deg'").behaviour == Step(math.radians(5.0))
    assert one("element = 'steering.level'\nbehaviour = 'step'\nsize = '5 deg'").behaviour == Step("5 deg")


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


def test_a_fault_can_be_sent_to_another_process():
    fault = one("element = 'yaw_rate'\nbehaviour = 'stuck'\ntrigger = 'vehicle_speed > 3 m/s for 1 s'")
    sent = pickle.loads(pickle.dumps(fault))
    assert sent == fault
    assert hash(sent) == hash(fault)
    assert sent.origin.document.path.name == "drive.toml"
