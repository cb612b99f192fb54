"""What is known after a recording, for the final judgement on friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from tierod.models.friction_estimation import FrictionParameters
from tierod.monitors.friction.verdict import FrictionVerdict, VerdictOutput
from tierod.monitors.friction.verdict_state import VerdictSample


@dataclass(frozen=True)
class FrictionRun:
    """What a monitor knows after a recording.

    Args:
        monitor: its name and variant
        verdict: the judge that ran
        state: its state after the last sample
        last: the estimate after the last sample
        output: the judge's output after the last sample
        calibrated: whether the torques are in N*m
        start_time: time of the first sample in the recording [s]
        evidence: further named figures of the estimator, with unit in the name
        parameters: of the vehicle file, as the estimator believes them; None where that is not known
    """

    monitor: str
    verdict: FrictionVerdict
    state: FrictionVerdict.State
    last: VerdictSample
    output: VerdictOutput
    calibrated: bool
    start_time: float = 0.0
    evidence: Mapping[str, float] = field(default_factory=dict)
    parameters: FrictionParameters | None = None
