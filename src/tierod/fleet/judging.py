"""One recording judged for the tables of a fleet: rows of findings, and estimates over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from tierod.core.errors import InputError
from tierod.core.findings import Element, Episode, Finding, Trace
from tierod.core.recording import Recording
from tierod.core.timestamps import CALENDAR
from tierod.core.version import __version__
from tierod.experiments.fingerprint import fingerprint
from tierod.fleet.likeness import TEMPERATURE, Moments
from tierod.fleet.schema import WHOLE
from tierod.io.readers import open_chunks
from tierod.monitors.harness.pieces import CHUNK
from tierod.monitors.together import Chosen, Concluded, Together
from tierod.vehicles import Vehicle

Row = dict[str, Any]
"""Of the findings, without what the fleet file decides."""


EDGE: Annotated[float, "s"] = 0.5
"""The last sample of a span comes before its end, by one period of the slowest signal at the most."""


class TooShort(InputError):
    """A recording that no monitor can judge."""


@dataclass(frozen=True)
class Asked:
    """Settings by which recordings are judged.

    Args:
        monitors: that judge
        span: of a long recording after which a verdict is kept, the state carried on; infinite for one verdict [s]
        shortest: recording that is judged [s]
        spread: whether the spread of a vehicle's parameters is carried into bands and verdict. An error of a parameter
            is the same in all drives of a car, so that it moves its level and not its trend
    """

    monitors: tuple[Chosen, ...]
    span: Annotated[float, "s"] = float("inf")
    shortest: Annotated[float, "s"] = 30.0
    spread: bool = True

    def together(self, car: Vehicle) -> Together:
        """The monitors, ready for a recording.

        Args:
            car: as which it is judged
        """
        return Together(car, self.monitors, self.spread, signals_shown=False)


@dataclass(frozen=True)
class Judgement:
    """Judgement of a recording.

    Args:
        rows: of the findings
        estimates: traces that the monitors made, by monitor and name, with their units
        refused: by monitor, why it did not run
        start: seconds since 1970, UTC; None without a date
        duration: [s]
        moments: mean and standard deviation of every signal that was read
    """

    rows: tuple[Row, ...]
    estimates: Mapping[str, Mapping[str, Trace]]
    refused: Mapping[str, str]
    start: Annotated[float, "s"] | None
    duration: Annotated[float, "s"]
    moments: Mapping[str, Sequence[float]]


def pieces_of(path: Path, car: Vehicle, needs: Sequence[str], seconds: float) -> Iterator[Recording]:
    """The pieces of a recording, with the channels that are needed and the outside temperature.

    Raises:
        InputError: it cannot be read
    """
    names = dict.fromkeys([*needs, TEMPERATURE])
    return open_chunks(path, seconds=seconds, names=names, dbc=car.database, channel_map=car.channel_map)


def judge(pieces: Iterator[Recording], together: Together, asked: Asked, start: float | None = None) -> Judgement:
    """Let the monitors judge a recording.

    Args:
        pieces: of the recording, in the order of time
        together: the monitors, new
        asked: how it is judged
        start: of the recording, where its own clock has no date; seconds since 1970, UTC

    Raises:
        InputError: the recording cannot be read, or is too short
    """
    rows: list[Row] = []
    moments = Moments()
    ended = 0
    kept: dict[str, Concluded] = {}
    for piece in pieces:
        together.add(piece)
        moments.add(piece)
        begin, end = together.span or piece.span
        if end - begin >= (ended + 1) * asked.span - EDGE:
            rows += _rows(kept := dict(together.concluded()), together.car, ended, moments)
            ended += 1
        if not together.running:
            break
    begin, end = together.span or (0.0, 0.0)
    if together.running and end - begin < asked.shortest:
        raise TooShort(f"it has {end - begin:.3g} s, and less than {asked.shortest:g} s say nothing (--shortest)")
    if end - begin > ended * asked.span or not ended:
        rows += _rows(kept := dict(together.concluded()), together.car, ended, moments)
    date = _date(together.metadata, start)
    for row in rows:
        row["start"] = None if date is None else date + row["start_s"] - begin
    estimates = {
        name: {trace: each.diagnosis.traces[trace] for trace in each.estimates if trace in each.diagnosis.traces}
        for name, each in kept.items()
    }
    return Judgement(tuple(rows), estimates, dict(together.refused), date, end - begin, moments.moments)


def chunk(asked: Asked) -> float:
    """Length of the pieces in which a recording is read [s]."""
    return min(CHUNK, asked.span)


def _date(metadata: Mapping[str, object], start: float | None) -> float | None:
    """Time at which the recording began, seconds since 1970; None where nothing states it."""
    origin = metadata.get("origin")
    if isinstance(origin, float | int) and origin > CALENDAR:
        return float(origin)
    return start


def _judged_share(evidence: Mapping[str, float]) -> float:
    """The share of the drive in which everything was there without which nothing is judged."""
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
        "word": finding.shown_status,
        "since_s": finding.since,
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
            "nominal": _finite(estimate.reference.get("nominal")),
            "limit": _finite(estimate.reference.get("fault")),
        }
    return row


def _of_element(element: Element) -> Iterator[Row]:
    """One row for each episode of a sensor or actuator; one alone where it has none."""
    episodes: tuple[Episode | None, ...] = element.episodes or (None,)
    for episode in episodes:
        row: Row = {
            "judged": element.name,
            "role": element.role,
            "status": str(element.status),
            "word": str(element.status),
            "kind": "",
            "cause": element.cause,
            "action": "",
        }
        if episode is not None:
            size = episode.magnitude
            row |= {"since_s": episode.start, "kind": episode.kind or " or ".join(episode.candidates)}
            if size is not None:
                row |= {
                    "magnitude": _finite(size.value),
                    "magnitude_deviation": _finite(size.standard_deviation),
                    "magnitude_unit": size.unit,
                }
        yield row


def _finite(value: float | None) -> float | None:
    return None if value is None or not np.isfinite(value) else float(value)
