"""Rows of uncertain parameters, ordered by their effect on the result; for terminal and page."""

from __future__ import annotations

from tierod.core.findings import Diagnosis, ParameterEffect
from tierod.core.shown import shown, written
from tierod.monitors.harness.spread.advice import first_to_measure
from tierod.report.display import number, share

COLUMNS = ("parameter", "value", "moves the result by", "share of what parameters add")

HEADING = "Which parameters decide"


def effect_rows(diagnosis: Diagnosis) -> list[tuple[str, str, str, str]]:
    """Cells of `COLUMNS` for every uncertain parameter that affects the result, the largest effect first.

    Args:
        diagnosis: with the effects of its parameters
    """
    return [(each.name, _value(each), _effect(each), share(each.share)) for each in diagnosis.parameter_effects]


def measure_first(diagnosis: Diagnosis) -> str:
    """Recommendation of the parameter to measure first; "" where none affects the result.

    Args:
        diagnosis: with the effects of its parameters
    """
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
