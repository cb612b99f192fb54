"""Items of a diagnosis: verdicts, sensors and actuators, uncertain parameters, charts, data quality, parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tierod.core.content import Facts, Fold, Heading, Item, Table, Verdict
from tierod.core.findings import Decided, Diagnosis, Element, Episode, Finding, ParameterEffect
from tierod.core.series import CALENDAR
from tierod.core.shown import in_words, shown, written
from tierod.monitors.robustness import first_to_measure
from tierod.report.charts.decisions import (
    decision_figure,
    design_charts,
    histogram_chart,
    looks_chart,
    loop_chart,
    quiet_figure,
)
from tierod.report.charts.elements import state_figure, substitute_figures
from tierod.report.charts.figure import Figure
from tierod.report.charts.over_time import estimate_figures, innovation_figure, result_figure, signal_figure
from tierod.report.display import alarm_from, date, dated, duration, evidence, instant, interval, number, share, words
from tierod.report.html import Origin, page, sentence

Parts = Iterator[Item | Figure]

NOTHING_RAN = (
    "'tierod inspect' with the recording shows which signals it has and what each monitor lacks; a channel map (--map) "
    "gives signals under other names."
)
LATEST = 2.5e11  # Latest plausible calendar time [s since 1970]; later ones are beyond any calendar year


def render(diagnosis: Diagnosis) -> str:
    name = str(diagnosis.recording.get("name") or Path(str(diagnosis.recording.get("path", "recording"))).name)
    car = diagnosis.vehicle.get("name")
    return page(
        items(diagnosis),
        Origin(diagnosis.created, diagnosis.version, diagnosis.command),
        f"{diagnosis.status}: {name}",
        f"{name}, vehicle {car}" if car else name,
        diagnosis.traces,
        list(_origin(diagnosis)),
    )


def items(diagnosis: Diagnosis) -> Parts:
    """All items, in the order of the page."""
    yield from verdicts(diagnosis)
    yield from elements(diagnosis)
    yield from filter(None, (state_figure(diagnosis), *substitute_figures(diagnosis)))
    yield from effects(diagnosis)
    charts = [each for each in (*estimate_figures(diagnosis), result_figure(diagnosis)) if each]
    remark = diagnosis.remarks.get("estimate")
    if charts or remark:
        yield Heading("What was estimated", (remark,) if remark else ())
        yield from charts
    yield from _decisions(diagnosis)
    loops, histograms = loop_chart(diagnosis), histogram_chart(diagnosis)
    if loops or histograms:
        remark = diagnosis.remarks.get("histograms") if histograms else None
        yield Heading("Where it shows", (remark,) if remark else (), "pair")
        yield from filter(None, (loops, histograms))
    consistency, innovations = diagnosis.consistency, innovation_figure(diagnosis)
    if consistency or innovations:
        remark = diagnosis.remarks.get("consistency")
        yield Heading("Can the estimator be trusted", (remark,) if remark else (), "together")
        if consistency:
            yield Facts([evidence(*each) for each in consistency.items()])
        yield from filter(None, [innovations])
    if signals := signal_figure(diagnosis):
        yield Heading("What was recorded")
        yield signals
    if diagnosis.quality:
        yield Heading("Data quality")
        header = ("channel", "source", "samples", "rate [Hz]", "missing", "longest gap", "lowest", "highest", "unit")
        yield Table("", (*header, "remarks"), tuple(map(_quality, diagnosis.quality)))
    yield from _parameters(diagnosis)


def shown_items(diagnosis: Diagnosis) -> Parts:
    yield from verdicts(diagnosis)
    yield from elements(diagnosis, narrow=True)
    yield from effects(diagnosis)
    yield from remarks(diagnosis)


def verdicts(diagnosis: Diagnosis, recording: str = "") -> Iterator[Verdict]:
    """A verdict for each finding, or one that says that no monitor ran; `recording` is one of several."""
    if not diagnosis.findings:
        yield Verdict("no monitor ran on this recording", diagnosis.status, reasons=(("What to do", NOTHING_RAN),))
    for finding in diagnosis.findings:
        about = [("monitor", finding.monitor)]
        about += [("recording", recording)] if recording else []
        about += [("change began", dated(finding))] if finding.since is not None else []
        action = "nothing" if finding.action == "none" else finding.action
        reasons = [("Decided by", each) for each in deciding(diagnosis, finding)]
        reasons += [(name, text) for name, text in (("Why", finding.cause), ("What to do", action)) if text]
        reasons += [("To know", warning) for warning in finding.warnings]
        figures = tuple(evidence(*each) for each in finding.evidence.items())
        yield Verdict(
            finding.headline, finding.status, tuple(about), finding.details, finding.estimate, tuple(reasons), figures
        )


def deciding(diagnosis: Diagnosis, finding: Finding) -> list[str]:
    """A sentence for every decision that raised the alarm of a finding."""
    return [_decided(diagnosis, each) for each in diagnosis.decisions if each.name in finding.decided_by]


def _decided(diagnosis: Diagnosis, each: Decided) -> str:
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


COLUMNS = ("sensor or actuator", "state", "fault", "from", "to", "declared", "size", "replaced by", "code")


def elements(diagnosis: Diagnosis, narrow: bool = False) -> Iterator[Item]:
    """Table of sensors and actuators, one row per episode; `narrow` leaves empty columns out."""
    if not diagnosis.elements:
        return
    lines = [row for element in diagnosis.elements for row in element_rows(element)]
    filled = [place for place, _ in enumerate(COLUMNS) if not narrow or any(row[place] for row in lines)]
    yield Heading("Sensors and actuators")
    yield Table("", tuple(COLUMNS[k] for k in filled), tuple(tuple(row[k] for k in filled) for row in lines))


def element_rows(element: Element) -> list[tuple[str, ...]]:
    """Rows of one element in the order of `COLUMNS`; only the first one names it and has its status."""
    head, last = (words(element.name), element.status), element.trouble_code
    if not element.episodes:
        return [(*head, _none(element), "", "", "", "", "", last)]
    lines = [
        (
            _fault(episode),
            instant(episode.start) if episode.start > 0.0 else "start",
            "end" if episode.end is None else instant(episode.end),
            "" if episode.belated is None else instant(episode.belated),
            _size(episode),
        )
        for episode in element.episodes
    ]
    return [(*head, *lines[0], element.substitute, last), *(("", "", *line, "", "") for line in lines[1:])]


def _none(element: Element) -> str:
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


def effects(diagnosis: Diagnosis) -> Iterator[Item]:
    """Table of the uncertain parameters that affect the result, the largest effect first, and which to measure."""
    first = first_to_measure(diagnosis.parameter_effects)
    advice = (
        f"Each effect is that of one standard deviation of the parameter. Measure {first.name} first to "
        f"narrow the band: it causes {share(first.share)} of the variance that uncertain parameters add."
        if first
        else ""
    )
    text = tuple(filter(None, (diagnosis.remarks.get("parameters", ""), advice)))
    if diagnosis.parameter_effects or text:
        yield Heading("Which parameters decide", text)
    if diagnosis.parameter_effects:
        header = ("parameter", "value", "moves the result by", "share of what parameters add")
        rows = tuple(
            (each.name, _uncertain(each), _effect(each), share(each.share)) for each in diagnosis.parameter_effects
        )
        yield Table("", header, rows)


def _uncertain(each: ParameterEffect) -> str:
    return f"{number(each.value, 4)} ± {number(each.standard_deviation, 2)} {written(each.unit)}".rstrip()


def _effect(each: ParameterEffect) -> str:
    factor, label = shown(each.effect_unit)
    return f"{'−' if each.effect < 0.0 else '+'}{number(abs(each.effect) * factor, 2)} {label or 'of the threshold'}"


def remarks(diagnosis: Diagnosis) -> Iterator[Item]:
    warned = {warning for finding in diagnosis.findings for warning in finding.warnings}
    found = [(row.name, remark) for row in diagnosis.quality for remark in row.remarks]
    if rows := tuple((words(name), remark) for name, remark in found if f"{name}: {remark}" not in warned):
        yield Table("Remarks on the data", ("channel", "remark"), rows)


def _decisions(diagnosis: Diagnosis) -> Parts:
    if not diagnosis.decisions:
        return
    yield Heading("How it was decided")
    yield from filter(None, (decision_figure(diagnosis), looks_chart(diagnosis)))
    rows = tuple((each.name, each.distance, each.rule, each.false_alarms, each.source) for each in diagnosis.decisions)
    header = ("decides", "distance", "stopping rule", "false alarms", "where from")
    quiet = quiet_figure(diagnosis)
    rules = Table("Stopping rules of the monitor", header, rows)
    inside = [rules, *([quiet] if quiet else []), *design_charts(diagnosis)]
    yield Fold(f"The rules and their false alarms ({len(rows)})", inside)


def _quality(row: Any) -> tuple[str, ...]:
    factor, label = shown(row.unit)
    return (
        words(row.name),
        row.source,
        f"{row.samples:,}".replace(",", " "),
        number(row.rate, 3),
        share(row.missing_share),
        duration(row.longest_gap),
        number(row.minimum * factor, 3),
        number(row.maximum * factor, 3),
        label,
        "; ".join(f"▲ {remark}" for remark in row.remarks) or "–",
    )


def _parameters(diagnosis: Diagnosis) -> Iterator[Item]:
    if not diagnosis.parameters:
        return
    rows = [(row[4].startswith("tuning of"), _parameter(*row)) for row in diagnosis.parameters]
    own, tuning = ([row for of_tuning, row in rows if of_tuning is wanted] for wanted in (False, True))
    yield Heading("Parameters and where they come from")
    if own:
        yield Table("", ("parameter", "value", "±", "unit", "source"), tuple(own))
    if tuning:
        sources = sentence(", ".join(sorted({row[4] for row in tuning}))).rstrip(".")
        values = [(name, f"{value} {unit}") for name, value, _, unit, _ in tuning]
        reason = f"{sources}. Reason and source of each value stand beside it in tierod's own files."
        yield Fold(f"Tuning of the monitor ({len(tuning)} values)", [Facts(values)], (reason,))


def _parameter(name: str, value: float, unit: str, spread: float | None, source: str) -> tuple[str, str, str, str, str]:
    # Parameters are shown in SI units, as in the vehicle file; charts and texts use other units.
    factor, as_shown = shown(unit)
    label = f"{written(unit)} ({number(value * factor, 3)} {as_shown})" if factor != 1.0 else written(unit)
    return words(name), number(value, 5), "" if spread is None else number(spread, 3), label, source


def _origin(diagnosis: Diagnosis) -> Iterator[Item]:
    if recording := _facts(diagnosis.recording):
        yield Facts(recording, "Recording")
    nested = [row for key, value in diagnosis.recording.items() if _is_nested(value) for row in _flat(key, value)]
    if nested:
        table = Table("Metadata of the file", ("entry", "value"), tuple(nested))
        yield Fold(f"Everything in the file ({len(nested)} entries)", [table], printed=False)
    if vehicle := _facts(diagnosis.vehicle):
        yield Facts(vehicle, "Vehicle")


def _facts(facts: Mapping[str, object]) -> list[tuple[str, str]]:
    rows = []
    for name, value in facts.items():
        if name == "origin" and isinstance(value, int | float) and CALENDAR < value < LATEST:
            rows.append(("Began", date(value)))
        elif isinstance(value, list | tuple) and value and not _is_nested(value):
            rows.append((words(name), "; ".join(map(str, value))))
        elif name.endswith("_unit"):
            rows.append((words(name), written(str(value))))
        elif value not in (None, "") and not isinstance(value, list | tuple | dict):
            rows.append(evidence(name, value))
    return rows


def _is_nested(value: object) -> bool:
    inside = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ()
    return isinstance(value, dict) or any(isinstance(entry, dict | list | tuple) for entry in inside)


def _flat(name: str, value: Any) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict):
        for key, entry in value.items():
            yield from _flat(f"{name}.{key}", entry)
    else:
        yield name, number(value, 6) if isinstance(value, float) else str(value)
