import math

import pytest

from tierod.core.errors import ParameterError
from tierod.core.toml_document import Document
from tierod_lab.papers.condition.rules.diagnosis import RuleDiagnosis
from tierod_lab.papers.condition.rules.symptoms import table_of

RESIDUALS = tuple(f"r{k}" for k in range(1, 8))
FAULTS = ("left", "right", "gyro", "angle")

HEAD = 'name = "two wheels"\ndescription = "For tests."\nsource = "nowhere"\n'
TEXT = (
    HEAD
    + """
confirm_time = "20 ms"
hold_on = "0.1 s"

[[rule]]
fault = "left"
abnormal = ["r1"]
larger = [["r1", "r2"]]

[[rule]]
fault = "right"
abnormal = ["r2"]
larger = [["r2", "r1"]]

[[rule]]
fault = "gyro"
abnormal = ["r3"]
normal = ["r4"]
fault_free = ["left", "right"]
weights = { r3 = 3.0 }

[[rule]]
fault = "angle"
positive = ["r3"]
abnormal = ["r4"]
"""
)


def read(text):
    return table_of(Document.parse(text, "own.toml", "rule"), RESIDUALS, FAULTS)


TABLE = read(TEXT)


class Run:
    def __init__(self, table=TABLE):
        self.block = RuleDiagnosis(table, 0.01)
        self.state = self.block.init()

    def feed(self, count=1, **ratios):
        sample = self.block.Sample(*(ratios.get(name, 0.0) for name in self.block.table.residuals))
        for _ in range(count):
            self.state, output = self.block.step(self.state, sample)
        return output


def names(flags):
    return {name for name, flag in flags._asdict().items() if flag}


def test_a_fault_is_named_once_its_rule_has_held_for_the_confirm_time():
    run = Run()
    assert names(run.feed(r1=1.5).faulty) == set()
    assert names(run.feed(r1=1.5).faulty) == {"left"}


def test_a_symptom_stays_for_the_hold_on_and_no_longer():
    run = Run()
    run.feed(3, r1=-1.5)
    assert names(run.feed(9).faulty) == {"left"}
    assert names(run.feed(3).faulty) == set()


def test_the_larger_of_two_decides():
    assert names(Run().feed(3, r1=2.0, r2=-1.5).faulty) == {"left"}
    assert names(Run().feed(3, r1=-2.0, r2=2.5).faulty) == {"right"}


def test_the_sign_counts_where_it_is_asked_for():
    assert names(Run().feed(3, r3=1.2, r4=1.2).faulty) == {"angle"}
    assert names(Run().feed(3, r3=-1.2, r4=1.2).faulty) == set()


def test_a_rule_that_wants_others_fault_free_waits_for_them():
    assert names(Run().feed(3, r3=2.0).faulty) == {"gyro"}
    assert names(Run().feed(3, r3=2.0, r1=2.0).faulty) == {"left"}


def test_a_residual_that_is_not_there_satisfies_nothing_and_leaves_the_score_to_the_others():
    missing = Run().feed(3, r3=2.0, r4=math.nan)
    assert names(missing.faulty) == set()
    assert missing.scores.gyro == 1.0
    assert missing.scores.angle == 1.0
    assert names(missing.candidates) == {"gyro", "angle"}


def test_the_score_is_the_weighted_share_of_what_is_as_asked():
    output = Run().feed(3, r4=2.0)
    assert output.scores.gyro == 0.0
    assert output.scores.angle == 0.5
    assert Run().feed(3, r3=2.0, r4=2.0).scores.gyro == pytest.approx(0.75)


SAME = HEAD + '\n[[rule]]\nfault = "left"\nabnormal = ["r1"]\n\n[[rule]]\nfault = "right"\nabnormal = ["r1"]\n'


def test_rules_that_coincide_are_reported_beforehand_and_name_candidates_when_they_hold():
    table = read(SAME)
    assert table.not_isolable() == (("left", "right"),)
    assert TABLE.not_isolable() == ()
    output = Run(table).feed(3, r1=2.0)
    assert names(output.faulty) == set()
    assert names(output.candidates) == {"left", "right"}
    alone = Run(read(SAME.replace('source = "nowhere"', 'source = "nowhere"\none_fault = false'))).feed(3, r1=2.0)
    assert names(alone.faulty) == {"left", "right"}


def test_nothing_abnormal_names_nothing():
    output = Run().feed(50, r1=0.9, r2=-0.9, r3=0.9, r4=0.9)
    assert names(output.faulty) == names(output.candidates) == set()
    assert output.abnormal == 0.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            ('abnormal = ["r1"]', 'abnormal = ["r11"]'),
            r"own.toml, line 10: no residual is called 'r11'; did you mean",
        ),
        (('fault = "gyro"', 'fault = "giro"'), r"'giro' is nothing that can fail; did you mean 'gyro'"),
        (('normal = ["r4"]', 'normal = ["r3"]'), r"'gyro' wants 'r3' abnormal and normal; no residual is both"),
        (('fault = "right"', 'fault = "left"'), r"'left' has two rules; join them"),
        (('abnormal = ["r2"]', 'abnormal = ["r2", "r2"]'), r"names 'r2' twice"),
        (('larger = [["r1", "r2"]]', 'larger = [["r1"]]'), r"expected pairs of two"),
        (('abnormal = ["r1"]', 'abnormal = "r1"'), r"expected a list of names"),
        (("weights = { r3 = 3.0 }", "weights = { r3 = 0 }"), r"weight of 'r3' is 0"),
        (
            ('fault_free = ["left", "right"]', 'fault_free = ["angle"]'),
            r"requires 'angle' to be fault-free, but its rule does not come before",
        ),
        (('positive = ["r3"]\nabnormal = ["r4"]', 'normal = ["r3"]'), r"holds while all is well"),
        (('abnormal = ["r4"]', 'abnromal = ["r4"]'), r"'abnromal' is not known here; did you mean 'abnormal'"),
        (('source = "nowhere"', ""), r"'source' is missing"),
        (('confirm_time = "20 ms"', 'confirm_time = "20 mm"'), r"confirm_time"),
        (('name = "two wheels"', 'name = "two wheels'), r"not valid TOML"),
    ],
)
def test_a_slip_in_a_rule_file_is_reported_with_its_line(change, words):
    with pytest.raises(ParameterError, match=words):
        read(TEXT.replace(*change))


def test_a_file_without_rules_is_refused():
    with pytest.raises(ParameterError, match="there is no rule"):
        read(HEAD)
