"""Decisive rules of a verdict, rows of sensors, actuators and uncertain parameters; for terminal and page."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.findings import Decided, Diagnosis, Element, Episode, Finding, ParameterEffect
from tierod.core.shown import in_words, shown, written
from tierod.core.statuses import Status
from tierod.monitors.harness.spread.advice import first_to_measure
from tierod.report.display import instant, interval, number, share, words

EFFECT_COLUMNS = ("parameter", "value", "moves the result by", "share of what parameters add")

EFFECT_HEADING = "Which parameters decide"


def effect_rows(diagnosis: Diagnosis) -> list[tuple[str, str, str, str]]:
    """Cells of `EFFECT_COLUMNS` for every uncertain parameter that affects the result, the largest effect first."""
    return [(each.name, _value(each), _effect(each), share(each.share)) for each in diagnosis.parameter_effects]


def measure_first(diagnosis: Diagnosis) -> str:
    """Recommendation of the parameter to measure first; "" where none affects the result."""
    first = first_to_measure(diagnosis.parameter_effects)
    if first is None:
        return ""
    return (
        f"Each effect is that of one standard deviation of the parameter. Measure {first.name} first to "
        f"narrow the band: it causes {share(first.share)} of the variance that uncertain parameters add."
    )


def _value(each: ParameterEffect) -> str:
    return f"{number(each.value, 4)} ± {number(each.standard_deviation, 2)} {written(each.unit)}".rstrip()


def _effect(each: ParameterEffect) -> str:
    factor, label = shown(each.effect_unit)
    return f"{'−' if each.effect < 0.0 else '+'}{number(abs(each.effect) * factor, 2)} {label or 'of the threshold'}"


def deciding(diagnosis: Diagnosis, finding: Finding) -> list[str]:
    """A sentence for every decision that raised the alarm of a finding."""
    return [_sentence(diagnosis, each) for each in diagnosis.decisions if each.name in finding.decided_by]


def alarm_from(levels: tuple[float, ...], below: bool) -> str:
    """Thresholds of a rule as text: "alarm from 4", "alarm beyond ±0.06", "alarm below 9"."""
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


def dated(finding: Finding) -> str:
    """Times at which the change of a finding began, ended and, where noticeably later, was declared; "" without one."""
    if finding.since is None:
        return ""
    begin = f"at {instant(finding.since)}" if finding.since > 0.0 else "at the start"
    later = (("ended", finding.end), ("declared", finding.belated))
    return ", ".join((begin, *(f"{what} at {instant(time)}" for what, time in later if time is not None)))


COLUMNS = ("sensor or actuator", "state", "fault", "from", "to", "declared", "size", "replaced by", "code")


class ElementRow(NamedTuple):
    """One table row: of an element without episodes, or of one of its episodes.

    Args:
        name: of the element; "" in the rows of its further episodes
        status: of the element
        first: whether it is the first row of its element, which alone shows the status
        fault, start, end, declared, size, substitute, code: displayed texts; the time of a declaration is shown where
            it came noticeably later than the onset
    """

    name: str
    status: Status
    first: bool
    fault: str
    start: str
    end: str
    declared: str
    size: str
    substitute: str
    code: str

    @property
    def cells(self) -> tuple[str, ...]:
        """Cells in the order of `COLUMNS`."""
        state = f"{self.status.symbol} {self.status}" if self.first else ""
        return (self.name, state, *self[3:])


def rows(element: Element) -> list[ElementRow]:
    """Rows of one element: one per episode, and at least one."""
    if not element.episodes:
        return [
            ElementRow(
                words(element.name), element.status, True, _none(element), "", "", "", "", "", element.trouble_code
            )
        ]  # fmt: skip
    lines = []
    for place, episode in enumerate(element.episodes):
        first = place == 0
        lines.append(
            ElementRow(
                words(element.name) if first else "",
                element.status,
                first,
                _fault(episode),
                instant(episode.start) if episode.start > 0.0 else "start",
                "end" if episode.end is None else instant(episode.end),
                "" if episode.belated is None else instant(episode.belated),
                _size(episode),
                element.substitute if first else "",
                element.trouble_code if first else "",
            )
        )
    return lines


def _none(element: Element) -> str:
    """Why it was not judged, or from which size on it has no fault."""
    if element.smallest is None:
        return element.cause
    what = "offset" if element.role == "sensor" else "loss of torque"
    bound = f"no {what} above {in_words(element.smallest, element.unit, 2)}"
    return f"{bound}, {element.cause}" if element.cause else bound


def _fault(episode: Episode) -> str:
    others = " or ".join(words(name).lower() for name in episode.candidates)
    return f"{episode.kind or 'kind not known'}{f'; not separable from {others}' if others else ''}"


def _size(episode: Episode) -> str:
    if episode.magnitude is None:
        return ""
    value, low, high, unit = interval(episode.magnitude)
    return f"{value} {unit} ({low} to {high})" if low != "–" else f"{value} {unit}"
