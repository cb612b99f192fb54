"""Statement of a monitor about one thing, in one form from its block to page, JSON, fault memory and generated C."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.findings import Status

STATUSES: tuple[Status, ...] = tuple(Status)
"""Status of each code; a code is its place here, the same for all monitors."""


def code_of(status: Status) -> float:
    """The number that stands for a status inside a block.

    Args:
        status: any
    """
    return float(STATUSES.index(status))


class Statement(NamedTuple):
    """Statement of a monitor about one sensor, actuator or quantity at one sample.

    Args:
        status: code in `STATUSES`
        since: time from the start of the run at which the grounds of the status began; negative where it holds
            throughout or is not known
        kind: number of the kind of fault in the monitor's catalogue of kinds; 0 where there is none, or it is not
            identifiable
        magnitude: of the fault, or the estimate itself where the monitor estimates one quantity, in the unit that the
            monitor declares for the kind; 0 where there is none, since no block may hold a NaN constant
        deviation: standard deviation of the magnitude, in its unit; 0 where there is none
        evidence: statistic of the decision over its threshold: 1 decides
    """

    status: Annotated[Scalar, ""]
    since: Annotated[Scalar, "s"]
    kind: Annotated[Scalar, ""]
    magnitude: Annotated[Scalar, ""]
    deviation: Annotated[Scalar, ""]
    evidence: Annotated[Scalar, ""]
