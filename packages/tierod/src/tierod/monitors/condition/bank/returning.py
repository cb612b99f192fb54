"""Recovery of declared elements: consistent behaviour for some time, in samples in which their fault would show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from tierod.core.block import Scalar, Tree
from tierod.core.graph.maths import absolute, all_of, both, either, maximum, negated, present, where
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.bank.weighing import Weighing
from tierod.monitors.condition.signals import ELEMENTS, SENSORS, Elements


@dataclass(frozen=True)
class Returning:
    """Count for how long every declared element has been consistent, and withdraw the declaration.

    Args:
        shows: number of standard deviations of the prediction by which a fault must change a reading to show
        agrees: number of standard deviations within which a reading is consistent with its prediction
        recovers: time for which an element must be consistent, in samples in which its fault would show
        doubtful: weight of a sample in which only a total loss would show; the estimated effect of a fault that has
            ended without showing may be wrong by then
        hopes: time after which an element is called recovering; single readings of a noisy sensor agree by chance
        loss_recovered: lost share of torque below which an actuator counts as fault-free
    """

    shows: Annotated[float, ""] = 4.0
    agrees: Annotated[float, ""] = 4.0
    recovers: Annotated[float, "s"] = 0.3
    doubtful: Annotated[float, ""] = 0.1
    hopes: Annotated[float, "s"] = 0.1
    loss_recovered: Annotated[float, ""] = 0.15

    def good(
        self,
        before: Elements,
        suspected: Elements,
        readings: Sequence[Scalar],
        seen: LeaveOutFilter.Output,
        effects: Tree,
    ) -> tuple[Scalar, ...]:
        """Number of samples for which each declared element has been consistent.

        A sample without a reading, or in which the fault would not show, does not count; an inconsistent one resets.

        Args:
            before: numbers after the previous sample
            suspected: declared elements
            readings: readings of all sensors
            seen: output of the selected lane
            effects: change that the fault of each sensor adds to its reading; None assumes a total loss
        """
        counts = []
        for place, (name, count) in enumerate(zip(ELEMENTS, before, strict=True)):
            if name in SENSORS:
                prediction, deviation = seen.prediction[place], seen.deviation[place]
                unread = negated(present(readings[place]))
                right = either(unread, absolute(readings[place] - prediction) < self.agrees * deviation)
                effect = prediction if effects is None else effects[place]
                lost = where(absolute(prediction) > self.shows * deviation, self.doubtful, 0.0)
                worth = where(unread, 0.0, where(absolute(effect) > self.shows * deviation, 1.0, lost))
            else:
                right = seen.torque_loss < maximum(self.loss_recovered, seen.loss_deviation)
                worth = where(self.shows * seen.loss_deviation < 1.0, 1.0, 0.0)
            following = where(right, count + worth, 0.0)
            counts.append(where(suspected[place], following, 0.0))
        return tuple(counts)

    def recovering(self, faulty: Elements, good: Sequence[Scalar], sample_time: float) -> Elements:
        """Flags of declared elements that have been consistent for the time `hopes`."""
        hoped = self.hopes / sample_time
        return Elements(*(both(each, count > hoped) for each, count in zip(faulty, good, strict=True)))

    def after(self, weighing: Weighing, active: Scalar, suspected: Elements, good: Sequence[Scalar]) -> Scalar:
        """Number of the active hypothesis without the elements that have recovered.

        Args:
            weighing: weighing of the hypotheses
            active: number of the active hypothesis
            suspected: elements that it suspects
            good: number of samples for which each of them has been consistent
        """
        back = [
            both(each, count * weighing.sample_time >= self.recovers)
            for each, count in zip(suspected, good, strict=True)
        ]
        following = active
        for number, each in enumerate(weighing.hypotheses):
            for kept in ((), *((name,) for name in each.suspects if len(each.suspects) > 1)):
                target = weighing.number(*kept)
                gone = [back[ELEMENTS.index(name)] for name in each.suspects if name not in kept]
                if target is None or not gone:
                    continue
                stay = [negated(back[ELEMENTS.index(name)]) for name in kept]
                following = where(all_of(active == number, *gone, *stay), float(target), following)
        return following
