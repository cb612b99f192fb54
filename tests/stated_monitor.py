"""A monitor whose verdict is known: the speed of the car, 10 m/s subtracted, is the code of the status."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar
from tierod.core.facts import Fact, Verdict
from tierod.core.findings import Element, Status
from tierod.core.graph.maths import floor
from tierod.core.recording import Channel, Recording
from tierod.core.statuses import STATUSES, Statement
from tierod.monitors.session import BlockSession, Conclusion, Monitor, Variant

BASE = 10.0
"""Speed of the first status [m/s]."""


@dataclass(frozen=True)
class Stated:
    """States the status that the speed encodes."""

    class Sample(NamedTuple):
        vehicle_speed: Annotated[Scalar, "m/s"]

    class Output(NamedTuple):
        statement: Statement

    def init(self) -> Scalar:
        return 0.0

    def step(self, state: Scalar, sample: Sample) -> tuple[Scalar, Output]:
        code = floor(sample.vehicle_speed - BASE + 0.5)
        return state, self.Output(Statement(code, -1.0, 0.0, 0.0, 0.0, 0.0))


class StatedSession(BlockSession):
    """Gives the status of the mean speed."""

    def __init__(self):
        super().__init__(Stated(), {})
        self.codes = []

    def collect(self, time, signals, result):
        self.codes.append(result["statement.status"])

    def conclude(self):
        status = STATUSES[round(float(np.nanmedian(np.concatenate(self.codes))))]
        verdict = Verdict("stated, only", status, (Fact("stated", "it was stated"),))
        return Conclusion(verdict, elements=(Element("vehicle_speed", "sensor", status),))


STATED = Monitor(
    "stated", "Statement", "A statement.", "none", ("vehicle_speed",), (), 50.0, 10.0, 0.2,
    {"only": Variant("only", "One.", "none", lambda vehicle, rate, level: StatedSession())}, "only",
)  # fmt: skip


def drive(status: Status, seconds: float = 40.0, **metadata) -> Recording:
    """A drive at the speed of a status."""
    time = np.arange(0.0, seconds, 0.02)
    speed = BASE + STATUSES.index(status) + 0.1 * np.sin(time)
    return Recording({"vehicle_speed": Channel("vehicle_speed", time, speed, "m/s")}, metadata)
