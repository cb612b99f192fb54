"""Design of a detector, for terminal, page and JSON document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from tierod.core.content import Chart, Table
from tierod.core.errors import InputError
from tierod.methods.detectors.measured import threshold_from_records
from tierod.methods.detectors.rule_design import RULES, delays_of, designed
from tierod.methods.detectors.stopping_rules import LikelihoodRatioRule, StoppingRule
from tierod.report.analysis.analysis import Analysis
from tierod.report.analysis.detector_tables import (
    Wish,
    against_false_alarms,
    against_shift,
    measurement,
    rules_beside,
    time_in_words,
)

LIKELIHOOD_RATIO = "likelihood-ratio"
"""Rule whose run length can only be measured."""

ALL_RULES = (*RULES, LIKELIHOOD_RATIO)
"""Names of all rules, as given by the user."""

SIMULATED = 2_000_000
"""Number of simulated white residuals, used where a rule must be measured and no residuals are given."""


@dataclass(frozen=True)
class Measured:
    """Residuals on which a threshold is measured.

    Args:
        records: (n,) per recording [unit of the residual]; NaN where missing
        label: description of the residuals
        simulated: whether the residuals are simulated
    """

    records: Sequence[np.ndarray]
    label: str
    simulated: bool = False

    @property
    def deviation(self) -> Annotated[float, "unit of the signal"]:
        """Root mean square of all finite residuals; zero where there are none."""
        whole = np.concatenate(self.records)
        return float(np.sqrt(np.nanmean(whole**2))) if np.isfinite(whole).any() else 0.0


def drawn(deviation: float, seed: int = 0) -> Measured:
    """Simulated white Gaussian residuals with a given standard deviation."""
    residual = deviation * np.random.default_rng(seed).normal(size=SIMULATED)
    return Measured([residual], f"{SIMULATED / 1e6:g} million white residuals, simulated", True)


def of_white(wish: Wish, rule: str | None = None) -> Analysis:
    """Calculated thresholds for white residuals."""
    change = wish.shift / wish.deviation
    found = {name: designed(name, change, wish.samples, wish.sides) for name in ([rule] if rule else RULES)}
    best = min(found.values(), key=lambda each: each.delay)
    summary = (
        f"For white Gaussian residuals of standard deviation {wish.deviation:g}, with {time_in_words(wish.interval)} "
        f"between false alarms, a shift of {wish.shift:g} is detected soonest by: {best.rule.name}, threshold "
        f"{best.threshold * best.rule.scale(wish.deviation):.4g}, after {time_in_words(best.delay / wish.rate)} on "
        "average.",
        "Autocorrelated residuals cause far more false alarms; for them, measure the threshold on a fault-free "
        "recording (--residual).",
    )
    rows = [
        {
            "rule": name,
            "constant": each.rule.name,
            "threshold": each.threshold * each.rule.scale(wish.deviation),
            "delay_s": each.delay / wish.rate,
            "seconds_between_false_alarms": wish.interval,
        }
        for name, each in found.items()
    ]
    items: list[Table | Chart] = [
        rules_beside(wish, found),
        against_false_alarms(wish, found),
        against_shift(wish, found),
    ]
    return Analysis("Design of a detector", summary, items, {"rules": rows})


def of_measured(wish: Wish, rule: str | None, given: Measured) -> Analysis:
    """Threshold measured on fault-free residuals, which may be autocorrelated."""
    deviation = given.deviation
    if not deviation > 0.0:
        raise InputError("the fault-free residual is zero or missing throughout; check --signal")
    wish = replace(wish, deviation=deviation)
    chosen = _chosen(rule or "cusum", wish)
    found = threshold_from_records(chosen, given.records, wish.samples)
    block = chosen.block(found.threshold, deviation)
    shift = -wish.shift if wish.sides == "lower" else wish.shift
    delays = delays_of(block, given.records, shift) / wish.rate
    document: dict[str, Any] = {
        "rule": chosen.name,
        "threshold": found.threshold * chosen.scale(deviation),
        "deviation": deviation,
        "seconds_between_false_alarms": wish.interval,
        "interval_s": [found.low / wish.rate, found.high / wish.rate],
        "extrapolated": found.extrapolated,
        "simulated": given.simulated,
        "claim": found.claim(wish.rate),
        "delay_median_s": float(np.quantile(delays, 0.5, method="higher")),
        "delay_p95_s": float(np.quantile(delays, 0.95, method="higher")),
    }
    summary = (
        f"Threshold {document['threshold']:.4g} of the {chosen.name}, measured on {given.label}. Time between false "
        f"alarms: {found.claim(wish.rate)}.",
    )
    remarks = (
        ("White residuals were simulated; real ones are autocorrelated and cause more false alarms.",)
        if given.simulated
        else ()
    )
    return Analysis("Design of a detector", summary, measurement(wish, found, delays.tolist()), document, remarks)


def _chosen(rule: str, wish: Wish) -> StoppingRule:
    if rule == LIKELIHOOD_RATIO:
        return LikelihoodRatioRule(sides=wish.sides)
    return designed(rule, wish.shift / wish.deviation, wish.samples, wish.sides).rule
