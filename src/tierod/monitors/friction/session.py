"""A friction monitor over one recording: what it collects on the way, and its finding at the end."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np

from tierod.core.block import tuning
from tierod.core.findings import Finding, Status
from tierod.core.graph import Result
from tierod.methods.analysis.consistency import ConsistencyAccumulator
from tierod.methods.identification.hysteresis_presence import HysteresisPresence
from tierod.models.eps_column import driving_torque
from tierod.monitors.friction.decisions import STATISTICS
from tierod.monitors.friction.judged import JudgedEstimator
from tierod.monitors.friction.judgement import judge
from tierod.monitors.friction.monitor import FrictionMonitor
from tierod.monitors.friction.over_drive import EstimateOverDrive, HysteresisOverDrive, SignalsOverDrive
from tierod.monitors.friction.run import FrictionRun
from tierod.monitors.friction.torque_gains import GainsOverDrive
from tierod.monitors.friction.verdict_state import HEALTHY, STATUSES
from tierod.monitors.harness.own_level import OwnLevel
from tierod.monitors.harness.session import BlockSession, Conclusion
from tierod.physics.friction import viscous
from tierod.vehicles import Vehicle

VALUES = ("friction_torque", "friction_torque_standard_deviation", "ratio_to_own_level", *STATISTICS)
"""Traces that tell the value of friction."""

WITHHELD = (
    "The value of friction is withheld, so its course, its spread, its hysteresis and its ratio to the own level are "
    "not shown: what the estimator computed means nothing here. The verdict says why."
)

Acting = Callable[[Mapping[str, np.ndarray], Result], np.ndarray]
"""Friction torque that acts at each sample, from the signals by name and the outputs."""


class FrictionSession(BlockSession):
    """Runs an estimator with its running verdict, and collects what a report shows.

    Args:
        block: estimator and judge
        vehicle: whose friction it is
        rate: of the samples [Hz]
        acting: friction torque that acts, for the hysteresis view
        consistency_remark: how the innovations of this estimator are to be read where its variance is set wide, so that
            the band of a consistent filter is none for it
    """

    def __init__(
        self,
        block: FrictionMonitor | JudgedEstimator,
        vehicle: Vehicle,
        rate: float,
        acting: Acting,
        consistency_remark: str = "",
    ):
        unit = vehicle.torque_unit
        traces = {
            "estimate.friction_torque": (VALUES[0], unit),
            "estimate.friction_deviation": (VALUES[1], unit),
            "estimate.enabled": ("enabled", ""),
            "estimate.nis": ("nis", ""),
            "verdict.ratio": (VALUES[2], ""),
            "verdict.rising_sum": (STATISTICS[0], ""),
            "verdict.fault_sum": (STATISTICS[1], ""),
        }
        super().__init__(block, traces, ("verdict.code", STATUSES))
        self._judged, self.vehicle, self._acting = block, vehicle, acting
        self._consistency_remark = consistency_remark
        self._estimates, self._hysteresis = EstimateOverDrive(rate), HysteresisOverDrive(rate)
        self._signals, self._gains = SignalsOverDrive(), GainsOverDrive(vehicle, rate)
        self._consistency = ConsistencyAccumulator()
        self._start: float | None = None
        self._last: Result | None = None

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Estimates, the torque that acts, and innovations of one piece."""
        self._start = float(time[0]) if self._start is None else self._start
        self._last = result
        enabled = result["estimate.enabled"] > 0.5
        self._signals.add(time, signals)
        self._gains.add(signals)
        self._estimates.add(time, result["estimate.friction_torque"], result["verdict.code"] >= HEALTHY)
        self._hysteresis.add(time, signals["steering_wheel_angle"], self._acting(signals, result), enabled)
        present = result["estimate.present"] if "estimate.present" in result.names else np.ones(len(result))
        self._consistency.add(result["estimate.nis"][enabled], present[enabled])

    def conclude(self) -> Conclusion:
        """The finding, and what a report shows beside it."""
        if self._last is None or self._start is None:
            raise RuntimeError("a session concludes after at least one piece")
        run = self._judged.run_of(self._last.at(-1), self._last.state, self.vehicle.calibrated, self._start)
        finding = judge(run)
        if finding.estimate is None:
            finding = _with_presence(finding, self._signals.presence())
        known = finding.estimate is not None
        remarks = {"consistency": self._consistency_remark, "estimate": "" if known else WITHHELD}
        return Conclusion(
            finding,
            self._estimates.histograms(finding.since) if known else {},
            self._hysteresis.views(finding.since) if known else {},
            self._consistency_figures(),
            tuple(tuning_rows(self.block)),
            self._own_level(run, finding.status),
            {part: remark for part, remark in remarks.items() if remark},
            () if known else VALUES,
            tuple(self.course),
            defects=self._gains.defects(),
        )

    def _consistency_figures(self) -> dict[str, float]:
        """What the innovations say; the band of a filter that knows its variance is left out where it is set wide."""
        found = self._consistency.result()
        figures = {"enabled_samples": float(found.samples), "nis_mean": found.nis}
        if self._consistency_remark:
            return figures
        return figures | {
            "nis_band_low": found.nis_band[0],
            "nis_band_high": found.nis_band[1],
            "nis_outside_95_share": found.outside,
        }

    def _own_level(self, run: FrictionRun, status: Status) -> OwnLevel | None:
        if status is not Status.HEALTHY or run.output.level <= 0.0:
            return None
        own = run.state.own
        return OwnLevel(self.vehicle.name, run.monitor, own.level, own.deviation, self.vehicle.torque_unit, own.seconds)


