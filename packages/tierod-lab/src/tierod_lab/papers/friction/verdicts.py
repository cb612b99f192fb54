"""Verdicts of the default monitor over a fleet, each car against its own baseline."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tierod.core.claims import Claim, at_least, exactly
from tierod.core.content import Item, Table
from tierod.core.statuses import Status
from tierod_lab.campaign.figures import area_under_curve, rate_bound
from tierod_lab.papers.friction.cases import HEALTHY, Case
from tierod_lab.papers.friction.digest import ALARM, Verdict
from tierod_lab.papers.friction.fleet import FOUND, GOAL, faulty_drives, healthy_drives, ratios
from tierod_lab.papers.friction.paper_sets import paper_sets
from tierod_lab.papers.friction.runs import Drives
from tierod_lab.studies.effort import Effort


def items(drives: Drives, effort: Effort) -> Iterator[Item]:
    faulty = faulty_drives(effort)
    yield _verdicts({"Healthy": healthy_drives(effort)} | faulty, drives, effort)
    yield from _claims(faulty, drives, effort)


def _judged(cases: tuple[Case, ...], drives: Drives) -> list[Verdict]:
    return [each.verdict for each in drives.of(cases) if each.verdict is not None]


def _fault_free(effort: Effort, drives: Drives) -> list[tuple[Case, Verdict]]:
    """The paper's fault-free drives with their verdicts, each against the baseline of its reference drive."""
    cases = [case for case in paper_sets(effort).all_of("Healthy") if case in drives.digests]
    return list(zip(cases, _judged(tuple(cases), drives), strict=True))


def _verdicts(groups: dict[str, tuple[Case, ...]], drives: Drives, effort: Effort) -> Table:
    rows = []
    fault_free = _fault_free(effort, drives)
    named_groups = {"paper's fault-free drives": [verdict for _, verdict in fault_free]}
    named_groups |= {state: _judged(cases, drives) for state, cases in groups.items() if state != "Healthy"}
    for state, verdicts in named_groups.items():
        shown = (Status.HEALTHY, *FOUND, Status.SUSPECT)
        counts = [sum(verdict.status is status for verdict in verdicts) for status in shown]
        others = len(verdicts) - sum(counts)
        low = min((verdict.ratios[0] for verdict in verdicts), default=math.nan)
        high = max((verdict.ratios[1] for verdict in verdicts), default=math.nan)
        rows.append((state, str(len(verdicts)), *map(str, counts), str(others), f"{low:.2f} to {high:.2f}"))
    return Table(
        "Verdicts against the car's baseline, learnt on another drive, other roads and other tyres",
        ("drives", "number", "healthy", "rising", "fault", "suspect", "not judged", "ratio to the baseline"),
        tuple(rows),
    )


def _missed(faulty: dict[str, tuple[Case, ...]], drives: Drives) -> str:
    words = []
    for case in (case for cases in faulty.values() for case in cases):
        verdict = drives.digests[case].verdict if case in drives.digests else None
        if verdict is None:
            words.append(f"{case.level:.2f} N·m, no drive")
        elif verdict.status not in FOUND:
            level, deviation = verdict.level or (math.nan, math.nan)
            words.append(
                f"{case.level - HEALTHY:.2f} N·m more, {verdict.status}, {verdict.ratios[0]:.2f} to "
                f"{verdict.ratios[1]:.2f} times a level of {level:.2f} ± {deviation:.2f} N·m"
            )
    return "; ".join(words)


def _claims(faulty: dict[str, tuple[Case, ...]], drives: Drives, effort: Effort) -> Iterator[Claim]:
    verdicts = [verdict for cases in faulty.values() for verdict in _judged(cases, drives)]
    expected = sum(len(cases) for cases in faulty.values())
    yield Claim(
        "verdict.faults-found",
        "Against the car's baseline every drive with a fault of 1 N·m or more is found.",
        GOAL,
        None,
        float(expected - sum(verdict.status in FOUND for verdict in verdicts)),
        exactly(0.0),
        "",
        f"Drives not found, of {expected}.",
        cause=f"Not found: {_missed(faulty, drives)}. The limit is 1.2 times the level raised by its deviation; where "
        "friction is only just above, the drive ends before the excess is confirmed. A longer drive, or a level learnt "
        "over more drives, would mend it.",
    )
    pairs = ratios(faulty["PWM 15%"], drives)
    yield Claim(
        "verdict.auc-slight",
        "As a ratio to the baseline, 1 to 2 N·m more are separated from fault-free drives whatever the car.",
        GOAL,
        None,
        area_under_curve(ratios(paper_sets(effort).all_of("Healthy"), drives), pairs),
        at_least(0.999),
        "",
        "AUC of the mean estimate over the level learnt on another drive.",
    )
    fault_free = _fault_free(effort, drives)
    minutes = sum(case.minutes for case, _ in fault_free)
    alarmed = sum(case.minutes for case, verdict in fault_free if verdict.worst >= ALARM)
    yield Claim(
        "verdict.healthy-minutes",
        "Against the car's baseline none of the fault-free minutes of Table 2 alarms.",
        GOAL,
        None,
        alarmed if fault_free else math.nan,
        exactly(0.0),
        "min",
        f"Minutes of drives with an alarm at any time, of {minutes:.0f}; at most "
        f"{rate_bound(0, minutes / 60.0):.2g} alarms an hour with 95 % confidence if none.",
    )
