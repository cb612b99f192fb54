"""What a monitor brings so that it can be run over recordings of any length."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from tierod.block import Block
from tierod.findings import Finding
from tierod.graph import Result
from tierod.monitors.own_level import OwnLevel
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class Conclusion:
    """What a session says at the end of a recording.

    Args:
        finding: the verdict
        histograms: name -> (edges, counts)
        loops: name -> (angle [rad], torque)
        consistency: figures of the innovations by name
        parameters: rows (name, value, unit, standard deviation, source) of the monitor's own tuning
        own_level: what was learnt of this vehicle, to be kept for the next recording; None where nothing was
    """

    finding: Finding
    histograms: Mapping[str, Any] = field(default_factory=dict)
    loops: Mapping[str, Any] = field(default_factory=dict)
    consistency: Mapping[str, float] = field(default_factory=dict)
    parameters: tuple[tuple[str, float, str, float | None, str], ...] = ()
    own_level: OwnLevel | None = None


class Session(Protocol):
    """One monitor over one recording, fed piece by piece."""

    block: Block
    """What runs; its sample is a flat NamedTuple of canonical signals."""

    traces: Mapping[str, tuple[str, str]]
    """Outputs of the block that a report shows over time: output -> (name in the report, unit)."""

    def absorb(self, time: np.ndarray, samples: np.ndarray, result: Result) -> None:
        """Take in one piece: time [s] (n,), samples (n, inputs) in the order of the block's sample, outputs."""

    def conclude(self) -> Conclusion:
        """The verdict over all pieces."""


@dataclass(frozen=True)
class Variant:
    """One way of doing a monitor's job.

    Args:
        name: as given on the command line
        summary: one sentence
        source: paper and equations
        open: builds the session for a vehicle, a rate [Hz], and the vehicle's own level from earlier recordings
    """

    name: str
    summary: str
    source: str
    open: Callable[[Vehicle, float, OwnLevel | None], Session]


@dataclass(frozen=True)
class Monitor:
    """One thing that tierod watches.

    Args:
        name: as given on the command line
        title: for people
        summary: one sentence
        source: paper
        required: canonical signals without which it cannot run
        optional: signals that make it better
        rate: of the grid it runs on [Hz]
        minimum_rate: slowest channel that it accepts [Hz]
        maximum_age: a sample older than this is missing [s]
        variants: by name, the default first
    """

    name: str
    title: str
    summary: str
    source: str
    required: tuple[str, ...]
    optional: tuple[str, ...]
    rate: float
    minimum_rate: float
    maximum_age: float
    variants: Mapping[str, Variant]
