"""Design a detector: threshold from the false alarms one can bear and the shift that must be found."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tierod.errors import InputError, ParameterError, nearest

if TYPE_CHECKING:
    import numpy as np

    from tierod.report.detector.tables import Wish

SUBJECTS = ("detector",)
_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
_ALARMS = re.compile(r"\s*([\d.eE+-]+)\s*per\s*([\d.eE+-]*)\s*([a-z]+)\s*")


def design(
    subject: Annotated[str, typer.Argument(help="What to design: detector.")],
    false_alarms: Annotated[str, typer.Option(help='False alarms that one can bear: "1 per 10000 h".')],
    shift: Annotated[float, typer.Option(help="Shift of the residual's mean that must be found, in its unit.")],
    rate: Annotated[float, typer.Option(help="Residuals per second [Hz].")],
    sigma: Annotated[
        float | None, typer.Option(help="Standard deviation of the residual, in its unit; not with --residual.")
    ] = None,
    rule: Annotated[
        str | None, typer.Option(help="cusum, average, sequential, hold, threshold; all where not given.")
    ] = None,
    sides: Annotated[str, typer.Option(help="both, upper (increases only) or lower.")] = "both",
    residual: Annotated[
        list[Path] | None,
        typer.Option(help="Recording with a healthy residual of any colour: the threshold is measured on it."),
    ] = None,
    signal: Annotated[str | None, typer.Option(help="Name of the residual in the recording.")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Where the HTML page goes; none is written where not given.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")] = False,
) -> int:
    """Design a stopping rule: threshold, expected delay, and the curve of delay against false alarms."""
    from tierod.detectors.comparison import RULES
    from tierod.report.detector.tables import Wish

    if subject not in SUBJECTS:
        raise ParameterError(f"'{subject}' cannot be designed{nearest(subject, SUBJECTS)}")
    if rule is not None and rule not in RULES:
        raise ParameterError(f"there is no rule '{rule}'{nearest(rule, RULES)}")
    for name, value in (("--shift", shift), ("--rate", rate), ("--sigma", 1.0 if sigma is None else sigma)):
        if not 0.0 < value < float("inf"):
            raise ParameterError(f"{name} is {value:g}; expected a number greater than zero")
    if (sigma is None) == (not residual):
        raise ParameterError("give either --sigma of a white residual, or a healthy --residual to measure on")
    interval = seconds_between(false_alarms)
    if residual:
        items, document = _measured(Wish(0.0, shift, interval, rate, sides), rule, residual, signal)
    else:
        assert sigma is not None
        items, document = _designed(Wish(sigma, shift, interval, rate, sides), rule)
    _show(items, {"schema": "tierod.detector/1", **document}, output, as_json)
    return 0


def seconds_between(text: str) -> float:
    """Time between false alarms [s] of "1 per 10000 h".

    Raises:
        ParameterError: it does not say how many per which time
    """
    found = _ALARMS.fullmatch(text)
    try:
        if not found or found[3] not in _SECONDS:
            raise ValueError
        count, time = float(found[1]), float(found[2] or 1.0) * _SECONDS[found[3]]
        if not (count > 0.0 and time > 0.0):
            raise ValueError
    except ValueError:
        raise ParameterError(f"--false-alarms is '{text}'; expected a number per time: \"1 per 10000 h\"") from None
    return time / count


def _designed(wish: Wish, rule: str | None) -> tuple[list[Any], dict[str, Any]]:
    from tierod.detectors.comparison import RULES, designed
    from tierod.report.detector.tables import of_rules

    change = wish.shift / wish.deviation
    found = {name: designed(name, change, wish.samples, wish.sides) for name in ([rule] if rule else RULES)}
    rows = [
        {
            "rule": name,
            "constant": each.rule.name,
            "threshold": each.threshold * (1.0 if name == "sequential" else wish.deviation),
            "delay_s": each.delay / wish.rate,
            "seconds_between_false_alarms": wish.interval,
        }
        for name, each in found.items()
    ]
    return of_rules(wish, found), {"rules": rows}


def _measured(wish: Wish, rule: str | None, paths: list[Path], signal: str | None) -> tuple[list[Any], dict[str, Any]]:
    from dataclasses import replace

    import numpy as np

    from tierod.detectors.comparison import designed
    from tierod.detectors.delays import delays_of
    from tierod.detectors.measured import threshold_from_records
    from tierod.report.detector.tables import of_measurement

    records = [_residual(path, signal, wish.rate) for path in paths]
    whole = np.concatenate(records)
    deviation = float(np.sqrt(np.nanmean(whole**2))) if np.isfinite(whole).any() else 0.0
    if not deviation > 0.0:
        raise InputError("the healthy residual is zero or missing throughout; check --signal")
    chosen = designed(rule or "cusum", wish.shift / deviation, wish.samples, wish.sides).rule
    found = threshold_from_records(chosen, records, wish.samples)
    block = chosen.block(found.threshold, deviation)
    delays = delays_of(block, records, -wish.shift if wish.sides == "lower" else wish.shift) / wish.rate
    document = {
        "rule": chosen.name,
        "threshold": found.threshold * (1.0 if rule == "sequential" else deviation),
        "deviation": deviation,
        "seconds_between_false_alarms": wish.interval,
        "interval_s": [found.low / wish.rate, found.high / wish.rate],
        "extrapolated": found.extrapolated,
        "claim": found.claim(wish.rate),
        "delay_median_s": _finite(float(np.quantile(delays, 0.5))),
        "delay_p95_s": _finite(float(np.quantile(delays, 0.95))),
    }
    return of_measurement(replace(wish, deviation=deviation), found, delays.tolist()), document


def _finite(value: float) -> float | None:
    return value if value < float("inf") else None


def _residual(path: Path, signal: str | None, rate: float) -> np.ndarray:
    from tierod.readers import read

    recording = read(path)
    if signal is None and len(recording.names) == 1:
        signal = recording.names[0]
    if signal is None or signal not in recording:
        given = "no --signal is given" if signal is None else f"{path} has no signal '{signal}'"
        raise InputError(f"{given}{nearest(signal or '', recording.names)}")
    channel = recording[signal]
    span = channel.time[-1] - channel.time[0]
    own = (len(channel.time) - 1) / span if span > 0.0 else 0.0
    if not 0.9 * rate <= own <= 1.1 * rate:
        raise InputError(f"{signal} in {path} comes at {own:.4g} Hz, not at the {rate:g} Hz given as --rate")
    return channel.values


def _show(items: list[Any], document: dict[str, Any], output: Path | None, as_json: bool) -> None:
    from tierod.cli.terminal import messages, print_json, rows
    from tierod.cli.terminal import output as console
    from tierod.studies.content import Table

    if output is not None:
        _write(items, output)
    if as_json:
        print_json(document)
    else:
        for item in items:
            if isinstance(item, Table):
                console().print(f"[bold]{item.title}[/bold]")
                console().print(rows(item.header, item.rows))
                console().print(item.note)
    if output is not None:
        (messages() if as_json else console()).print(f"page: {output}", soft_wrap=True, markup=False)


def _write(items: list[Any], path: Path) -> None:
    import shlex
    import sys
    from datetime import UTC, datetime

    from tierod import __version__
    from tierod.files import write_text
    from tierod.report.study_page import StudyPage, render_study

    page = StudyPage(
        "detector",
        "Design of a detector",
        "Stopping rules from the false alarms one can bear and the shift that must be found.",
        {},
        items,
        datetime.now(UTC).isoformat(timespec="seconds"),
        __version__,
        shlex.join(["tierod", *sys.argv[1:]]),
    )
    write_text(path, render_study(page))
