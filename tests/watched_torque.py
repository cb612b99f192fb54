"""Blocks that are small enough to be read beside the C that they become."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Ring, Scalar
from tierod.core.graph.maths import both, exp, present, where
from tierod.core.statuses import Statement


@dataclass(frozen=True)
class Watch:
    """Watches a torque.

    Args:
        limit: torque above which it is suspect
        sample_time: between two samples
    """

    limit: Annotated[float, "N*m"] = 2.0
    sample_time: Annotated[float, "s"] = 0.01
    # time constant
    # of the smoothing
    memory: Annotated[float, "s"] = 0.5

    class Sample(NamedTuple):
        """One torque."""

        driver_torque: Annotated[Scalar, "N*m"]

    class State(NamedTuple):
        """Clock, time above the limit, smoothed torque, and one that is late."""

        time: Annotated[Scalar, "s"]  # time, above: since the start, and above the limit
        above: Annotated[Scalar, "s"]
        smooth: Annotated[Scalar, "N*m"]
        late: Ring  # the three last ones

    class Output(NamedTuple):
        """What it states.

        Args:
            statement: on the torque
            smooth: torque without
                its noise
            late: torque of three samples ago
        """

        statement: Statement
        smooth: Annotated[Scalar, "N*m"]
        late: Annotated[Scalar, "N*m"]

    def init(self) -> State:
        """Nothing seen."""
        return self.State(0.0, 0.0, self.limit * 0.25, Ring(3, 0.5))

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        """One sample on."""
        known = present(sample.driver_torque)
        value = where(known, sample.driver_torque, state.smooth)
        share = 1.0 - exp(-self.sample_time / self.memory)
        smooth = state.smooth + share * (value - state.smooth)
        high = both(known, smooth > self.limit)
        above = state.above + where(high, self.sample_time, 0.0)
        time = state.time + self.sample_time
        status = where(above > 0.2, 2.0, 0.0)
        statement = Statement(status, where(above > 0.0, time, -1.0), 0.0, smooth, 0.0, above / 0.2)
        after = self.State(time, above, smooth, state.late.push(value))
        return after, self.Output(statement, smooth, state.late.oldest)
