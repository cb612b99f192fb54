"""Return of suspects: fault-free behaviour for a while, in samples at which their fault would show."""

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
    """Count for how long every suspect has been as it should, and let it go.

    Args:
        shows: number of standard deviations of its prediction by which a fault must change a reading to show in it
        agrees: number of standard deviations within which a reading counts as it should
        recovers: for how long it must, in samples at which its fault would show
        doubtful: weight of a sample at which only a loss would show: a fault that went while it did not show may have
            been learnt wrongly since
        hopes: after which it is called recovering; single readings of a noisy sensor are right by chance
        loss_recovered: share of lost torque below which an actuator counts as whole
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
        """For how many samples each suspect has been as it should; unbroken where its fault would not show, or unread.

        Args:
            before: the same at the sample before
            suspected: declared elements
            readings: of all sensors
            seen: output of the selected lane
            effects: additions of the declared sensor faults to their readings; a loss if None
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
        """Declared, but as it should for the last samples."""
        hoped = self.hopes / sample_time
        return Elements(*(both(each, count > hoped) for each, count in zip(faulty, good, strict=True)))

    def after(self, weighing: Weighing, active: Scalar, suspected: Elements, good: Sequence[Scalar]) -> Scalar:
        """The active hypothesis without those that have recovered.

        Args:
            weighing: of the hypotheses
            active: the number of the hypothesis that holds
            suspected: elements that it suspects
            good: for how many samples each suspect has been as it should
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
