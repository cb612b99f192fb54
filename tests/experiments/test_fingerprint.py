"""Fingerprints: equal for equal content in every process, different for anything that may matter."""

import subprocess
import sys
from dataclasses import dataclass, field, replace
from enum import Enum
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from tierod.work import fingerprint as module
from tierod.work.fingerprint import fingerprint, verdict_code
from tierod_lab.campaign import code as lab_module
from tierod_lab.campaign.code import ground_code, judging_code


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
class Other:
    gain: float = 1.0
    names: tuple[str, ...] = ("a", "b")


@dataclass(frozen=True)
class Placed:
    value: float
    place: str = field(compare=False)


class Pair(NamedTuple):
    a: float
    b: float


class Kind(Enum):
    ONE = 1


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
        (1, True),
        ("ab", ("a", "b")),
        (("ab", "c"), ("a", "bc")),
        (Pair(1.0, 2.0), (1.0, 2.0)),
        (((1,), 2), ((1, 2),)),
        (0.0, -0.0),
        (Kind.ONE, 1),
        (Inner, Other),
        (None, "None"),
    ],
)
def test_what_differs_differs(one, other):
    assert fingerprint(one) != fingerprint(other)


def test_what_cannot_be_known_is_refused():
    with pytest.raises(TypeError, match="no fingerprint of .*function"):
        fingerprint(Inner(gain=lambda: 1.0))


def test_other_processes_find_the_same():
    code = (
        "from tierod.work.fingerprint import *; from tierod_lab.campaign.code import *; "
        "print(fingerprint({'a', 'b'}), ground_code(), judging_code(), verdict_code())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == [fingerprint({"a", "b"}), ground_code(), judging_code(), verdict_code()]


def test_code_is_known_by_its_text(tmp_path, monkeypatch):
    for package in ("physics", "monitors"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "law.py").write_text("a = 1\n")
    monkeypatch.setattr(module, "ROOT", tmp_path)
    monkeypatch.setattr(lab_module, "PRODUCT", tmp_path)
    codes = ground_code.__wrapped__, verdict_code.__wrapped__
    before = [code() for code in codes]
    (tmp_path / "monitors" / "law.py").write_text("a = 2\n")
    between = [code() for code in codes]
    (tmp_path / "physics" / "law.py").write_text("a = 2\n")
    after = [code() for code in codes]
    assert before[0] == between[0] != after[0]
    assert before[1] != between[1] != after[1]


def test_every_package_that_a_verdict_needs_is_known():
    known = {*module.VERDICT, "cli", "export", "fleet", "live", "report", "web", "work"}
    packages = {path.name for path in module.ROOT.iterdir() if path.is_dir() and list(path.glob("*.py"))}
    assert packages <= known | {"diagnosis"}
