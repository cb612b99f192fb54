"""Parts of findings that all monitors share: a withheld verdict, and the statistics of innovations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from tierod.core.facts import Fact, Verdict, shortened
from tierod.core.findings import Estimate, Status
from tierod.methods.analysis.consistency import Consistency


class Obstacle(NamedTuple):
    """A reason to withhold a verdict: status, cause as half a sentence, remedy, and the cause in a few words."""

    status: Status
    cause: str
    action: str
    reason: str = ""


def withheld(
    monitor: str,
    obstacles: Sequence[Obstacle],
    evidence: Mapping[str, float],
    warnings: tuple[str, ...] = (),
    estimate: Estimate | None = None,
) -> Verdict:
    """No verdict, with all reasons.

    Args:
        monitor: name of monitor and variant
        obstacles: reasons, at least one, the decisive one first
        evidence: figures that are known nevertheless
        warnings: further notes
        estimate: estimate to be shown nevertheless; None if it means nothing
    """
    because = (Fact("obstacle", each.cause, each.reason or shortened(each.cause), each.action) for each in obstacles)
    notes = tuple(Fact("note", each) for each in warnings)
    return Verdict(monitor, obstacles[0].status, tuple(because), estimate, evidence=dict(evidence), facts=notes)


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
