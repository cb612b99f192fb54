import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.toml_document import line_of

TEXT = """\
# a comment = 1
name = "x"

[parameters]
mass = { value = 3.0, unit = "kg" }
trail.value = 0.05

[parameters."front distance"] # with a comment
value = 1.0
"""

MANY = '''\
text = """
[not.a.table]
key = 1
"""
numbers = [
  1.0,  # [comment]
  { low = 2, high = [3,
    4] },
]

[[faults]]
element = "yaw_rate"
[faults.trigger]
at = 1979-05-27 07:32:00

[[faults]]
element = 'a = "b"'
trigger.at = 2.0

[[faults.parts]]
size = 1
[[faults.parts]]
size = 2
'''


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
        ((), None),
    ],
)
def test_finds_the_line_of_a_key_or_of_its_table(path, line):
    assert line_of(TEXT, path) == line


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("text",), 1),
        (("key",), None),
        (("not", "a", "table"), None),
        (("numbers", 0), 6),
        (("numbers", 1, "low"), 7),
        (("numbers", 1, "high", 1), 8),
        (("numbers", 2), 5),
        (("faults", 0), 11),
        (("faults", 0, "element"), 12),
        (("faults", 0, "trigger", "at"), 14),
        (("faults", 0, "trigger", "until"), 13),
        (("faults", 1, "element"), 17),
        (("faults", 1, "trigger", "at"), 18),
        (("faults", 1, "parts", 0, "size"), 21),
        (("faults", 1, "parts", 1, "size"), 23),
        (("faults", 1, "parts.1.size"), 23),
    ],
)
def test_knows_arrays_inline_tables_and_strings_of_several_lines(path, line):
    tomllib.loads(MANY)
    assert line_of(MANY, path) == line


WORDS = st.text("abcdefgh-_19", min_size=1, max_size=4)
QUOTED = st.text(" .#[]={}'abc\\\"\u00e9", max_size=6).map(
    lambda text: '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
)
VALUES = st.recursive(
    st.one_of(st.integers().map(str), st.floats(allow_nan=False).map(repr), QUOTED, st.just("'''a\n[b]\n'''")),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda parts: "[" + ",\n".join(parts) + "]"),
        st.dictionaries(WORDS, inner, max_size=3).map(
            lambda table: "{" + ", ".join(f"{key} = {value}" for key, value in table.items()) + "}"
        ),
    ),
    max_leaves=6,
)


@given(st.dictionaries(st.one_of(WORDS, QUOTED), VALUES, min_size=1, max_size=5))
def test_finds_every_key_of_any_document(table):
    text, lines = "", {}
    for key, value in table.items():
        lines[tomllib.loads(f"key = {key}")["key"] if key[0] == '"' else key] = text.count("\n") + 1
        text += f"{key} = {value}\n"
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return  # the same key written in two ways
    assert {key: line_of(text, (key,)) for key in content} == lines
