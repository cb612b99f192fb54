"""The baseline monitor over one recording: windows of variance, and a verdict where the threshold is given."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tierod.core.facts import Fact, Verdict
from tierod.core.findings import Estimate
from tierod.core.graph import Result
from tierod.core.series import Stride
from tierod.core.statuses import Status
from tierod.methods.detectors.control_charts import HeldThreshold
from tierod.methods.detectors.rule_design import alarms_at
from tierod.monitors.decision import Decision, Demonstrated
from tierod.monitors.friction.evidence import EstimateOverDrive
from tierod.monitors.session import BlockSession, Conclusion, tuning_rows
from tierod_lab.papers.friction.variance_method import VarianceFrictionMonitor

VARIANCE_DECISIONS = (
    Decision(
        name="fault, variance of two torques",
        distance="median variance of the later half of the windows, over `baseline_variance` of the vehicle file",
        rule=HeldThreshold(1.0, 1, "upper"),
        place="block.alarm",
        mean_time_between_false_alarms=None,
        demonstrated=Demonstrated(24.0),
        source="baseline_variance is the 99 % quantile over the windows of healthy drives; demonstrated without the "
        "gate, whose conditions held too rarely for a verdict in any of these drives",
        unit="recording",
        statistic="variance",
        level="threshold",
    ),
)
"""Decision of the baseline method of the paper."""

QUANTITY = "variance between two self-aligning torques about the kingpins"

NEEDED_WINDOWS = 4  # Least number of windows for a verdict: a single one may contain a single manoeuvre


class VarianceSession(BlockSession):
    """Run the baseline monitor over a recording and collect the variance of every full window."""

    def __init__(self, name: str, block: VarianceFrictionMonitor, rate: float):
        traces = {
            "variance": ("variance", "N**2*m**2"),
            "external_torque": ("self_aligning_torque_from_motion", "N*m"),
            "internal_torque": ("self_aligning_torque_from_column", "N*m"),
            "enabled": ("enabled", ""),
        }
        super().__init__(block, traces)
        self.monitor, self.name, self.threshold = block, name, block.threshold
        self._window = block.block_samples * block.blocks
        self._window_seconds = self._window / rate
        self._spread = EstimateOverDrive(rate)
        self._stride, self._seen = Stride(self._window), 0
        self._enabled = 0
        self._times: list[np.ndarray] = []
        self._variances: list[np.ndarray] = []

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        ready = result["ready"] > 0.5
        self._spread.add(time, result["variance"], ready)
        chosen = self._stride.indices(len(time))
        self._seen += len(time)
        self._enabled += int(np.count_nonzero(result["enabled"] > 0.5))
        chosen = chosen[ready[chosen]]
        self._times.append(time[chosen])
        self._variances.append(result["variance"][chosen])

    def conclude(self) -> Conclusion:
        variances = np.concatenate(self._variances or [np.empty(0)])
        share = self._enabled / max(self._seen, 1)
        evidence = {"windows": float(len(variances)), "enabled_share": share}
        verdict = self._withheld(len(variances), evidence) or self._judged(variances, evidence)
        known = verdict.estimate is not None
        return Conclusion(
            verdict,
            self._spread.histograms(verdict.since) if known else {},
            parameters=tuple(tuning_rows(self.block)),
        )

    def _withheld(self, windows: int, evidence: dict[str, float]) -> Verdict | None:
        if windows >= NEEDED_WINDOWS and math.isfinite(self.threshold):
            return None
        if windows < NEEDED_WINDOWS:
            status = Status.NOT_ENABLED if not windows else Status.NOT_READY
            cause = (
                f"its enabling conditions held for {evidence['enabled_share']:.1%} of the drive: {windows} full "
                f"windows, {NEEDED_WINDOWS} are needed"
            )
            action = "record a longer drive with more curves, or use the variant 'pre-sliding'"
        else:
            status, cause = Status.NOT_TESTABLE, "the vehicle file gives no threshold for the variance"
            action = "determine baseline_variance from healthy drives of this car, or use the variant 'pre-sliding'"
        return Verdict(self.name, status, (Fact("obstacle", cause, action=action),), evidence=evidence)

    def _judged(self, variances: np.ndarray, evidence: dict[str, float]) -> Verdict:
        later = variances[len(variances) // 2 :]
        median = float(np.median(later))
        above = variances > self.threshold
        evidence |= {"windows_above_share": float(np.mean(above))}
        fault = alarms_at(self.monitor.alarm, median / self.threshold)
        status = Status.FAULT if fault else Status.HEALTHY
        since = self._began(above) if fault else None
        # Standard error of a median of Gaussian values: sqrt(pi / 2) times that of their mean.
        deviation = float(1.2533 * np.std(later) / math.sqrt(len(later)))
        cause = (
            "the two self-aligning torques differ more than on the healthy car" if fault else "the two torques agree"
        )
        action = "judge again with the variant 'pre-sliding', which estimates the friction torque" if fault else "none"
        return Verdict(
            self.name,
            status,
            (Fact(status.value, cause, action=action),),
            Estimate(QUANTITY, median, deviation, "N**2*m**2", {"fault": self.threshold}),
            since,
            evidence,
            (f"variance of the self-aligning torques {median:.0f} (N·m)², limit {self.threshold:.0f}",),
            (VARIANCE_DECISIONS[0].name,) if fault else (),
            facts=(Fact("note", "the variance depends on tyres and parameters of the car as much as on friction"),),
        )

    def _began(self, above: np.ndarray) -> float | None:
        """Time [s] from which most windows lie above the limit; None where they do from the first window on."""
        # Requiring all windows would date it late: the variance also falls on straight roads.
        majority = np.cumsum((above - 0.5)[::-1])[::-1]
        first = int(np.argmax(majority))
        return float(np.concatenate(self._times)[first]) - self._window_seconds if first else None
