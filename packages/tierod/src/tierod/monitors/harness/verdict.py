"""Parts of findings that all monitors share: a withheld verdict, and the statistics of innovations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from tierod.core.findings import Estimate, Finding, Status
from tierod.methods.analysis.consistency import Consistency


class Obstacle(NamedTuple):
    """A reason to withhold a verdict.

    Args:
        status: status of the finding
        cause: cause, as half a sentence
        action: remedy
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
    """Finding without a verdict, with all reasons.

    Args:
        monitor: name of monitor and variant
        subject: monitored element, with a capital letter, as the beginning of the headline
        obstacles: reasons, at least one, the decisive one first
        evidence: figures that are known nevertheless
        warnings: warnings of the finding
        estimate: estimate to be shown nevertheless; None if it means nothing
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
    """Statistics of the innovations for a report: mean NIS, and its band for a consistent filter.

    Args:
        found: consistency over the enabled samples of a drive
        wide: whether the filter uses a larger variance on purpose, so that the band does not apply
    """
    figures = {"enabled_samples": float(found.samples), "nis_mean": found.nis}
    if wide:
        return figures
    low, high = found.nis_band
    return figures | {"nis_band_low": low, "nis_band_high": high, "nis_outside_95_share": found.outside}
