"""Every monitor declares its decisions, and the thresholds in effect are those declared; new ones are found."""

import contextlib
import dataclasses

import pytest

from tierod.core.errors import ParameterError
from tierod.methods.detectors import Cusum, HeldThreshold
from tierod.monitors.registry import MONITORS
from tierod.vehicles import load, shipped

DECIDING = (Cusum, HeldThreshold)
"""Blocks whose only use is to decide."""

VARIANTS = [(monitor, variant) for monitor in MONITORS for variant in MONITORS[monitor].variants]


def opened(monitor, variant):
    found = []
    for name in shipped():
        with contextlib.suppress(ParameterError):
            session = MONITORS[monitor].variants[variant].open(load(name), MONITORS[monitor].rate, None)
            decisions = MONITORS[monitor].variants[variant].decisions
            wanting = sum(each.part_of(session) is None for each in decisions)
            found.append((wanting, len(found), session))
            if not wanting:
                break
    assert found, f"no shipped vehicle serves {monitor}, {variant}"
    return min(found)[-1]


def parts_of(value, path=(), seen=None):
    """(path, part) of all that an object of tierod holds, attribute by attribute."""
    seen = set() if seen is None else seen
    if id(value) in seen:
        return
    seen.add(id(value))
    yield path, value
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        inside = [(field.name, getattr(value, field.name)) for field in dataclasses.fields(value)]
    elif isinstance(value, dict):
        inside = list(value.items())
    elif isinstance(value, list | tuple):
        inside = list(enumerate(value))
    elif type(value).__module__.startswith("tierod.monitors"):
        inside = list(vars(value).items())
    else:
        return
    for name, part in inside:
        yield from parts_of(part, (*path, str(name)), seen)


@pytest.fixture(scope="module")
def sessions():
    return {}


@pytest.fixture(params=VARIANTS, ids=", ".join)
def case(request, sessions):
    monitor, variant = request.param
    if request.param not in sessions:
        sessions[request.param] = opened(monitor, variant)
    return MONITORS[monitor].variants[variant], sessions[request.param]


def test_the_thresholds_in_effect_are_the_declared_ones(case):
    variant, session = case
    assert [each for decision in variant.decisions for each in decision.departures(session)] == []


def test_no_block_decides_without_being_declared(case):
    variant, session = case
    declared = [decision.part_of(session) for decision in variant.decisions if decision.place]
    known = {id(part) for whole in declared for _, part in parts_of(whole)}
    bare = [".".join(path) for path, part in parts_of(session) if isinstance(part, DECIDING) and id(part) not in known]
    assert bare == []
