"""Trouble codes, and the debouncing of their test results."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

from tierod.core.block import Scalar, Tree, named_tuple
from tierod.core.errors import ParameterError, nearest
from tierod.core.findings import Status
from tierod.core.graph.maths import any_of, both, maximum, minimum, present, where
from tierod.core.toml import Document, build

LOWEST, HIGHEST = -128.0, 127.0


@dataclass(frozen=True)
class DebounceCounter:
    """Counter that rises with every failed and falls with every passed result, limited to -128 to 127.

    The verdict is failed from 127 on and passed from -128 on; in between the last verdict remains. Without a result the
    counter keeps its value.

    Source: counter-based debouncing of AUTOSAR's Diagnostic Event Manager; ISO 14229-1:2020, annex D.
    """

    increment: Annotated[float, ""] = 1.0  # steps per failed result; 127 for a monitor with a stopping rule of its own
    decrement: Annotated[float, ""] = 1.0  # steps per passed result
    jump: bool = True  # whether the counter first goes to zero when the direction changes

    class Sample(NamedTuple):
        result: Annotated[float, ""]

    class State(NamedTuple):
        counter: Scalar
        verdict: Scalar

    class Output(NamedTuple):
        counter: Annotated[float, ""]
        verdict: Annotated[float, ""]

    def __post_init__(self) -> None:
        for name in ("increment", "decrement"):
            value = getattr(self, name)
            if not 0.0 < value <= 255.0:
                raise ParameterError(f"{name} is {value}; expected more than 0 and at most 255 steps per result")

    def init(self) -> State:
        return self.State(0.0, 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        result = where(present(sample.result), sample.result, 0.0)
        counter, verdict = state
        up, down = (maximum(counter, 0.0), minimum(counter, 0.0)) if self.jump else (counter, counter)
        risen, fallen = minimum(up + self.increment, HIGHEST), maximum(down - self.decrement, LOWEST)
        counter = where(result > 0.5, risen, where(result < -0.5, fallen, counter))
        verdict = where(counter >= HIGHEST, 1.0, where(counter <= LOWEST, -1.0, verdict))
        after = self.State(counter, verdict)
        return after, self.Output(counter, verdict)


@dataclass(frozen=True)
class DebounceCounters:
    """One debounce counter per code; the counter of a consequence is frozen while one of its causes has failed.

    A consequence that has failed before loses its verdict then: if it is still present when its causes have passed, it
    fails again.
    """

    counters: tuple[DebounceCounter, ...]
    causes: tuple[tuple[int, ...], ...]  # positions of the codes that cause each code

    def __post_init__(self) -> None:
        known = range(len(self.counters))
        if len(self.causes) != len(self.counters) or any(k not in known for causes in self.causes for k in causes):
            raise ParameterError(f"causes must give places from 0 to {len(self.counters) - 1} for each counter")

    @property
    def Sample(self) -> type:
        return _numbered("result", len(self.counters))

    @property
    def Output(self) -> type:
        return _numbered("verdict", len(self.counters))

    def init(self) -> tuple[DebounceCounter.State, ...]:
        return tuple(counter.init() for counter in self.counters)

    def step(
        self, state: tuple[DebounceCounter.State, ...], sample: Tree
    ) -> tuple[tuple[DebounceCounter.State, ...], Tree]:
        after, verdicts = [], []
        # Causes are judged by their verdicts before this result, so that the order of the codes does not matter.
        for counter, own, causes, result in zip(self.counters, state, self.causes, sample, strict=True):
            if causes:
                caused = any_of(*[state[k].verdict > 0.5 for k in causes])
                result, again = where(caused, 0.0, result), both(caused, own.verdict > 0.5)
                own = DebounceCounter.State(where(again, 0.0, own.counter), where(again, 0.0, own.verdict))
            counted, output = counter.step(own, DebounceCounter.Sample(result))
            after.append(counted)
            verdicts.append(output.verdict)
        return tuple(after), self.Output(*verdicts)


@lru_cache(maxsize=64)
def _numbered(name: str, count: int) -> type:
    return named_tuple(name.capitalize(), [(f"{name}_{k}", Annotated[float, ""]) for k in range(count)])


SHIPPED = Path(__file__).with_name("trouble-codes.toml")  # Table of trouble codes shipped with tierod
REACTIONS = ("none", "degrade", "substitute", "off")  # Reactions of the vehicle to a fault, the weakest first
_CODE = re.compile(r"([PCBU])([0-3])([0-9A-F]{3})-([0-9A-F]{2})")


@dataclass(frozen=True)
class TroubleCode:
    """One trouble code. Source: two bytes of code, ISO 15031-6; third byte, failure type of SAE J2012-DA."""

    code: str  # letter of the system, four digits, and failure type, as in "C1A01-92"
    meaning: str
    monitor: str  # name of the monitor that provides its results
    # statuses of the monitor that count as failed and as passed result; any other is no result
    failed_by: tuple[str, ...] = ("fault",)
    passed_by: tuple[str, ...] = ("healthy",)
    # parameters of the debounce counter, see `DebounceCounter`
    increment: int = 127
    decrement: int = 128
    jump: bool = True
    priority: int = 128  # 1 is kept longest when the memory is full, 255 shortest
    severity: int = 2  # 1 fatal, 2 error, 3 warning, 4 information
    confirmation_cycles: int = 1
    healing_cycles: int = 3  # passed cycles until the lamp request is withdrawn
    aging_cycles: int = 40  # passed cycles after healing until the code is deleted
    lamp: bool = False
    reaction: Literal["none", "degrade", "substitute", "off"] = "none"
    # names of codes that cause this one; it is not raised while a cause has failed, or if a cause fails shortly
    # afterwards
    consequence_of: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not _CODE.fullmatch(self.code):
            raise ParameterError(f"code is '{self.code}'; expected a letter of PCBU, four digits and a type: C1A01-92")
        for name, low, high in (
            ("priority", 1, 255),
            ("severity", 1, 4),
            ("confirmation_cycles", 1, 255),
            ("healing_cycles", 1, 255),
            ("aging_cycles", 1, 255),
        ):
            if not low <= getattr(self, name) <= high:
                raise ParameterError(f"{name} is {getattr(self, name)}; expected {low} to {high}")
        for name in ("failed_by", "passed_by"):
            for status in getattr(self, name):
                if status not in set(Status):
                    raise ParameterError(f"{name} names the status '{status}'{nearest(status, list(Status))}")
        if both := set(self.failed_by) & set(self.passed_by):
            raise ParameterError(f"'{min(both)}' is in both failed_by and passed_by; it may be in one of them only")
        _ = self.debounce

    @property
    def debounce(self) -> DebounceCounter:
        return DebounceCounter(float(self.increment), float(self.decrement), self.jump)

    @property
    def number(self) -> int:
        found = _CODE.fullmatch(self.code)
        assert found
        letter, first, digits, kind = found.groups()
        # Two bits each for the letter and the first digit, then three hexadecimal digits and the failure type.
        return ("PCBU".index(letter) << 22) | (int(first) << 20) | (int(digits, 16) << 8) | int(kind, 16)


@dataclass(frozen=True)
class TroubleCodes:
    codes: Mapping[str, TroubleCode]  # by name, in the order of the table
    identifiers: Mapping[str, int]  # data identifier of each signal in a freeze frame, 0 to 65535, by canonical name

    def __post_init__(self) -> None:
        for name, code in self.codes.items():
            for cause in code.consequence_of:
                if cause not in self.codes:
                    raise ParameterError(f"'{name}' is a consequence of '{cause}'{nearest(cause, self.codes)}")
            if name in self.causes(name):
                raise ParameterError(f"'{name}' is a consequence of itself; remove the loop")
        displayed: list[object] = [code.code for code in self.codes.values()]
        numbers: list[object] = list(self.identifiers.values())
        for what, given in (("code", displayed), ("identifier", numbers)):
            if twice := [each for each in given if given.count(each) > 1]:
                raise ParameterError(f"the {what} {twice[0]} occurs twice in the table; give each once")

    @property
    def numbers(self) -> dict[str, int]:
        return {name: code.number for name, code in self.codes.items()}

    def of_monitor(self, monitor: str) -> dict[str, TroubleCode]:
        """Codes whose results a monitor provides, by name."""
        return {name: code for name, code in self.codes.items() if code.monitor == monitor}

    def named(self, name_or_code: str) -> str:
        wanted = name_or_code.upper()
        found = [name for name, code in self.codes.items() if name == name_or_code or code.code == wanted]
        if not found:
            known = [*self.codes, *(code.code for code in self.codes.values())]
            raise ParameterError(f"there is no trouble code '{name_or_code}'{nearest(name_or_code, known)}")
        return found[0]

    def causes(self, name: str) -> set[str]:
        """All codes that cause a code, directly or indirectly."""
        found: set[str] = set()
        waiting = list(self.codes[name].consequence_of)
        while waiting:
            cause = waiting.pop()
            if cause not in found and cause in self.codes:
                found.add(cause)
                waiting += self.codes[cause].consequence_of
        return found


@lru_cache(maxsize=8)
def load_trouble_codes(path: str | Path = SHIPPED) -> TroubleCodes:
    """Load a TOML file with a table [codes.NAME] per code, and [freeze_frame] with the identifier of each signal."""
    document = Document.read(path, "trouble code")
    if strange := set(document.content) - {"codes", "freeze_frame"}:
        name = min(strange)
        raise document.error((name,), f"'{name}' is not part of a table of trouble codes; known: codes, freeze_frame.")
    codes = {
        name: build(TroubleCode, table, document, ("codes", name))
        for name, table in document.content.get("codes", {}).items()
    }
    identifiers = {
        name: _identifier(number, name, document) for name, number in document.content.get("freeze_frame", {}).items()
    }
    return TroubleCodes(codes, identifiers)


def _identifier(number: object, name: str, document: Document) -> int:
    from tierod.core.signals import SIGNALS

    if name not in SIGNALS:
        raise document.error(("freeze_frame", name), f"there is no signal '{name}'{nearest(name, SIGNALS)}")
    if not (isinstance(number, int) and not isinstance(number, bool) and 0 <= number <= 0xFFFF):
        raise document.error(("freeze_frame", name), f"'{name}' is {number}; expected a number from 0 to 65535")
    return number
