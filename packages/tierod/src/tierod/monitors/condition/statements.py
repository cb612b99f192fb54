"""Statements about all sensors and actuators over the samples of a recording, and kinds of faults in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.core.findings import Status
from tierod.core.graph import Result
from tierod.core.shown import in_words
from tierod.core.signals import SIGNALS
from tierod.core.statement import STATUSES
from tierod.monitors.condition.kinds.catalogue import (
    DELAY,
    DRIFT,
    GAIN,
    LOSS,
    LOST_TORQUE,
    NOISE,
    OFFSET,
    OUTLIER,
    STUCK,
)
from tierod.monitors.condition.signals import ELEMENTS

FAULT, SUSPECT, HEALTHY, NOT_TESTABLE, NOT_AVAILABLE = (
    STATUSES.index(each)
    for each in (Status.FAULT, Status.SUSPECT, Status.HEALTHY, Status.NOT_TESTABLE, Status.NOT_AVAILABLE)
)
"""Codes of the statuses that the monitor uses."""


class StatementCourse(NamedTuple):
    """Statements over n samples, one column for each of `ELEMENTS`.

    Args:
        status: indices in `STATUSES`
        testable: whether a fault would show
        spread: deviations by which that is judged, see `Judged`
        kind: number of the kind; 0 where none is identified
        magnitude, deviation: magnitude of the fault, see `described`, and its standard deviation
        low_grip: whether the tyres slid, so that no fault was declared, (n,)
        lead: evidence for a fault, see `Judged.lead`, (n,) [nat per sample, or a share]; NaN where nothing is judged
        since, supported: times in the recording at which the evidence for the status began, and until which residuals
            supported a fault, NaN without evidence for one [s]
        ended: whether residuals have contradicted a declared fault since then
    """

    status: np.ndarray
    testable: np.ndarray
    spread: np.ndarray
    kind: np.ndarray
    magnitude: np.ndarray
    deviation: np.ndarray
    low_grip: np.ndarray
    lead: np.ndarray
    since: np.ndarray
    supported: np.ndarray
    ended: np.ndarray

    @classmethod
    def of(cls, result: Result, time: np.ndarray, running: np.ndarray) -> StatementCourse:
        """Statements in the result of a block whose output is a `ConditionOutput`.

        Args:
            result: result of the block
            time: time stamps in the recording [s], (n,)
            running: time since the start of the block's run [s], (n,)
        """
        status, kind, magnitude, deviation, since = (
            np.column_stack([result[f"statements.{name}.{each}"] for name in ELEMENTS])
            for each in ("status", "kind", "magnitude", "deviation", "since")
        )
        supported = np.column_stack([result[f"supported.{name}"] for name in ELEMENTS])
        ended = np.column_stack([result[f"ended.{name}"] for name in ELEMENTS]) > 0.5
        begun = (time - running)[:, None]
        testable = np.column_stack([result[f"testable.{name}"] for name in ELEMENTS]) > 0.5
        spread = np.column_stack([result[f"spread.{name}"] for name in ELEMENTS])
        low_grip = result["low_grip"] > 0.5
        return cls(
            *(np.rint(status).astype(int), testable, spread, kind, magnitude, deviation, low_grip, result["lead"]),
            *(begun + np.maximum(since, 0.0), np.where(supported < 0.0, np.nan, begun + supported), ended),
        )

    @classmethod
    def unjudged(cls, count: int) -> StatementCourse:
        """Statements over samples that are not judged: not testable.

        Args:
            count: number of samples
        """
        no, unknown = np.zeros((count, len(ELEMENTS)), bool), np.full((count, len(ELEMENTS)), np.nan)
        status = np.full(no.shape, NOT_TESTABLE)
        no_kind = np.zeros(no.shape)
        return cls(status, no, unknown, no_kind, unknown, unknown, no[:, 0], unknown[:, 0], unknown, unknown, no)

    def where_available(self, available: np.ndarray, moving: np.ndarray) -> StatementCourse:
        """Statements with "not available" where an element has no signal; a declared fault is kept.

        Args:
            available: whether each sensor is read, or each actuator's target is known, (n, elements)
            moving: whether the vehicle moves, (n,)
        """
        testable = self.testable & available & moving[:, None]
        quiet = np.where(testable, HEALTHY, NOT_TESTABLE)
        status = np.select(
            [self.status == FAULT, ~available, self.status == SUSPECT], [FAULT, NOT_AVAILABLE, SUSPECT], quiet
        )
        return self._replace(status=status, testable=testable)


class Description(NamedTuple):
    """Description of a kind of fault and of its magnitude.

    Args:
        kind: kind in words
        quantity: name of the magnitude; "" for a kind without magnitude
        unit: unit of the magnitude
        factor: conversion factor from the magnitude to that unit
    """

    kind: str
    quantity: str = ""
    unit: str = ""
    factor: float = 1.0


def described(element: str, kind: float, magnitude: float) -> Description:
    """Description of a kind of fault; empty if none is identified.

    Args:
        element: faulty element
        kind: number of the kind
        magnitude: offset or noise in the unit of the signal, drift in that unit per second, factor of a gain or an
            outlier, delay [s], share of a loss of torque
    """
    if kind == LOST_TORQUE:
        return Description("loss of torque", "lost share of the torque", "percent", 100.0)
    unit = SIGNALS[element].unit if element in SIGNALS else ""
    sign = "positive" if magnitude > 0.0 else "negative"
    return {
        LOSS: Description("total loss"),
        STUCK: Description("stuck"),
        OFFSET: Description(f"{sign} offset", "offset", unit),
        GAIN: Description("wrong gain", "reading over truth"),
        DRIFT: Description("drift", "growth of the error", f"{unit}**2" if unit.endswith("/s") else f"{unit}/s"),
        OUTLIER: Description("outlier", "reading over truth"),
        NOISE: Description("noise", "standard deviation of the noise", unit),
        DELAY: Description("delay", "delay", "s"),
    }.get(kind, Description(""))


def shown(value: float, unit: str) -> str:
    """Value in a customary unit as text: angles in degrees, speeds in km/h.

    Args:
        value: value in the unit
        unit: unit as in a `Description`
    """
    return in_words(value, unit)


def listed(names: Sequence[str], word: str = "and") -> str:
    """Names of signals in plain words, the last two joined by a word."""
    plain = [name.replace("_", " ") for name in names]
    return f" {word} ".join([", ".join(plain[:-1]), plain[-1]] if len(plain) > 1 else plain)
