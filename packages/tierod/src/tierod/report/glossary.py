"""Glossary of a page: signals, parameters and terms, each explained once at the end of the page and linked."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import Any

from tierod.core.shown import shown
from tierod.core.signals import SIGNALS
from tierod.core.statuses import SEVERITY, Status
from tierod.report.charts.figure import Figure
from tierod.report.display import words
from tierod.vehicles import QUANTITIES

_NIS = (
    "Normalised innovation squared: measured less predicted, squared, over its variance. Its mean is the number of "
    "measurements where the estimator knows its own uncertainty; above it the estimator is overconfident."
)
_ROC = "Chance that a faulty drive has the higher statistic than a fault-free one: 1 separates all of them, 0.5 none."

_STATISTICS = {
    "95 % interval": "The true value lies in it in 95 of 100 cases, if the model holds: 1.96 standard deviations.",
    "95 % interval, half width": "1.96 standard deviations of the estimate.",
    "estimate": "What the estimator has learnt up to each moment.",
    "NIS": _NIS,
    "NIS mean": _NIS,
    "mean NIS": _NIS,
    "normalised innovation": "Measured less predicted, over its own standard deviation. Consistent: mostly within ±2.",
    "degrees of freedom": "Number of measurements that the NIS counts.",
    "enabled": "Time in which the drive excited the quantity, so that the estimator learnt from it.",
    "enabled share": "Share of the drive in which the estimator learnt.",
    "enabled left share": "Share of the enabled time that was driven to the left; half is best.",
    "enabled samples": "Samples from which the estimator learnt.",
    "excitation": "How much the drive excites what is estimated; below its threshold no verdict is given.",
    "balance error": "Part of the torque that the model does not explain.",
    "balance misfit": "Model error of the torque balance over its usual size; large values withhold the verdict.",
    "opposed torques share": "Share of the time in which driver and motor work against each other.",
    "baseline": "Baseline of this car, learnt while it was fault-free.",
    "baseline deviation": "Standard deviation of the baseline.",
    "deviation by torque gains": "Part of the standard deviation that the gains of both torques cause.",
    "deviation without torque gains": "Standard deviation of the estimate for exact gains of both torques.",
    "baseline learnt": "Enabled time from which the baseline was learnt.",
    "ratio to baseline": "Estimate over the baseline of this car.",
    "before the change": "Estimate before the change began.",
    "after the change": "Estimate since the change began.",
    "alarm": "When the statistic passed its threshold.",
    "signals complete share": "Share of the drive in which all recorded input signals were present.",
    "required signals share": "Share of the drive in which all signals that every verdict needs were present.",
    "signals complete until": "Last time at which all recorded input signals were present.",
    "signals present share": "Share of the drive in which all needed signals were present.",
    "vehicle rising limit": "Friction from which this car counts as rising, from its vehicle file.",
    "vehicle fault limit": "Friction from which this car counts as faulty, from its vehicle file.",
    "error against truth RMS": "Root mean square of estimate less truth, known in simulations only.",
    "truth within band share": "Share of the time in which the truth lies in the 95 % band.",
    "residual": "An estimate less a measurement; zero on average where nothing is wrong.",
}

_RULES = {
    "decides": "What is found when this rule alarms.",
    "distance": "The statistic that the rule watches.",
    "stopping rule": "When the rule alarms: how the statistic is accumulated, and its threshold.",
    "false alarms": "Alarms on fault-free drives. In a table of rules: how often the design allows them.",
    "where from": "Source of the threshold: a paper, a design, or measured fault-free drives.",
    "replaced by": "What the monitor supplies in place of the sensor at fault.",
    "missing": "Share of the samples that are missing.",
    "longest gap": "Longest time without a sample.",
}

_CAMPAIGNS = {
    "found": "Faults that raised an alarm, of all that could.",
    "lost": "Drives that diverged, failed or were not judged.",
    "faults found": "Faults that raised an alarm, of all that could; those with an alarm before them do not count.",
    "time to the alarm": "From the beginning of the fault to the first alarm; a fault that is never found is infinite.",
    "the same in enabled time": "The same, counting only time in which the estimator learnt.",
    "estimate less truth": "Mean ± standard deviation of the error of the settled estimates.",
    "area under the ROC curve": _ROC,
    "ROC area": _ROC,
    "judged": "Share of the driven time in which a verdict was possible.",
    "at most": "Upper bound of the rate of false alarms, with 95 % confidence.",
    "bias ± deviation": "Mean ± standard deviation of estimate less truth.",
    "worst": "Largest of all; never, where one fault was not found.",
    "gate": "A pass criterion: a figure of the campaign and the goal that it has to meet.",
    "right in one alone": "Drives on which only one of the two campaigns came to the right verdict.",
    "sign test": "Chance of so uneven a split of increases and decreases if nothing differed.",
    "rank test": "Chance of differences so far to one side if nothing differed (Wilcoxon).",
}

_FLEETS = {
    "level now (± 1 σ)": "Level at 15 °C, estimated from the drives since its last step, ± one standard deviation.",
    "time left (90 %)": "Time until the level reaches the limit, if its trend continues, with its 90 % interval.",
    "cohort": "Cars that share a label: supplier, batch, plant. Named where they differ from the rest of the fleet.",
    "odds that it differs": "Odds that the mean of the cohort differs from the rest, after seeing the drives.",
    "not separated from": "Cohorts of nearly the same cars: the data cannot show which of them differs.",
    "quantities followed": "Series of estimates over drives, one per monitor and quantity.",
    "verdict of the drive": "Verdict of this drive alone; the trend weighs all drives.",
}

TERMS: Mapping[str, str] = _STATISTICS | _RULES | _CAMPAIGNS | _FLEETS  # Explanation of each other term


TIMED = "Drag to zoom, double-click for everything; all charts over time follow, and so does their cursor."
UNTIMED = "Drag to zoom, double-click for everything."


class Glossary:
    """Explanations that a page has requested, in that order.

    Attributes:
        found: name and explanation of each, by its identifier on the page
    """

    def __init__(self) -> None:
        self.found: dict[str, tuple[str, str]] = {}

    def link(self, text: object) -> Any:
        import markupsafe

        known = explanation(str(text))
        return self._word(known, text) if known else markupsafe.escape(text)

    def status(self, text: object) -> Any:
        """The word of a status, as a link to its explanation."""
        import markupsafe

        if text not in SEVERITY:
            return markupsafe.escape(text)
        status = Status(str(text))
        return self._word((words(status), status.meaning), status)

    def chart(self, figure: Figure) -> Any:
        reading = " ".join(filter(None, (figure.caption, figure.reading, TIMED if figure.timed else UNTIMED)))
        looks = f'class="term info" aria-label="How to read: {_attribute(figure.title)}"'
        return self._linked(f"read-{figure.name}", (figure.title, reading), looks, "i")

    def _word(self, known: tuple[str, str], text: object) -> Any:
        """A link; only the first occurrence of a word is in the tab order of the keyboard."""
        identifier = f"word-{_slug(known[0])}"
        return self._linked(identifier, known, 'class="term"' + ' tabindex="-1"' * (identifier in self.found), text)

    def _linked(self, identifier: str, known: tuple[str, str], looks: str, text: object) -> Any:
        import markupsafe

        self.found.setdefault(identifier, known)
        name = _attribute(identifier)
        return markupsafe.Markup(f'<a href="#{name}" aria-describedby="{name}" {looks}>{markupsafe.escape(text)}</a>')


def explanation(text: str) -> tuple[str, str] | None:
    """(name, explanation) of a signal, a parameter or a term; None for an unknown text."""
    return _known().get(re.sub(r"\s*\[[^]]*\]$", "", text).strip().lower())


@cache
def _known() -> dict[str, tuple[str, str]]:
    found = {}
    for quantity in QUANTITIES.values():
        meaning = quantity.meaning[:1].upper() + quantity.meaning[1:]
        found[words(quantity.name).lower()] = (words(quantity.name), f"{meaning}.")
    for signal in SIGNALS.values():
        label = shown(signal.unit)[1]
        sentences = [signal.meaning, *([f"Positive: {signal.positive}."] if signal.positive else [])]
        sentences += [f"Shown in {label}."] if label else []
        found[words(signal.name).lower()] = (words(signal.name), " ".join(sentences))
    for name, meaning in TERMS.items():
        found[name.lower()] = (words(name), meaning)
    return found


def _slug(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")


def _attribute(text: str) -> str:
    import markupsafe

    return str(markupsafe.escape(text))
