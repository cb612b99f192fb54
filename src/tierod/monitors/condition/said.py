"""What a variant of the condition monitor says of every sensor and actuator, sample by sample: one form for all."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.core.graph import Result
from tierod.core.shown import in_words
from tierod.core.signals import SIGNALS
from tierod.monitors.condition.kinds.catalogue import DELAY, DRIFT, GAIN, LOSS, NOISE, OFFSET, OUTLIER, STUCK
from tierod.monitors.condition.signals import ACTUATORS, ELEMENTS, SENSORS

LARGEST_LEAD = 20.0
"""By how much one sample may speak for one hypothesis against another [nat]; without a rival a lead has no end."""

LOST_TORQUE = 100.0
"""Number of the kind "loss of torque" of an actuator, beside the kinds of sensors."""


class Said(NamedTuple):
    """Over n samples, one column for each of `ELEMENTS`.

    Args:
        faulty, candidates, testable: whether declared, one of several that may be it, and whether a fault would show
        kind: number of the kind; 0 where none is told
        size, deviation: of the fault, see `told`; NaN where none is told
        gated: readings that are too far off to be believed, declared or not, (n, sensors)
        slid: whether the tyres slid, so that nothing could be told, (n,)
        evidence: what a fault is declared by, (n,): of filters the lead of the most likely hypothesis over the others
            [nat per sample], of rules the share that is so of what the best one asks; NaN where nothing is judged
    """

    faulty: np.ndarray
    candidates: np.ndarray
    testable: np.ndarray
    kind: np.ndarray
    size: np.ndarray
    deviation: np.ndarray
    gated: np.ndarray
    slid: np.ndarray
    evidence: np.ndarray

    def only(self, available: np.ndarray, moving: np.ndarray) -> Said:
        """Without doubts about what is not there to be doubted; a fault that was declared before stays.

        Args:
            available: (n, elements)
            moving: whether the vehicle drives at all, (n,)
        """
        return self._replace(
            candidates=self.candidates & available, testable=self.testable & available & moving[:, None]
        )


def nothing_said(count: int) -> Said:
    """Over samples that are not judged.

    Args:
        count: of them
    """
    no, untold = np.zeros((count, len(ELEMENTS)), bool), np.full((count, len(ELEMENTS)), np.nan)
    return Said(no, no, no, np.zeros(no.shape), untold, untold, no[:, : len(SENSORS)], no[:, 0], untold[:, 0])


def said_by_bank(result: Result) -> Said:
    """Of the bank of filters, whose output is a `Judgement`."""
    faulty = _columns(result, "decision.faulty", ELEMENTS)
    kind, size, deviation = (np.full(faulty.shape, np.nan) for _ in range(3))
    for place, name in enumerate(SENSORS):
        kind[:, place] = result[f"kinds.{name}.kind"]
        size[:, place], deviation[:, place] = result[f"kinds.{name}.size"], result[f"kinds.{name}.deviation"]
    torque = slice(len(SENSORS), None)
    lost = faulty[:, torque] > 0.5
    kind[:, torque] = np.where(lost, LOST_TORQUE, 0.0)
    # A filter that knows a little too little of the motor tells of more than all that it gives.
    size[:, torque] = np.where(lost, np.minimum(result["loss.share"], 1.0)[:, None], np.nan)
    deviation[:, torque] = np.where(lost, result["loss.deviation"][:, None], np.nan)
    return Said(
        faulty > 0.5,
        _columns(result, "decision.candidates", ELEMENTS) > 0.5,
        _columns(result, "decision.testable", ELEMENTS) > 0.5,
        kind,
        size,
        deviation,
        _columns(result, "decision.gated", SENSORS) > 0.5,
        result["decision.low_grip"] > 0.5,
        np.minimum(result["decision.lead"], LARGEST_LEAD),
    )


def said_by_rules(result: Result) -> Said:
    """Of a variant of the rules, whose output is that of `RuleMonitor`; rules tell neither kind nor size."""
    faulty, candidates = (
        np.hstack([_columns(result, f"sensor{what}", SENSORS), _columns(result, f"actuator{what}", ACTUATORS)]) > 0.5
        for what in ("s", "_candidates")
    )
    testable = np.hstack(
        [_columns(result, "not_testable", SENSORS) < 0.5, np.ones((len(faulty), len(ACTUATORS)), bool)]
    )
    untold = np.full(testable.shape, np.nan)
    nothing = np.zeros((len(faulty), len(SENSORS)), bool)
    fits = np.hstack([_columns(result, "sensor_scores", SENSORS), _columns(result, "actuator_scores", ACTUATORS)])
    kinds = np.zeros(testable.shape)
    return Said(faulty, candidates, testable, kinds, untold, untold, nothing, nothing[:, 0], fits.max(axis=1))


def _columns(result: Result, group: str, names: tuple[str, ...]) -> np.ndarray:
    return np.column_stack([result[f"{group}.{name}"] for name in names])


class Told(NamedTuple):
    """A kind of fault with its size, as people read it.

    Args:
        kind: in words
        quantity: that the size tells; "" where the kind has no size
        unit: of the size
        factor: from the size to that unit
    """

    kind: str
    quantity: str = ""
    unit: str = ""
    factor: float = 1.0


def told(element: str, kind: float, size: float) -> Told:
    """A kind of fault in words; empty words where none is told.

    Args:
        element: at fault
        kind: its number
        size: of an offset, a drift, noise in the unit of the signal (a drift: per second), of a gain or an outlier the
            factor, of a delay [s], of a loss of torque the share
    """
    if kind == LOST_TORQUE:
        return Told("loss of torque", "lost share of the torque", "percent", 100.0)
    unit = SIGNALS[element].unit if element in SIGNALS else ""
    sign = "positive" if size > 0.0 else "negative"
    return {
        LOSS: Told("total loss"),
        STUCK: Told("stuck"),
        OFFSET: Told(f"{sign} offset", "offset", unit),
        GAIN: Told("wrong gain", "reading over truth"),
        DRIFT: Told("drift", "growth of the error", f"{unit}**2" if unit.endswith("/s") else f"{unit}/s"),
        OUTLIER: Told("outlier", "reading over truth"),
        NOISE: Told("noise", "standard deviation of the noise", unit),
        DELAY: Told("delay", "delay", "s"),
    }.get(kind, Told(""))


def shown(value: float, unit: str) -> str:
    """A value in the unit that people use: angles in degrees, speeds in km/h.

    Args:
        value: in the unit
        unit: as in a `Told`
    """
    return in_words(value, unit)


def listed(names: Sequence[str], word: str = "and") -> str:
    """Names of signals in plain words, the last two joined by a word."""
    plain = [name.replace("_", " ") for name in names]
    return f" {word} ".join([", ".join(plain[:-1]), plain[-1]] if len(plain) > 1 else plain)
