import pytest

from tierod.vehicles.lines import line_of

TEXT = """\
# a comment = 1
name = "x"

[parameters]
mass = { value = 3.0, unit = "kg" }
trail.value = 0.05

[parameters."front distance"] # with a comment
value = 1.0
"""


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("name",), 2),
        (("parameters", "mass", "value"), 5),
        (("parameters", "trail", "value"), 6),
        (("parameters", "front distance", "value"), 9),
        (("parameters", "front distance", "unit"), 8),
        (("parameters", "absent"), 4),
        (("absent",), None),
    ],
)
def test_finds_the_line_of_a_key_or_of_its_table(path, line):
    assert line_of(TEXT, path) == line
