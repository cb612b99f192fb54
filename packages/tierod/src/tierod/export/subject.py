"""Subject of an export: a monitor as a block for one vehicle, with unit, meaning and range of every number."""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
import re
import textwrap
from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from math import prod
from typing import Any, NamedTuple

from tierod.core.block import Ring, tuning, values_of
from tierod.core.errors import ParameterError
from tierod.core.fields import Meaning, below, hints
from tierod.core.graph import trace
from tierod.core.graph.trace import BankState
from tierod.core.signals import SIGNALS
from tierod.core.version import __version__
from tierod.monitors.diagnose import usual_monitor
from tierod.monitors.registry import MONITORS
from tierod.monitors.runner import find
from tierod.monitors.session import opened
from tierod.vehicles import Vehicle, load

_ENTRY = re.compile(r"^    (\w+(?:, \w+)*): (.*)$")


class Described(NamedTuple):
    """Description of a number."""

    path: str
    unit: str = ""  # in the notation of pint; "" for none
    meaning: str = ""  # description in words; "" if unknown
    limits: str = ""  # range in words; "" for any value
    holder: str = ""


def described(tree: Any, path: str = "") -> Iterator[Described]:
    """Descriptions of every leaf of a tree of NamedTuples, dataclasses and tuples, in order."""
    yield from _below(tree, Described(path), Meaning(type(tree), None, None))


def of_signals(names: tuple[str, ...], tree: Any) -> tuple[Described, ...]:
    """Descriptions of a monitor's inputs: canonical signals from the catalogue, others from their annotations."""
    own = {each.path: each for each in described(tree)}
    return tuple(_signal(name) or own.get(name, Described(name)) for name in names)


def _signal(name: str) -> Described | None:
    found = SIGNALS.get(name)
    if found is None:
        return None
    low, high = found.plausible
    limits = "" if low == -high == -float("inf") else f"{low:g} to {high:g}"
    positive = f"; positive: {found.positive}" if found.positive else ""
    return Described(name, found.unit, found.meaning.rstrip(".") + positive, limits)


def _below(tree: Any, own: Described, means: Meaning) -> Iterator[Described]:
    if isinstance(tree, Ring):
        yield own
        return
    names = _fields(tree)
    if names is None:
        unit = own.unit if means.unit is None else means.unit
        yield own._replace(unit=unit, limits=str(means.limits) if means.limits else own.limits)
        return
    kind: Any = type(tree)
    texts, known = meanings(kind), hints(kind) if names and not names[0].isdigit() else {}
    for place, name in enumerate(names):
        part = tree[place] if names[0].isdigit() else getattr(tree, name)
        path = f"{own.path}.{name}" if own.path else name
        inner = below(known[name], means) if name in known else Meaning(type(part), means.unit, means.limits)
        text = texts.get(name, own.meaning if name.isdigit() else "")
        yield from _below(part, Described(path, own.unit, text, own.limits, kind.__name__), inner)


def _fields(tree: Any) -> list[str] | None:
    """Names of the parts of a tree; None for a leaf."""
    if isinstance(tree, tuple):
        return list(getattr(tree, "_fields", None) or map(str, range(len(tree))))
    if dataclasses.is_dataclass(tree) and not isinstance(tree, type):
        return [each.name for each in dataclasses.fields(tree)]
    return None


_FIELD = re.compile(r"    (\w+): [^#]*?(?:# (.*))?$")
_DIRECTIVE = re.compile(r"type:|noqa|fmt:")


@cache
def meanings(kind: Hashable) -> dict[str, str]:
    """Descriptions of the fields of a class: "Args:" in its docstring, or comments beside or above the fields."""
    _, found, rest = inspect.cleandoc(kind.__doc__ or "").partition("Args:\n")
    texts: dict[str, str] = {}
    names: list[str] = []
    for line in rest.splitlines() if found else ():
        if line and not line.startswith(" "):
            break
        if entry := _ENTRY.match(line):
            names = entry[1].split(", ")
            texts |= dict.fromkeys(names, entry[2])
        elif line.strip() and names:
            texts |= {name: f"{texts[name]} {line.strip()}" for name in names}
    return _comments(kind) | texts


def _comments(kind: Hashable) -> dict[str, str]:
    try:
        lines = textwrap.dedent(inspect.getsource(kind)).splitlines()  # type: ignore[arg-type]
    except (OSError, TypeError):
        return {}
    texts: dict[str, str] = {}
    above = ""
    for line in lines:
        if field := _FIELD.match(line):
            text = above if _DIRECTIVE.match(field[2] or "type:") else field[2]
            several = _ENTRY.match(f"    {text}")
            if several and field[1] in several[1].split(", "):
                texts |= dict.fromkeys(several[1].split(", "), several[2])
            elif text:
                texts[field[1]] = text
        comment = re.match(r"    # (.*)", line)
        above = f"{above} {comment[1]}".strip() if comment else ""
    return texts


_WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while bool true false
"""
KEYWORDS = frozenset(_WORDS.split())


class Member(NamedTuple):
    name: str
    shape: tuple[int, ...]  # of the array; () for a single number
    places: tuple[int, ...]  # positions of its numbers in the flat order, row by row

    @property
    def declarator(self) -> str:
        """C declarator: name and dimensions."""
        return self.name + "".join(f"[{size}]" for size in self.shape)

    @property
    def elements(self) -> tuple[str, ...]:
        """C code of every number, in the order of `places`."""
        found = [self.name]
        for size in self.shape:
            found = [f"{each}[{k}]" for each in found for k in range(size)]
        return tuple(found)


def identifier(text: str) -> str:
    """A valid C identifier for any text."""
    name = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower() or "value"
    return f"{name}_" if name in KEYWORDS else f"n{name}" if name[0].isdigit() else name


def members(paths: Sequence[str]) -> tuple[Member, ...]:
    """Members of a struct for dotted paths; numbers in a path become array indices where the array is complete."""
    groups: dict[str, list[tuple[tuple[int, ...], int]]] = {}
    for place, path in enumerate(paths):
        stem, indices = _parted(path)
        groups.setdefault(stem, []).append((indices, place))
    found: list[Member] = []
    for stem, entries in groups.items():
        shape = _shape([indices for indices, _ in entries])
        if shape is not None:
            found.append(Member(identifier(stem), shape, tuple(place for _, place in entries)))
        else:
            found += [Member(identifier(paths[place]), (), (place,)) for _, place in entries]
    return tuple(_distinct(found))


def elements(found: Sequence[Member]) -> tuple[str, ...]:
    """C code of every number, in the flat order."""
    named = {place: text for each in found for place, text in zip(each.places, each.elements, strict=True)}
    return tuple(named[place] for place in range(len(named)))


def _parted(path: str) -> tuple[str, tuple[int, ...]]:
    """Path without its numbers, and these numbers; a path begins with a name."""
    first, *parts = path.split(".")
    return ".".join([first, *(part for part in parts if not part.isdigit())]), tuple(
        int(part) for part in parts if part.isdigit()
    )


def _shape(indices: Sequence[tuple[int, ...]]) -> tuple[int, ...] | None:
    """Shape of the array that holds exactly these indices in this order; None where there is no such array.

    Rows of unequal length are joined into a one-dimensional array.
    """
    if len({len(each) for each in indices}) != 1 or list(indices) != sorted(set(indices)):
        return None
    shape = tuple(1 + max(column) for column in zip(*indices, strict=True))
    if prod(shape) == len(indices):
        return shape
    rows = Counter(each[:-1] for each in indices)
    whole = all(max(each[-1] for each in indices if each[:-1] == row) + 1 == count for row, count in rows.items())
    return (len(indices),) if whole and len(rows) > 1 else None


def _distinct(found: Sequence[Member]) -> list[Member]:
    """Members with distinct names; repeated names get a number."""
    taken: set[str] = set()
    distinct = []
    for each in found:
        name, number = each.name, 1
        while name in taken:
            number += 1
            name = f"{each.name}_{number}"
        taken.add(name)
        distinct.append(each._replace(name=name))
    return distinct


@dataclass(frozen=True)
class Subject:
    name: str  # C identifier with which all names begin, without "tierod_"
    title: str
    monitor: str
    variant: str
    vehicle: str  # name of the vehicle whose parameters are used
    rate: float  # sampling rate [Hz]
    block: Any
    graph: Any
    # sample, state, output, tuning: descriptions of all numbers, in the order of the graph; for a bank the states of
    # its judge
    sample: tuple[Described, ...]
    state: tuple[Described, ...]
    output: tuple[Described, ...]
    tuning: tuple[Described, ...]
    values: tuple[float, ...]

    @property
    def sample_time(self) -> float:
        """Sampling interval [s]."""
        return 1.0 / self.rate

    @property
    def version(self) -> str:
        return f"tierod {__version__}, {self.monitor}, {self.variant}"

    @property
    def digest(self) -> int:
        """32-bit hash of version, names and values of all parameters."""
        text = "\n".join(f"{each.path} {value!r}" for each, value in zip(self.tuning, self.values, strict=True))
        return int.from_bytes(hashlib.sha256(f"{self.version}\n{text}".encode()).digest()[:4], "big")


def subject_of(monitor: str | None, vehicle: Vehicle | str, variant: str | None = None) -> Subject:
    """The monitor of a vehicle, ready for export.

    Args:
        monitor: name; None for the usual one of the vehicle
        variant: name; None for the monitor's default
    """
    car = vehicle if isinstance(vehicle, Vehicle) else load(vehicle)
    listed = MONITORS.required(monitor or usual_monitor(car))
    definition, chosen = find(listed.name, variant or listed.default or next(iter(listed.variants)))
    block = getattr(opened(definition, chosen, car), "block", None)
    if block is None:
        raise ParameterError(
            f"the monitor '{definition.name}', variant '{chosen.name}', judges a recording as a whole and cannot "
            "step from sample to sample; export one that can, for example friction"
        )
    if variant is None:
        # A monitor without a default variant requires a choice, but only a monitor that can be exported.
        find(listed.name)
    stem = definition.name if chosen.name == definition.default else f"{definition.name}_{chosen.name}"
    names = (definition.title, definition.name, chosen.name, car.name)
    return subject_of_block(identifier(stem), block, definition.rate, *names)


def subject_of_block(
    name: str, block: Any, rate: float, title: str = "", monitor: str = "", variant: str = "", vehicle: str = ""
) -> Subject:
    """A block, ready for export.

    Args:
        rate: sampling rate [Hz]
        monitor, variant, vehicle: names; "" where there is none
    """
    graph, initial = trace(block), block.init()
    remembered = initial.judge if isinstance(initial, BankState) else initial
    leaves = zip(described(remembered), values_of(remembered), strict=True)
    pairs = list(tuning(block))
    known = {each.path: each for each in described(block)}
    return Subject(
        name=name,
        title=title or name,
        monitor=monitor,
        variant=variant,
        vehicle=vehicle,
        rate=rate,
        block=block,
        graph=graph,
        sample=of_signals(graph.sample, graph.sample_tree),
        state=tuple(each for each, leaf in leaves if not isinstance(leaf, Ring)),
        output=tuple(described(graph.output_tree)),
        tuning=tuple(known.get(path, Described(path)) for path, _ in pairs),
        values=tuple(value for _, value in pairs),
    )
