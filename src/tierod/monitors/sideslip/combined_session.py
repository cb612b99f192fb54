"""The combined estimator over one recording: beside the sideslip, what the drive tells of car, road and limit."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from tierod.core.findings import Finding, Status
from tierod.core.graph import Result
from tierod.monitors.harness.session import Conclusion
from tierod.monitors.sideslip.combined import CombinedSideslip
from tierod.monitors.sideslip.combined_identifiability import WORDS, identifiability
from tierod.monitors.sideslip.decisions import MOST_RESTARTS
from tierod.monitors.sideslip.session import OFFSET, SideslipSession
from tierod.vehicles import Vehicle


class CombinedSession(SideslipSession):
    """A `SideslipSession` that also tells what the drive tells of stiffness, bank and wind, and of the limit of grip.

    Args:
        estimator: the combined one
        vehicle: whose parameters it has
        rate: of the samples [Hz]
        name: of monitor and variant
        more: further outputs shown over time: output -> (name in the report, unit)
    """

    def __init__(
        self,
        estimator: CombinedSideslip,
        vehicle: Vehicle,
        rate: float,
        name: str,
        more: Mapping[str, tuple[str, str]] | None = None,
    ):
        super().__init__(estimator, vehicle, rate, name, more)
        self._estimator, self.most_restarts = estimator, MOST_RESTARTS
        self._restarts, self._ahead, self._used = 0, 0, 0.0
        self._first_ahead: float | None = None

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Beside what every sideslip session collects: new starts, and when the limit was announced."""
        super().collect(time, signals, result)
        ahead = result["limit_ahead"] > 0.5
        self._restarts += int(np.sum(result["restarted"] > 0.5))
        self._ahead += int(np.sum(ahead))
        self._used = max(self._used, float(np.max(result["front_friction_used"], initial=0.0)))
        if self._first_ahead is None and ahead.any():
            self._first_ahead = float(time[np.argmax(ahead)])

    def conclude(self) -> Conclusion:
        """The finding, with shares of what was identified, the limit, and new starts."""
        conclusion = super().conclude()
        finding = conclusion.finding
        if finding.status not in (Status.HEALTHY, Status.SUSPECT, Status.NOT_IDENTIFIABLE) or self._memory is None:
            return conclusion
        told = identifiability(self._estimator, self._memory)
        evidence = dict(finding.evidence) | {
            f"{WORDS[name]}, identified share": share for name, share in told.shares.items()
        }
        evidence |= {
            "largest_front_friction_used": self._used,
            "limit_announced_s": self._ahead / self.rate,
            "restarts": float(self._restarts),
        }
        if self._first_ahead is not None:
            evidence["limit_first_announced_at_s"] = self._first_ahead
        finding = self._judged(dataclasses.replace(finding, evidence=evidence))
        return dataclasses.replace(conclusion, finding=finding, remarks={"estimate": str(told)})

    def _judged(self, finding: Finding) -> Finding:
        """The finding with the limit in its headline; not identifiable where the filter had to start anew too often."""
        minutes = finding.evidence["enabled_s"] / 60.0
        if finding.status is not Status.NOT_IDENTIFIABLE and self._restarts > max(self.most_restarts * minutes, 1.0):
            cause = f"the filter was lost and started anew {self._restarts} times"
            if OFFSET in finding.evidence:
                return dataclasses.replace(
                    finding, status=Status.NOT_IDENTIFIABLE, headline=f"{finding.headline} With it, {cause}."
                )
            return dataclasses.replace(
                finding,
                status=Status.NOT_IDENTIFIABLE,
                headline=f"{finding.headline} But signals or parameters do not fit this car: {cause}.",
                cause=f"{finding.cause}; {cause}" if finding.cause else cause,
                action="check scale, unit and delay of yaw rate, lateral acceleration and speed in the channel map; "
                "where they are right, give a vehicle file that fits: mass, stiffness, friction and noises of "
                "the sensors",
            )
        if self._first_ahead is None:
            return finding
        announced = f"The front axle came near its greatest force, announced from {self._first_ahead:.1f} s on"
        return dataclasses.replace(finding, headline=f"{finding.headline} {announced}.")
