import pytest

from diagnosis.memories import code, table
from tierod.core.errors import ParameterError
from tierod.diagnosis.trouble_codes import TroubleCode, load_trouble_codes
from tierod.monitors.registry import MONITORS

WHOLE = """
[codes.a]
code = "C1A01-92"
meaning = "something"
monitor = "friction"

[freeze_frame]
yaw_rate = 0xD001
"""


def test_every_shipped_code_is_fed_by_a_monitor():
    codes = load_trouble_codes()
    assert codes.codes
    for code_ in codes.codes.values():
        assert code_.monitor in MONITORS


@pytest.mark.parametrize(
    ("display", "number"),
    [("P0123-00", 0x012300), ("C1A01-92", 0x5A0192), ("B3FFF-FF", 0xBFFFFF), ("U0100-87", 0xC10087)],
)
def test_the_three_bytes_of_a_code(display, number):
    assert TroubleCode(display, "", "friction").number == number


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (('"C1A01-92"', '"X1A01-92"'), "line 2.*letter of PCBU"),
        (("meaning", "meanign"), "meanign"),
        (('monitor = "friction"', 'monitor = "friction"\nfailed_by = ["broken"]'), "'broken'"),
        (('monitor = "friction"', 'monitor = "friction"\nfailed_by = ["healthy"]'), "one of them only"),
        (('monitor = "friction"', 'monitor = "friction"\nconsequence_of = ["b"]'), "consequence of 'b'"),
        (('monitor = "friction"', 'monitor = "friction"\nconsequence_of = ["a"]'), "remove the loop"),
        (('monitor = "friction"', 'monitor = "friction"\npriority = 0'), "expected 1 to 255"),
        (("yaw_rate", "yaw_rat"), "did you mean 'yaw_rate'"),
        (("0xD001", "70000"), "0 to 65535"),
        (("[freeze_frame]", "[freezer]"), "'freezer'"),
    ],
)
def test_a_slip_in_the_table_is_named(tmp_path, change, says):
    path = tmp_path / "codes.toml"
    path.write_text(WHOLE)
    load_trouble_codes(path)
    spoilt = tmp_path / "spoilt.toml"
    spoilt.write_text(WHOLE.replace(*change))
    with pytest.raises(ParameterError, match=says):
        load_trouble_codes(spoilt)


def test_a_code_stands_once():
    with pytest.raises(ParameterError, match="C1A01-62 occurs twice"):
        table(a=code(1), b=code(1))


def test_causes_of_causes_are_causes():
    codes = table(a=code(1), b=code(2, consequence_of=("a",)), c=code(3, consequence_of=("b",)))
    assert codes.causes("c") == {"a", "b"}
    assert codes.named("c1a02-62") == "b"
