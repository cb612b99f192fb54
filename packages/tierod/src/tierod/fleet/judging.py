"""Judgement of one recording for the tables of a fleet: rows of findings, and estimates over time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from tierod.core.errors import InputError
from tierod.core.findings import Element, Episode, Finding, Trace
from tierod.core.recording import Recording
from tierod.core.series import CALENDAR
from tierod.core.version import __version__
from tierod.fleet.likeness import TEMPERATURE, Moments
from tierod.fleet.schema import WHOLE
from tierod.monitors.pieces import CHUNK
from tierod.monitors.runner import Chosen, Concluded, Runner
from tierod.vehicles import Vehicle
from tierod.work.fingerprint import fingerprint

Row = dict[str, Any]  # Row of the findings, without the columns from the fleet file


EDGE: Annotated[float, "s"] = 0.5
"""Tolerance on the length of a span: its last sample lies before its end by up to one period of the slowest signal."""


class TooShort(InputError):
    """Recording that is too short to be judged."""


@dataclass(frozen=True)
class Asked:
    """Settings by which recordings are judged."""

    monitors: tuple[Chosen, ...]  # the monitors that judge
    # time between stored verdicts of a long recording, with the state kept; infinite for one verdict [s]
    span: Annotated[float, "s"] = float("inf")
    shortest: Annotated[float, "s"] = 30.0  # shortest duration of a recording that is judged [s]
    # whether parameter uncertainty is propagated into bands and verdict. A parameter error is the same in all drives of
    # a car, so that it shifts its level, but not its trend
    spread: bool = True

    def runner(self, car: Vehicle) -> Runner:
        """The monitors, prepared for a recording."""
        return Runner(car, self.monitors, self.spread, signals_shown=False)


@dataclass(frozen=True)
class Judgement:
    """Judgement of a recording."""

    rows: tuple[Row, ...]  # rows of the findings
    estimates: Mapping[str, Mapping[str, Trace]]  # traces of the estimates, by monitor and name
    refused: Mapping[str, str]  # reason why a monitor did not run, by monitor
    start: Annotated[float, "s"] | None  # start of the recording in seconds since 1970, UTC; None without a date
    duration: Annotated[float, "s"]  # duration of the recording [s]
    moments: Mapping[str, Sequence[float]]  # mean and standard deviation of every signal that was read


def judge(pieces: Iterator[Recording], runner: Runner, asked: Asked, start: float | None = None) -> Judgement:
    rows: list[Row] = []
    moments = Moments()
    ended = 0
    kept: dict[str, Concluded] = {}
    for piece in pieces:
        runner.add(piece)
        moments.add(piece)
        begin, end = runner.span or piece.span
        if end - begin >= (ended + 1) * asked.span - EDGE:
            rows += _rows(kept := dict(runner.concluded()), runner.car, ended, moments)
            ended += 1
        if not runner.runs:
            break
    begin, end = runner.span or (0.0, 0.0)
    if runner.runs and end - begin < asked.shortest:
        raise TooShort(f"it has {end - begin:.3g} s; less than {asked.shortest:g} s are not judged (--shortest)")
    if end - begin > ended * asked.span or not ended:
        rows += _rows(kept := dict(runner.concluded()), runner.car, ended, moments)
    date = _date(runner.metadata, start)
    for row in rows:
        row["start"] = None if date is None else date + row["start_s"] - begin
    estimates = {
        name: {trace: each.diagnosis.traces[trace] for trace in each.estimates if trace in each.diagnosis.traces}
        for name, each in kept.items()
    }
    return Judgement(tuple(rows), estimates, dict(runner.refused), date, end - begin, moments.moments)


def chunk(asked: Asked) -> float:
    """Length of the pieces in which a recording is read [s]."""
    return min(CHUNK, asked.span)


def _date(metadata: Mapping[str, object], start: float | None) -> float | None:
    """Start of the recording in seconds since 1970; None without a date."""
    origin = metadata.get("origin")
    if isinstance(origin, float | int) and origin > CALENDAR:
        return float(origin)
    return start


def _judged_share(evidence: Mapping[str, float]) -> float:
    """Share of the drive in which all signals required for a judgement were valid."""
    return evidence.get("required_signals_share", evidence.get("signals_complete_share", 1.0))


def _rows(concluded: Mapping[str, Concluded], car: Vehicle, span: int, moments: Moments) -> list[Row]:
    rows = []
    heat = moments.of(TEMPERATURE)
    for name, each in concluded.items():
        diagnosis = each.diagnosis
        duration = float(diagnosis.recording["duration_s"])
        common = {
            "span": span,
            "start_s": float(diagnosis.recording["start_s"]),
            "duration_s": duration,
            "judged_s": duration * _judged_share(diagnosis.findings[0].evidence),
            "temperature_K": None if heat is None else heat[0],
            "monitor": name,
            "variant": each.variant,
            "tuning": fingerprint(diagnosis.parameters[len(car.parameters) :]),
            "version": __version__,
        }
        rows += [common | _of_finding(finding) for finding in diagnosis.findings]
        rows += [common | row for element in diagnosis.elements for row in _of_element(element)]
    return rows


def _of_finding(finding: Finding) -> Row:
    estimate = finding.estimate
    row: Row = {
        "judged": WHOLE,
        "role": "",
        "status": str(finding.status),
        "since_s": finding.since,
        "declared_s": finding.declared,
        "end_s": finding.end,
        "kind": "",
        "cause": finding.cause,
        "action": finding.action,
    }
    if estimate is not None:
        row |= {
            "quantity": estimate.quantity,
            "unit": estimate.unit,
            "estimate": _finite(estimate.value),
            "deviation": _finite(estimate.standard_deviation),
            "shared_deviation": _finite(math.hypot(*shared)) if (shared := estimate.by_sensors.values()) else None,
            "nominal": _finite(estimate.reference.get("nominal")),
            # Of the vehicle file, where the reference has a margin of this drive on it.
            "limit": _finite(estimate.fault_from or estimate.reference.get("fault")),
        }
    return row


def _of_element(element: Element) -> Iterator[Row]:
    """One row per episode of a sensor or actuator; a single row if there is none."""
    episodes: tuple[Episode | None, ...] = element.episodes or (None,)
    for episode in episodes:
        row: Row = {
            "judged": element.name,
            "role": element.role,
            "status": str(element.status),
            "kind": "",
            "cause": element.cause,
            "action": "",
        }
        if episode is not None:
            size = episode.magnitude
            row |= {"since_s": episode.start, "declared_s": episode.declared, "end_s": episode.end}
            row |= {"kind": episode.kind or " or ".join(episode.candidates)}
            if size is not None:
                row |= {
                    "magnitude": _finite(size.value),
                    "magnitude_deviation": _finite(size.standard_deviation),
                    "magnitude_unit": size.unit,
                }
        yield row


def _finite(value: float | None) -> float | None:
    return None if value is None or not np.isfinite(value) else float(value)
