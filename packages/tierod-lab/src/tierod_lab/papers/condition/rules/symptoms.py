"""Symptoms of faults: the tables of the paper, and the files that hold them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any

from tierod.core.errors import nearest
from tierod.core.fields import NOT_NEGATIVE
from tierod.core.toml import build
from tierod.core.toml_document import Document
from tierod.monitors.condition.signals import ACTUATORS, OF_AUTOMATED
from tierod_lab.papers.condition.rules.parameters import RESIDUALS


@dataclass(frozen=True)
class Timing:
    """Times of symptoms and rules."""

    # time for which a rule must hold without a break before its fault is declared
    confirm_time: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    # time for which a residual stays abnormal after it was beyond its threshold
    hold_on: Annotated[float, "s", NOT_NEGATIVE] = 0.1
    # time after the rule of a fault last held from which other rules take the fault as absent
    fault_free_after: Annotated[float, "s", NOT_NEGATIVE] = 0.0


@dataclass(frozen=True)
class SymptomRule:
    """Symptoms of one fault in the residuals."""

    fault: str  # name of the element that is faulty
    abnormal: tuple[str, ...] = ()  # abnormal, normal: residuals beyond and within their thresholds
    normal: tuple[str, ...] = ()
    positive: tuple[str, ...] = ()  # positive, negative: residuals that are abnormal with this sign
    negative: tuple[str, ...] = ()
    # pairs of residuals, the first of which has the larger magnitude over its threshold
    larger: tuple[tuple[str, str], ...] = ()
    fault_free: tuple[str, ...] = ()  # other faults of the table whose rules must not hold
    weights: tuple[tuple[str, float], ...] = ()  # weights of residuals in the score, where they differ from 1

    @property
    def residuals(self) -> tuple[str, ...]:
        """Every residual that the rule names, once."""
        named = [*self.abnormal, *self.normal, *self.positive, *self.negative]
        return tuple(dict.fromkeys([*named, *(each for pair in self.larger for each in pair)]))

    @property
    def raised(self) -> frozenset[str]:
        """Residuals that must be abnormal, of either sign."""
        return frozenset((*self.abnormal, *self.positive, *self.negative))

    def implies(self, other: SymptomRule) -> bool:
        """Whether the other rule holds wherever this one does."""
        signed = set(self.positive) >= set(other.positive) and set(self.negative) >= set(other.negative)
        inside = set(self.normal) >= set(other.normal) and self.raised >= other.raised
        return (
            signed
            and inside
            and set(self.larger) >= set(other.larger)
            and set(self.fault_free) >= set(other.fault_free)
        )


@dataclass(frozen=True)
class SymptomTable:
    """Rules that are evaluated side by side."""

    name: str  # short name
    description: str  # description in one sentence
    source: str  # origin of the rules
    rules: tuple[SymptomRule, ...]  # one rule for each fault
    timing: Timing  # times of symptoms and rules
    # whether one fault at a time is assumed; rules that hold together then give candidates, no fault
    one_fault: bool = True

    @property
    def residuals(self) -> tuple[str, ...]:
        """Every residual that any rule names, in order of appearance."""
        return tuple(dict.fromkeys(each for rule in self.rules for each in rule.residuals))

    @property
    def faults(self) -> tuple[str, ...]:
        """Every fault that has a rule."""
        return tuple(rule.fault for rule in self.rules)

    def not_isolable(self) -> tuple[tuple[str, str], ...]:
        """Pairs of faults that symptoms cannot isolate: the rule of one holds wherever that of the other does."""
        return tuple((a.fault, b.fault) for a, b in combinations(self.rules, 2) if a.implies(b) or b.implies(a))


_LISTS = ("abnormal", "normal", "positive", "negative")
_KEYS = ("fault", *_LISTS, "larger", "fault_free", "weights")
_TIMES = ("confirm_time", "hold_on", "fault_free_after")
_TABLE_KEYS = ("name", "description", "source", *_TIMES, "one_fault", "rule")


def read_table(path: str | Path, residuals: Collection[str], faults: Collection[str]) -> SymptomTable:
    """Reads the symptom table of a file.

    Args:
        residuals: names of the residuals that rules may use
        faults: names of the elements that may be faulty

    Raises:
        ParameterError: the file cannot be read, or a rule names an unknown residual or fault, contradicts itself,
            occurs twice, or requires no abnormal residual; the message names the line and the correction
    """
    return table_of(Document.read(path, "rule"), residuals, faults)


def table_of(document: Document, residuals: Collection[str], faults: Collection[str]) -> SymptomTable:
    """The symptom table of a document; arguments and errors as in `read_table`."""
    content = document.content
    _require_known(content, _TABLE_KEYS, document, ())
    name, description, source = (_text(content, key, document) for key in ("name", "description", "source"))
    given = content.get("rule")
    if not isinstance(given, list) or not given:
        raise document.error(("rule",), "there is no rule; write at least one table [[rule]]")
    rules = tuple(_rule(each, number, document, residuals, faults) for number, each in enumerate(given))
    names = [rule.fault for rule in rules]
    for number, name in enumerate(names):
        if name in names[:number]:
            raise document.error(("rule", number, "fault"), f"'{name}' has two rules; join them into one")
    _require_order(rules, document)
    timing = build(Timing, {key: content[key] for key in _TIMES if key in content}, document)
    one_fault = content.get("one_fault", True)
    if not isinstance(one_fault, bool):
        raise document.error(("one_fault",), f"'one_fault' is {one_fault!r}; expected true or false")
    return SymptomTable(name, description, source, rules, timing, one_fault)


def _rule(table: Any, number: int, document: Document, residuals: Collection[str], faults: Collection[str]) -> Any:
    at = ("rule", number)
    _require_known(table, _KEYS, document, at)
    fault = table.get("fault")
    if not isinstance(fault, str) or fault not in faults:
        raise document.error((*at, "fault"), f"{fault!r} is nothing that can fail{nearest(str(fault), faults)}")
    lists = {key: _names(table, key, residuals, "residual", document, at) for key in _LISTS}
    pairs = _pairs(table, residuals, document, at)
    fault_free = _names(table, "fault_free", faults, "fault", document, at)
    weights = table.get("weights", {})
    _names({"weights": list(weights)}, "weights", residuals, "residual", document, at)
    for name, weight in weights.items():
        if not isinstance(weight, int | float) or not weight > 0.0:
            raise document.error((*at, "weights"), f"the weight of '{name}' is {weight!r}; expected one above zero")
    rule = SymptomRule(
        fault, **lists, larger=pairs, fault_free=fault_free, weights=tuple((k, float(v)) for k, v in weights.items())
    )
    _require_consistent(rule, document, at)
    return rule


def _pairs(
    table: dict[str, Any], residuals: Collection[str], document: Document, at: tuple[str | int, ...]
) -> tuple[tuple[str, str], ...]:
    given = table.get("larger", [])
    found = []
    for pair in given if isinstance(given, list) else [given]:
        names = _names({"larger": pair}, "larger", residuals, "residual", document, at)
        if len(names) != 2:
            raise document.error((*at, "larger"), f"'larger' has {pair!r}; expected pairs of two residuals")
        found.append((names[0], names[1]))
    return tuple(found)


def _require_consistent(rule: SymptomRule, document: Document, at: tuple[str | int, ...]) -> None:
    seen: dict[str, str] = {}
    for key in _LISTS:
        for name in getattr(rule, key):
            if name in seen:
                said = f"'{rule.fault}' wants '{name}' {seen[name]} and {key}"
                raise document.error((*at, key), f"{said}; no residual is both, keep one")
            seen[name] = key
    if not rule.raised and not rule.larger:
        raise document.error(at, f"the rule of '{rule.fault}' holds while all is well; name an abnormal residual")
    for name in (each for pair in rule.larger for each in pair if (pair[1], pair[0]) in rule.larger):
        raise document.error((*at, "larger"), f"'{rule.fault}' wants '{name}' larger and smaller than the same one")


def _require_order(rules: tuple[SymptomRule, ...], document: Document) -> None:
    """Requires that rules come after those on which they depend, so that one pass evaluates all."""
    before: set[str] = set()
    for number, rule in enumerate(rules):
        for name in rule.fault_free:
            if name not in before:
                raise document.error(
                    ("rule", number, "fault_free"),
                    f"'{rule.fault}' requires '{name}' to be fault-free, but its rule does not come before; move it up",
                )
        before.add(rule.fault)


def _names(
    table: dict[str, Any], key: str, known: Collection[str], what: str, document: Document, at: tuple[str | int, ...]
) -> tuple[str, ...]:
    given = table.get(key, [])
    if not isinstance(given, list):
        raise document.error((*at, key), f"'{key}' is {given!r}; expected a list of names")
    for name in given:
        if name not in known:
            raise document.error((*at, key), f"no {what} is called {name!r}{nearest(str(name), known)}")
    for name in given:
        if given.count(name) > 1:
            raise document.error((*at, key), f"'{key}' names '{name}' twice; name it once")
    return tuple(given)


def _require_known(table: Any, keys: tuple[str, ...], document: Document, at: tuple[str | int, ...]) -> None:
    if not isinstance(table, dict):
        raise document.error(at, f"{table!r} is no table; write [[rule]] above it")
    for key in table:
        if key not in keys:
            raise document.error((*at, key), f"'{key}' is not known here{nearest(key, keys)}")


def _text(content: dict[str, Any], key: str, document: Document) -> str:
    value = content.get(key)
    if not isinstance(value, str) or not value:
        raise document.error((key,), f"'{key}' is missing; say it in a sentence")
    return value


FILES = {"rules-printed": "printed", "rules": "corrected", "rules-discriminating": "discriminating"}
"""Variant of the monitor -> name of its rule file."""


@lru_cache(maxsize=16)
def rules(variant_or_path: str) -> SymptomTable:
    """The rules of a variant, or of a user's file.

    Args:
        variant_or_path: "rules", "rules-printed", "rules-discriminating", or the path of a rule file (.toml)

    Raises:
        ParameterError: the file cannot be read or contains an error
    """
    name = FILES.get(variant_or_path)
    path = Path(__file__).with_name(f"{name}.toml") if name else Path(variant_or_path)
    return read_table(path, tuple(RESIDUALS), (*OF_AUTOMATED, *ACTUATORS))
