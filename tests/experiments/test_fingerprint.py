"""Fingerprints: equal for equal content in every process, different for anything that may matter."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from tierod.monitors.condition.definition import condition_monitor
from tierod.vehicles import load
from tierod.work import fingerprint as module
from tierod.work.fingerprint import fingerprint
from tierod_lab.campaign.code import reported_seed
from tierod_lab.papers.condition.datasets import USED, first_vehicle, vehicles
from tierod_lab.studies.effort import Effort


@dataclass(frozen=True)
class Inner:
    gain: float = 1.0
    names: tuple[str, ...] = ("a", "b")


@dataclass(frozen=True)
class Outer:
    inner: Inner
    table: np.ndarray
    more: dict


@dataclass(frozen=True)
class Other(Inner):
    pass


@dataclass(frozen=True)
class Placed:
    value: float
    place: str = field(compare=False)


class Pair(NamedTuple):
    a: float
    b: float


def made(**changes):
    return replace(Outer(Inner(), np.arange(3.0), {"x": 1, "y": Path("/somewhere/a.toml")}), **changes)


def test_equal_content_has_one_fingerprint():
    assert fingerprint(made()) == fingerprint(made(more={"y": Path("/elsewhere/a.toml"), "x": 1}))
    assert fingerprint({"a", "b", "c"}) == fingerprint({"c", "b", "a"})
    assert fingerprint([1, 2]) == fingerprint((1, 2))
    assert fingerprint(Placed(1.0, "here")) == fingerprint(Placed(1.0, "there"))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (made(), made(inner=Inner(gain=1.0000000000000002))),
        (made(), made(table=np.arange(3))),
        (made(), made(more={"x": 1})),
        (Inner(), Other()),
        (1, 1.0),
        ("ab", ("a", "b")),
        (("ab", "c"), ("a", "bc")),
        (Pair(1.0, 2.0), (1.0, 2.0)),
        (0.0, -0.0),
    ],
)
def test_what_differs_differs(one, other):
    assert fingerprint(one) != fingerprint(other)


def test_every_package_that_a_verdict_needs_is_known():
    known = {*module.VERDICT, "cli", "export", "fleet", "live", "report", "web", "work"}
    packages = {path.name for path in module.ROOT.iterdir() if path.is_dir() and list(path.glob("*.py"))}
    assert packages <= known | {"diagnosis"}


@pytest.mark.slow
def test_a_changed_threshold_draws_other_demonstrators():
    bank = condition_monitor(load("smartload"))
    lanes = tuple(replace(lane, bending=lane.bending * 1.01) for lane in bank.lanes)
    assert reported_seed(bank) != reported_seed(replace(bank, lanes=lanes))


def test_reported_demonstrators_are_none_of_those_that_thresholds_were_chosen_on():
    chosen = vehicles(Effort())
    assert chosen[0] == first_vehicle() > USED
    assert chosen == tuple(range(chosen[0], chosen[0] + 3))
    assert vehicles(Effort(quick=True)) == chosen[:1]
