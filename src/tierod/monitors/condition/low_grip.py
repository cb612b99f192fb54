"""Tyres that slide: a filter that hardly believes the forces of the axles, and whether it explains most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

from tierod.graph.maths import both, either, exp, limit, maximum, where
from tierod.monitors.condition.lane import LeaveOutFilter

FORCE, FORCE_SHARE, TIE_ROD_SHARE = 250.0, 0.6, 0.3
"""Lasting error of an axle's force where its tyres may slide, at small force [N], and its growth with the force; growth
of that of the tie rod. Ice takes most of the force that the tyres have on a dry road, and most of their trail."""
LARGEST_FORCE_ERROR = 4000.0
"""Beyond which no error of an axle's force goes there: more than an axle gives on a dry road [N]."""


class LowGripState(NamedTuple):
    """What is remembered.

    Args:
        lead: mean log-likelihood ratio of the filter of sliding tyres against the best other one
        left: samples for which tyres still count as sliding
    """

    lead: Any
    left: Any


@dataclass(frozen=True)
class LowGrip:
    """Whether tyres slide now, by the filter of `sliding`.

    They do where it explains the readings of all sensors better than any filter that leaves one out, and an axle has
    far less force in a bend than its tyres' slip would give it on a dry road. A fault of a sensor lets sensors
    contradict each other, which weak tyres do not explain; a lost drive takes no force from an axle.

    Args:
        leads: by how much it must explain the readings better [nat per sample]; to leave one reading out costs 4 to 9
        lacks: force that an axle must lack, over its load
        time: constant of the mean
        stays: so long they slide after they did: the filters have to find back
        largest: ratio of a single sample that counts
    """

    leads: Annotated[float, ""] = 3.0
    lacks: Annotated[float, ""] = 0.15
    time: Annotated[float, "s"] = 0.05
    stays: Annotated[float, "s"] = 0.5
    largest: Annotated[float, ""] = 20.0

    def init(self) -> LowGripState:
        """The tyres grip."""
        return LowGripState(0.0, 0.0)

    def after(
        self, state: LowGripState, likelihood: Any, others: Sequence[Any], lack: Any, sample_time: float
    ) -> tuple[LowGripState, Any]:
        """One sample on; whether tyres slide.

        Args:
            state: after the sample before
            likelihood: logarithm of the density of this sample where tyres slide
            others: likewise, of all hypotheses that believe the tyres
            lack: see `LeaveOutFilter.Output`
            sample_time: [s]
        """
        best = others[0]
        for value in others[1:]:
            best = maximum(best, value)
        ratio = limit(likelihood - best, -self.largest, self.largest)
        lead = state.lead + (1.0 - exp(-sample_time / self.time)) * (ratio - state.lead)
        slides = both(lead > self.leads, lack > self.lacks)
        left = where(slides, self.stays / sample_time, maximum(state.left - 1.0, 0.0))
        return LowGripState(lead, left), either(slides, left > 0.5)


def sliding(base: LeaveOutFilter) -> LeaveOutFilter:
    """The filter that believes all sensors, and hardly the forces of the axles.

    Args:
        base: the filter that suspects nobody
    """
    error = replace(base.model_error, force=FORCE, force_share=FORCE_SHARE, tie_rod_share=TIE_ROD_SHARE)
    return replace(base, model_error=error, largest_force_error=LARGEST_FORCE_ERROR)
