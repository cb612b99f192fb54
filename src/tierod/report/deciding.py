"""What decided a verdict, in words: quantity, how far it came, threshold and moment."""

from __future__ import annotations

from tierod.core.findings import Decided, Diagnosis, Finding
from tierod.core.shown import shown
from tierod.report.display import instant, number, words


def deciding(diagnosis: Diagnosis, finding: Finding) -> list[str]:
    """A sentence for every decision that raised the alarm of a finding.

    Args:
        diagnosis: with all decisions
        finding: of the diagnosis
    """
    return [_sentence(diagnosis, each) for each in diagnosis.decisions if each.name in finding.decided_by]


def alarm_from(levels: tuple[float, ...], below: bool) -> str:
    """The thresholds of a rule, as shown: "alarm from 4", "alarm beyond ±0.06", "alarm below 9".

    Args:
        levels: thresholds; empty gives ""
        below: whether the rule alarms below them
    """
    if not levels:
        return ""
    if below:
        return f"alarm below {number(levels[0], 3)}"
    if len(levels) == 2 and levels[0] == -levels[1]:
        return f"alarm beyond ±{number(abs(levels[0]), 3)}"
    return f"alarm from {', '.join(number(level, 3) for level in levels)}"


def _sentence(diagnosis: Diagnosis, each: Decided) -> str:
    trace = diagnosis.traces.get(each.statistic)
    factor, label = shown(trace.unit if trace is not None else "")
    if each.reached is None:
        return words(each.name)
    parts = [f"{number(each.reached * factor, 4)} {label}".strip()]
    if each.levels:
        parts.append(f"{alarm_from(tuple(level * factor for level in each.levels), each.below)} {label}".strip())
    if each.passed is not None:
        parts.append(f"first at {instant(each.passed)}")
    return f"{words(each.name)}: {', '.join(parts)}"
