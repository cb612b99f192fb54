"""Calibration of the thresholds of the condition monitor from fault-free driving."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from tierod.core.content import Table
from tierod.core.errors import ParameterError
from tierod.core.recording import Recording
from tierod.monitors.condition.calibration import ConditionCalibration, calibrate_condition, calibrate_motion
from tierod.monitors.condition.signals import ConditionSample
from tierod.monitors.condition.structure import rolls
from tierod.report.display import number
from tierod.report.identification import Subject, found_table
from tierod.vehicles import Vehicle


def _thresholds(
    car: Vehicle,
    recordings: dict[str, Recording],
    free: tuple[str, ...],
    advance: Callable[[float], None],
    hours: float = 1000.0,
) -> ConditionCalibration:
    if free:
        raise ParameterError("thresholds are found with all parameters that fault-free driving shows; leave --free out")
    if rolls(car):
        return calibrate_motion(recordings, car, hours, advance)
    return calibrate_condition(recordings, car, hours, advance)


def _thresholds_signals() -> tuple[str, ...]:
    return tuple(ConditionSample._fields)


def _thresholds_items(result: ConditionCalibration) -> Sequence[Table]:
    limits = result.designed.limits
    pairs = zip(result.explanations[1:], limits.fast, limits.slow, strict=True)
    rows = tuple(
        (each.name.replace("_", " "), number(fast, 3), number(slow, 3))
        for each, fast, slow in pairs
        if len(each.suspects) == 1
    )
    note = "Mean log-likelihood ratio per sample, over 0.05 and 0.5 s, beyond which a fault is declared."
    found = [found_table(result.found)] if result.found else []
    return [*found, Table("Limits", ("suspect", "over 0.05 s", "over 0.5 s"), rows, note)]


def _thresholds_document(result: ConditionCalibration) -> dict[str, Any]:
    return {"thresholds": result.thresholds, "converged": result.converged, "explained": not result.doubt}


THRESHOLDS = Subject(
    "Thresholds",
    "Maximum-likelihood parameters of an automated vehicle for the filter of all its sensors in fault-free driving, "
    "from the first five minutes; limits of the condition monitor from all driving after them, for a wanted mean "
    "time between false alarms. Of a car that is judged by its motion alone: limits from all its driving.",
    _thresholds,
    _thresholds_items,
    _thresholds_document,
    takes_false_alarms=True,
    signals=_thresholds_signals,
)
