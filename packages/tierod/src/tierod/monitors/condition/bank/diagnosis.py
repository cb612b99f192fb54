"""Diagnosis of the bank at one sample: faulty elements, and the expected reading of every sensor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, all_of, negated, present, where
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.signals import Elements, Readings


class Diagnosis(NamedTuple):
    """Diagnosis at one sample.

    Args:
        hypothesis: number of the active hypothesis, 0 for fault-free
        faulty: declared elements
        candidates: elements that may be faulty, if several hypotheses explain the samples almost equally well
        testable: whether a total loss of each element would be detectable now
        spread: standard deviations by which `testable` judges: of each reading less its prediction by the others, and
            of the lost share of each actuator's torque
        recovering: declared elements that have been consistent for the last samples
        gated: readings of undeclared sensors that are outliers in this sample
        value: value of every sensor: its reading where it is trusted, otherwise the estimate from the other sensors
        prediction, deviation: prediction of the reading of every sensor before this sample, and the standard deviation
            of reading less prediction; for declared sensors without their own readings
        torque_loss, loss_deviation: lost share of the declared actuators' torque, the same for two, and its standard
            deviation
        speed, lateral_speed: speed components of the centre of gravity
        best: number of the hypothesis that explains the last samples best, the active one included
        lead: its mean log-likelihood ratio per sample less that of its best rival [nat]
        low_grip: whether tyres slide, so that no fault is declared
    """

    hypothesis: Annotated[Scalar, ""]
    faulty: Elements
    candidates: Elements
    testable: Elements
    spread: Elements
    recovering: Elements
    gated: Readings
    value: Readings
    prediction: Readings
    deviation: Readings
    torque_loss: Annotated[Scalar, ""]
    loss_deviation: Annotated[Scalar, ""]
    speed: Annotated[Scalar, "m/s"]
    lateral_speed: Annotated[Scalar, "m/s"]
    best: Annotated[Scalar, ""]
    lead: Annotated[Scalar, ""]
    low_grip: Annotated[Scalar, ""]


def gated(
    readings: Sequence[Scalar], estimate: LeaveOutFilter.Output, faulty: Elements, deviations: Scalar
) -> Readings:
    """Flags of outlying readings of sensors that are not declared.

    Args:
        readings: readings of all sensors
        estimate: output of the selected lane
        faulty: declared elements
        deviations: number of standard deviations beyond which a reading is an outlier
    """
    # Sensors come first in `faulty`: the shorter lists end before its actuators.
    known = zip(readings, estimate.prediction, estimate.deviation, faulty, strict=False)
    return Readings(
        *(
            all_of(
                negated(declared),
                present(reading),
                absolute(where(present(reading), reading, 0.0) - prediction) > deviations * deviation,
            )
            for reading, prediction, deviation, declared in known
        )
    )


def values_of(readings: Sequence[Scalar], estimate: LeaveOutFilter.Output, faulty: Elements, off: Readings) -> Readings:
    """Value of every sensor: its reading if it is trusted, else the estimate of the selected lane.

    Args:
        readings: readings of all sensors
        estimate: output of the selected lane
        faulty: declared elements
        off: flags of outlying readings, see `gated`
    """
    known = zip(readings, estimate.estimate, faulty, off, strict=False)
    return Readings(
        *(
            where(all_of(present(reading), negated(declared), negated(far)), reading, value)
            for reading, value, declared, far in known
        )
    )
