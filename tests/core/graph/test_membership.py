"""Chains of comparisons of one number with whole numbers become one operation, whatever the number is."""

import math

from tierod.core.graph.membership import MEMBER, with_members
from tierod.core.graph.operations import OUTPUT, SAMPLE, Builder, Program


def program(build):
    builder = Builder()
    value = build(builder, builder.add("input", constant=(SAMPLE, 0)))
    return Program(tuple(builder.operations), {(OUTPUT, 0): value}, frozenset())


def joined(builder, first, *others):
    for other in others:
        first = builder.add("or", (first, other))
    return first


def compared(builder, number, *wholes):
    return [builder.add("eq", (number, builder.add("constant", (), float(each)))) for each in wholes]


def test_a_chain_becomes_one_operation_with_its_members_in_order():
    found = with_members(program(lambda b, n: joined(b, b.add("constant", (), 0.0), *compared(b, n, 7, 2, 63))))
    assert [(each.name, each.constant) for each in found.operations] == [("input", (SAMPLE, 0)), (MEMBER, (2, 7, 63))]


def test_other_comparisons_stay_as_they_are():
    for wholes in ((0.5, 1.0), (-1.0, 2.0), (64.0, 2.0), (math.inf, 1.0)):
        given = program(lambda b, n, wholes=wholes: joined(b, *compared(b, n, *wholes)))
        assert MEMBER not in {each.name for each in with_members(given).operations}


def test_two_numbers_make_no_set():
    def build(builder, number):
        other = builder.add("input", constant=(SAMPLE, 1))
        return joined(builder, *compared(builder, number, 1), *compared(builder, other, 2))

    assert [each.name for each in with_members(program(build)).operations].count("or") == 1
