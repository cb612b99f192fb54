"""Design a detector: threshold from the permitted false alarms and the shift that must be detected."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tierod.core.errors import InputError, ParameterError, nearest

if TYPE_CHECKING:
    import numpy as np

    from tierod.report.detector import Wish
    from tierod.report.html import Analysis

SUBJECTS = ("detector",)
_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
_ALARMS = re.compile(r"\s*([\d.eE+-]+)\s*per\s*([\d.eE+-]*)\s*([a-z]+)\s*")


def design(
    subject: Annotated[str, typer.Argument(help="What to design: detector.")],
    false_alarms: Annotated[str, typer.Option(help='Accepted rate of false alarms: "1 per 10000 h".')],
    shift: Annotated[float, typer.Option(help="Shift of the mean residual that must be detected, in its unit.")],
    rate: Annotated[float, typer.Option(help="Rate of the residuals in Hz.")],
    sigma: Annotated[
        float | None, typer.Option(help="Standard deviation of the residual, in its unit; not with --residual.")
    ] = None,
    rule: Annotated[
        str | None,
        typer.Option(help="cusum, hold or threshold. Where not given: all with --sigma, cusum with --residual."),
    ] = None,
    sides: Annotated[str, typer.Option(help="both, upper (increases only) or lower.")] = "both",
    residual: Annotated[
        list[Path] | None,
        typer.Option(help="Recording with a fault-free residual, white or not, on which the threshold is measured."),
    ] = None,
    signal: Annotated[str | None, typer.Option(help="Name of the residual in the recording.")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="HTML page to write; none if not given.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")] = False,
) -> int:
    """Design a stopping rule: threshold, expected detection delay, and the curve of delay against false alarms."""
    from tierod.cli.terminal import present, refuse_to_overwrite
    from tierod.report.detector import Wish

    if subject not in SUBJECTS:
        raise ParameterError(f"'{subject}' cannot be designed{nearest(subject, SUBJECTS)}")
    for name, value in (("--shift", shift), ("--rate", rate), ("--sigma", 1.0 if sigma is None else sigma)):
        if not 0.0 < value < float("inf"):
            raise ParameterError(f"{name} is {value:g}; expected a number greater than zero")
    if (sigma is None) == (not residual):
        raise ParameterError("give either --sigma of a white residual, or --residual with a fault-free recording")
    if signal is not None and not residual:
        raise ParameterError("--signal goes with --residual; leave it out")
    refuse_to_overwrite(output, residual or [])
    wish = Wish(sigma or 1.0, shift, seconds_between(false_alarms), rate, sides)
    found, facts = _found(wish, rule, residual or [], signal)
    present(found, {"schema": "tierod.detector/1", **found.document}, as_json, output, facts, kind="design")
    return 0


def seconds_between(text: str) -> float:
    """Mean time between false alarms [s] from a text such as "1 per 10000 h"."""
    found = _ALARMS.fullmatch(text)
    try:
        if not found or found[3] not in _SECONDS:
            raise ValueError
        count, time = float(found[1]), float(found[2] or 1.0) * _SECONDS[found[3]]
        if not (count > 0.0 and time > 0.0):
            raise ValueError
    except ValueError:
        raise ParameterError(
            f"--false-alarms is '{text}'; expected a number per time in s, min, h or d: \"1 per 10000 h\""
        ) from None
    return time / count


def _found(
    wish: Wish, rule: str | None, paths: list[Path], signal: str | None
) -> tuple[Analysis, list[tuple[str, str]]]:
    from tierod.methods.detectors.rule_design import RULES
    from tierod.report.detector import Measured, of_measured, of_white

    if rule is not None and rule not in RULES:
        raise ParameterError(f"there is no rule '{rule}'{nearest(rule, RULES)}")
    if not paths:
        return of_white(wish, rule), _facts(wish, f"white, standard deviation {wish.deviation:g}")
    records = [_residual(path, signal, wish.rate) for path in paths]
    given = Measured(records, f"{signal or 'the only signal'} of {', '.join(path.name for path in paths)}")
    return of_measured(wish, rule, given), _facts(wish, given.label)


def _facts(wish: Wish, residual: str) -> list[tuple[str, str]]:
    from tierod.report.detector import time_in_words

    sides = {"both": "increases and decreases", "upper": "increases", "lower": "decreases"}
    return [
        ("residual", residual),
        ("rate", f"{wish.rate:g} Hz"),
        ("between false alarms", time_in_words(wish.interval)),
        ("shift to be found", f"{wish.shift:g}"),
        ("watched for", sides[wish.sides]),
    ]


def _residual(path: Path, signal: str | None, rate: float) -> np.ndarray:
    from tierod.io.readers import read

    recording = read(path)
    if signal is None and len(recording.names) == 1:
        signal = recording.names[0]
    if signal is None or signal not in recording:
        given = "no --signal is given" if signal is None else f"{path} has no signal '{signal}'"
        raise InputError(f"{given}{nearest(signal or '', recording.names)}")
    channel = recording[signal]
    span = channel.time[-1] - channel.time[0] if len(channel.time) else 0.0
    own = (len(channel.time) - 1) / span if span > 0.0 else 0.0
    if not 0.9 * rate <= own <= 1.1 * rate:
        raise InputError(f"{signal} in {path} has {own:.4g} Hz, not the {rate:g} Hz given as --rate")
    return channel.values
