"""Detectability and isolability by structural analysis, compared with the measured isolation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from tierod.core.content import Heading, Item, Table
from tierod.methods.analysis.structure import Isolability, isolability
from tierod.monitors.condition.courses import listed
from tierod.monitors.condition.signals import ELEMENTS
from tierod.monitors.condition.structure import vehicle_structure
from tierod.vehicles import load
from tierod_lab.papers.condition import actuators, beyond, sensors
from tierod_lab.papers.condition.runs import BEST, VARIANTS, scores
from tierod_lab.papers.condition.scoring import AMBIGUOUS, NEVER, UNNAMED, DriveScore
from tierod_lab.papers.condition.summary import confusion
from tierod_lab.studies.effort import Effort

TEXT = (
    "Structural analysis uses only which quantity enters which equation: a fault is detectable where it violates an "
    "equation of a testable set, and isolable from another where such a set lacks that one. It regards neither "
    "magnitudes nor time. Beside it stands what "
    "the diagnoses named most of the time once the faults showed, in all drives of the tests; where the two do not "
    "agree, a reason follows.",
)
FIXED = "with a fixed split"


class Compared(NamedTuple):
    """A fault, or several at once, by structure and by measurement."""

    fault: str  # name, or names joined by " + "
    theory: str  # isolability by structure, as text
    alike: tuple[str, ...]  # faults that are not isolable from it by structure
    named: Mapping[str, Counter[str]]  # diagnosis -> count of every declared name


def items(effort: Effort) -> Iterator[Item]:
    if BEST not in VARIANTS:
        return
    structure = isolability(vehicle_structure(load("smartload")), at_once=2)
    single = list(compared(structure, _single(effort)))
    pairs = list(compared(structure, {BEST: _pairs(effort)}))
    fixed = list(compared(structure, {BEST: scores(actuators.campaign(effort, 0.5, False), effort, (BEST,))[BEST]}))
    yield Heading("Isolability in theory and in the drives", TEXT)
    yield table("Single faults by structure and by measurement", single)
    yield table("Two faults at once by structure and by measurement", pairs)
    yield table(f"Half the torque lost {FIXED}, by structure and by measurement", fixed)
    rows = (*disagreements(single), *disagreements(pairs), *disagreements(fixed, f", half lost {FIXED}"))
    header = ("fault", "by structure", "diagnosis", "measured", "why")
    note = "The two agree on a fault that is structurally isolable and was named rightly wherever it was observable."
    yield Table("Where structure and measurement disagree", header, rows or (("none", "", "", "", ""),), note)


def _single(effort: Effort) -> dict[str, list[DriveScore]]:
    parts = [
        scores(sensors.campaign(effort), effort),
        scores(actuators.campaign(effort), effort),
        scores(actuators.campaign(effort, 0.5), effort),
    ]
    return {name: [each for part in parts for each in part[name]] for name in VARIANTS}


def _pairs(effort: Effort) -> list[DriveScore]:
    supplies = [actuators.supply_campaign(effort, share) for share in (1.0, 0.5)]
    return [each for drives in (*beyond.pairs(effort), *supplies) for each in scores(drives, effort, (BEST,))[BEST]]


def compared(structure: Isolability, found: Mapping[str, Sequence[DriveScore]]) -> Iterator[Compared]:
    """Theory and measurement for every fault of some drives."""
    counts = {name: confusion(of) for name, of in found.items()}
    # Both sides join the elements of a pair in an order of their own.
    names = {_canonical(fault): fault for fault in structure.faults}
    for fault in dict.fromkeys(fault for of in counts.values() for fault in of):
        name = names[_canonical(fault)]
        alike = tuple(
            each for each in map(_canonical, structure.mistaken_for(name)) if each.count(" + ") == fault.count(" + ")
        )
        seen = structure.detectable[structure.faults.index(name)]
        theory = f"not isolable from {listed(alike, 'or')}" if alike else "isolable"
        named = {diagnosis: of[fault] for diagnosis, of in counts.items()}
        yield Compared(fault, theory if seen else "not detectable", alike, named)


def _canonical(fault: str) -> str:
    return " + ".join(sorted(fault.split(" + "), key=ELEMENTS.index))


def table(title: str, rows: Sequence[Compared]) -> Table:
    """Table with one row per fault: isolability by structure, and the names declared by each diagnosis."""
    diagnoses = list(dict.fromkeys(name for each in rows for name in each.named))
    cells = [
        (_plain(each.fault), each.theory, *(_counted(each.fault, each.named[name]) for name in diagnoses))
        for each in rows
    ]
    return Table(title, ("fault", "by structure", *(VARIANTS[name].title for name in diagnoses)), tuple(cells))


def disagreements(rows: Iterable[Compared], remark: str = "") -> Iterator[tuple[str, ...]]:
    """Table rows of all disagreements: fault, isolability by structure, diagnosis, measurement, and reason.

    Args:
        remark: text that is added to the names of the faults
    """
    for each in rows:
        for name, named in each.named.items():
            for other, count in named.most_common():
                why = reason(each, other, name)
                if why:
                    words = f"{count} of {named.total()}: {_word(each.fault, other)}"
                    yield _plain(each.fault) + remark, each.theory, VARIANTS[name].title, words, why


def reason(each: Compared, named: str, diagnosis: str = BEST) -> str:
    """Reason why a fault was named otherwise than structure predicts; "" where both agree.

    Args:
        diagnosis: name of the diagnosis, the bank or one of the rules
    """
    if named in ((*each.alike, AMBIGUOUS) if each.alike else (each.fault,)):
        return ""
    if named == NEVER:
        return "its equations have it, but not its size: nothing differed by three standard deviations for long enough"
    if named == each.fault:
        return "structure regards no time: the split of the steering torque alternates, which makes the motors isolable"
    kind = named if named in (UNNAMED, AMBIGUOUS) else "others"
    if diagnosis != BEST:
        return _OF_RULES[kind]
    if set(named.split(" + ")) < set(each.fault.split(" + ")):
        return "the rest adds too little to what the first explains to be worth a second fault hypothesis"
    return _OF_BANK[kind]


_OF_BANK = {
    UNNAMED: "structure regards no magnitudes: below the limits of fault-free drives",
    AMBIGUOUS: "structure regards no magnitudes: other faults explained the readings almost as well",
    "others": "structure regards no magnitudes: other faults explained the readings within the fault-free limits",
}
_OF_RULES = {
    UNNAMED: "no rule fits: a residual that it asks for stays below its threshold",
    AMBIGUOUS: "several rules fit, or come as near: their conditions on the residuals do not discriminate these faults",
    "others": "the rule of another fits: the motion carries the fault into residuals whose equations do not contain it",
}


def _counted(fault: str, named: Counter[str]) -> str:
    return ", ".join(f"{_word(fault, name)} {count}" for name, count in named.most_common())


def _word(fault: str, named: str) -> str:
    return "right" if named == fault else _plain(named)


def _plain(name: str) -> str:
    return name.replace("_", " ")
