"""Statement of a monitor about one element, in the same form in block, page, JSON, fault memory and generated C."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.statuses import Status

# All statuses; the code of a status is its index here, the same for all monitors
STATUSES: tuple[Status, ...] = tuple(Status)


def code_of(status: Status) -> float:
    """The code of a status inside a block."""
    return float(STATUSES.index(status))


class Statement(NamedTuple):
    """Statement of a monitor about one sensor, actuator or quantity at one sample."""

    status: Annotated[Scalar, ""]  # code in `STATUSES`
    # time from the start of the run at which the evidence for the status began; negative where it holds throughout or
    # is not known
    since: Annotated[Scalar, "s"]
    # number of the kind of fault in the monitor's catalogue of kinds; 0 where there is none, or it is not identifiable
    kind: Annotated[Scalar, ""]
    # fault magnitude, or the estimate itself where the monitor estimates one quantity, in the unit that the monitor
    # declares for the kind; 0 where there is none, since no block may hold a NaN constant
    magnitude: Annotated[Scalar, ""]
    deviation: Annotated[Scalar, ""]  # standard deviation of the magnitude, in its unit; 0 where there is none
    evidence: Annotated[Scalar, ""]  # decision statistic relative to its threshold: the decision falls at 1
