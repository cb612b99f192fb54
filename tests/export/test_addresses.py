"""What the turns of a loop take, by one text with the number of the turn."""

import pytest

from tierod.export.addresses import Tables, columns_of


@pytest.fixture
def tables():
    return Tables(lambda kind, name, values: f"{kind} {name} = {{{', '.join(values)}}};")


@pytest.mark.parametrize(
    ("texts", "found"),
    [
        (["w[0]", "w[1]", "w[2]"], "w[i]"),
        (["w[7]", "w[8]", "w[9]"], "w[7U + i]"),
        (["w[7]", "w[9]", "w[11]"], "w[7U + (2U * i)]"),
        (["w[9]", "w[8]", "w[7]"], "w[9U - i]"),
        (["x->a[3]", "x->a[3]", "x->a[3]"], "x->a[3]"),
        (["x->a[2][(x->h + 4U) % 9U]", "x->a[2][(x->h + 6U) % 9U]"], "x->a[2][(x->h + 4U + (2U * i)) % 9U]"),
    ],
)
def test_whole_numbers_in_brackets_follow_the_turn(tables, texts, found):
    assert tables.indexed(texts) == found
    assert not tables.text


def test_other_numbers_come_from_a_table_that_stands_once(tables):
    assert tables.indexed(["w[4]", "w[2]", "w[9]"]) == "w[t0[i]]"
    assert tables.indexed(["b[4]", "b[2]", "b[9]"]) == "b[t0[i]]"
    assert tables.text == "uint16_t t0 = {4U, 2U, 9U};"


def test_texts_that_differ_in_names_have_no_common_one():
    assert columns_of(["x->a_0", "x->a_1"]) is None
    assert columns_of(["x->a[1]", "x->b[1]"]) is None