def _with_presence(finding: Finding, found: HysteresisPresence | None) -> Finding:
    """What can be said of friction where its size is withheld."""
    if found is None:
        return finding
    what = "is present, but its size cannot be told" if found.present else "does not stand out from chance"
    sentence = (
        f"hysteresis of dry friction {what}: the torques follow {found.share:.0%} of its build-up that angle, rate and "
        f"lateral acceleration leave open, and up to {found.chance:.0%} of shifted copies"
    )
    figures = {"hysteresis_share": found.share, "hysteresis_by_chance_share": found.chance}
    return dataclasses.replace(finding, cause=f"{finding.cause}; {sentence}", evidence={**finding.evidence, **figures})


def acting_by_build_up(signals: Mapping[str, np.ndarray], result: Result) -> np.ndarray:
    """Friction that acts, as the pre-sliding estimator sees it: its model's, and what is left of the balance."""
    return result["estimate.friction_torque"] * result["estimate.build_up"] + result["estimate.innovation"]


def acting_by_balance(parameters: Any) -> Acting:
    """Friction that acts, as what the torque balance of eq (2) leaves beside inertia."""

    def acting(signals: Mapping[str, np.ndarray], result: Result) -> np.ndarray:
        aligning = result["estimate.self_aligning_torque"]
        driving = driving_torque(signals["driver_torque"], signals["motor_torque"], aligning, parameters)
        return driving - viscous(signals["steering_wheel_rate"], parameters.column_damping)

    return acting


def tuning_rows(block: Any) -> list[tuple[str, float, str, float | None, str]]:
    """Every float of the monitor's own tuning, with its unit where its field says it."""
    rows: list[tuple[str, float, str, float | None, str]] = []
    for path, value in tuning(block):
        if ".parameters." not in f".{path}" and not path.startswith("verdict.limits.") and math.isfinite(value):
            rows.append((path, value, _unit_of(block, path), None, f"tuning of {type(block).__name__}"))
    return rows


def _unit_of(block: Any, path: str) -> str:
    """The unit of a float field, from the annotation of its dataclass or NamedTuple."""
    *way, name = path.split(".")
    holder = block
    for step in way:
        holder = holder[int(step)] if step.isdigit() else getattr(holder, step)
    if not (dataclasses.is_dataclass(holder) or hasattr(holder, "_fields")):
        return ""
    hint = get_type_hints(type(holder), include_extras=True).get(name)
    return str(get_args(hint)[1]) if get_origin(hint) is Annotated else ""
