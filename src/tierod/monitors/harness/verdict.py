"""Findings in the form that all monitors share: withheld for a reason, or doubted for defects of the inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from tierod.core.findings import Estimate, Finding, Status
from tierod.methods.analysis.consistency import Consistency


class Obstacle(NamedTuple):
    """A reason to withhold a verdict.

    Args:
        status: that it gives
        cause: half a sentence
        action: the remedy
    """

    status: Status
    cause: str
    action: str


def withheld(
    monitor: str,
    subject: str,
    obstacles: Sequence[Obstacle],
    evidence: Mapping[str, float],
    warnings: tuple[str, ...] = (),
    estimate: Estimate | None = None,
) -> Finding:
    """The finding without a verdict, with every reason.

    Args:
        monitor: name of monitor and variant
        subject: watched element, with a capital letter: begins the headline
        obstacles: at least one, the decisive one first
        evidence: figures that are known all the same
        warnings: beside it
        estimate: that is shown all the same; None where it means nothing
    """
    decisive = obstacles[0]
    return Finding(
        monitor,
        decisive.status,
        f"{subject}: {decisive.status.value}; {decisive.cause}.",
        estimate=estimate,
        evidence=dict(evidence),
        cause="; ".join(each.cause for each in obstacles),
        action="; ".join(dict.fromkeys(each.action for each in obstacles)),
        warnings=warnings,
    )


def nis_figures(found: Consistency, wide: bool = False) -> dict[str, float]:
    """Figures of the innovations for a report.

    Args:
        found: over the enabled samples of a drive
        wide: whether the filter sets its variance wide on purpose, so that the band of a consistent filter is left out
    """
    figures = {"enabled_samples": float(found.samples), "nis_mean": found.nis}
    if wide:
        return figures
    low, high = found.nis_band
    return figures | {"nis_band_low": low, "nis_band_high": high, "nis_outside_95_share": found.outside}
