"""Which sensors and actuators are at fault: the judge over the bank of filters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.block import Tree, map_leaves, rebuild, skeleton
from tierod.block import leaves as leaves_of
from tierod.graph import JudgeSample, Verdict
from tierod.graph.maths import absolute, all_of, any_of, both, maximum, negated, present, where
from tierod.monitors.condition.adoption import adopted, believed, kin
from tierod.monitors.condition.diagnosis import Diagnosis, Elements
from tierod.monitors.condition.lane import LeaveOutFilter, Readings
from tierod.monitors.condition.signals import ELEMENTS, SENSORS, Hypothesis
from tierod.monitors.condition.weighing import Limits, Ranking, Weighing, Weights, chosen

TOLD_BY = {"steering_motor_1": "steering_shaft_torque", "steering_motor_2": "steering_shaft_torque"}
"""Without which sensor nobody can tell whether an actuator gives what it is asked for."""


class DecisionState(NamedTuple):
    """What the judge remembers.

    Args:
        weights: of all hypotheses against the active one
        active: number of the active hypothesis
        leading: number of the hypothesis that led at the sample before, 0 for none
        led: for how many samples in a row
        exceeded: for how many samples in a row any hypothesis was beyond its limit
        good: for how many samples each suspect has been as it should
        unread: for how many samples each sensor has had no reading
    """

    weights: Weights
    active: Any
    leading: Any
    led: Any
    exceeded: Any
    good: Elements
    unread: Readings


@dataclass(frozen=True)
class Decision:
    """Declare what is at fault from the likelihoods of all hypotheses, and take back what has recovered.

    A hypothesis is declared when its smoothed log-likelihood ratio against the active one is beyond its limit and it
    leads all others by a gap, for some samples in a row; without the gap, all that come close are candidates. All
    lanes then go on from the state of the one that is declared. Until then a lane to which a sample is all but
    impossible goes on from the state of the lane that explains it best: a reading far off is gated at once, and a
    faulty one does not pull the lanes that believe it.

    Args:
        weighing: of the hypotheses, with the limits
        samples: in a row that a hypothesis must lead
        samples_of_actuators: likewise, of one that suspects an actuator; motors are told apart by a changing split of
            their torque, which takes some 0.1 s to change
        impossible: log-likelihood ratio of one sample against the best hypothesis at which a lane is corrected; twice
            the price of leaving out a sensor
        gate: number of standard deviations beyond which a single reading is not believed
        shows: number of standard deviations of its prediction by which a fault must change a reading to show in it
        agrees: number of standard deviations within which a reading counts as it should
        recovers: for how long it must, in samples at which its fault would show
        doubtful: what a sample counts at which only a loss would show: a fault that went while it did not show may have
            been learnt wrongly since
        hopes: after which it is called recovering; single readings of a noisy sensor are right by chance
        loss_recovered: share of lost torque below which an actuator counts as whole
        missing: after which a sensor without a reading is missing: longer than the slowest channels take
        poorer: factor of all limits while one is: what is left shows up to 1.7 times as much without any fault
        fewest: sensors without which nobody is accused
        cornering: acceleration across the vehicle from which nobody is accused: tyres slide, and no calibration drive
            has shown how; those of the demonstrator reach 5.9 m/s**2

    At standstill and in reverse nobody is accused, no wheel while it brakes harder than its drives, nobody who is
    missing, and no steering motor without the torque sensor that tells what both give.

    Source: Li, Frey, Gauterin, sections 3 and 4, replaced: their rules name no sensor for most faults.
    """

    weighing: Weighing
    samples: Annotated[float, ""] = 3.0
    samples_of_actuators: Annotated[float, ""] = 10.0
    impossible: Annotated[float, ""] = 12.0
    gate: Annotated[float, ""] = 6.0
    shows: Annotated[float, ""] = 4.0
    agrees: Annotated[float, ""] = 4.0
    recovers: Annotated[float, "s"] = 0.3
    doubtful: Annotated[float, ""] = 0.1
    hopes: Annotated[float, "s"] = 0.1
    loss_recovered: Annotated[float, ""] = 0.15
    missing: Annotated[float, "s"] = 0.2
    poorer: Annotated[float, ""] = 1.7
    fewest: Annotated[float, ""] = 4.0
    cornering: Annotated[float, "m/s**2"] = 6.5

    def feedback(self) -> Tree:
        """Lanes are told nothing; they are given the states of others."""
        return ()

    def init(self) -> DecisionState:
        """Healthy."""
        none = Elements(*(0.0,) * len(ELEMENTS)), Readings(*(0.0,) * len(SENSORS))
        return DecisionState(self.weighing.init(), 0.0, 0.0, 0.0, 0.0, *none)

    def step(self, state: DecisionState, sample: JudgeSample, effects: Tree = None) -> tuple[DecisionState, Verdict]:
        """One sample on.

        Args:
            state: after the sample before
            sample: of the bank, and the outputs of all lanes
            effects: what the fault of each sensor that is declared adds to its reading; a loss if None
        """
        lanes, readings = sample.lanes, sample.sample[: len(SENSORS)]
        likelihoods = [lane.log_likelihood for lane in lanes]
        source, far_off = believed(self.weighing.hypotheses, likelihoods, state.active, self.impossible)
        seen = _selected(lanes, source)
        suspected = self._elements_of(state.active)
        unread = [where(present(each), 0.0, count + 1.0) for each, count in zip(readings, state.unread, strict=True)]
        open_, widening = self._open(unread, suspected)
        follows = both(seen.moving, negated(self._slides(sample.sample.lateral_acceleration)))
        tells = [both(told, each) for told, each in zip(self._tells(seen, follows), open_, strict=True)]
        weights = self.weighing.smoothed(state.weights, likelihoods, state.active, tells)
        ranking = self.weighing.ranking(weights, state.active, widening, open_)
        good = self._good(state.good, suspected, readings, seen, effects)
        kept = self._after_return(state.active, suspected, good)

        led, exceeded = self._counted(state, ranking)
        active = where(self._declares(ranking, led), ranking.best, kept)
        changed = negated(active == state.active)
        faulty = self._elements_of(active)
        after = DecisionState(
            map_leaves(lambda each: where(changed, 0.0, each), weights),
            active,
            where(changed, 0.0, ranking.best),
            where(changed, 0.0, led),
            where(changed, 0.0, exceeded),
            Elements(
                *(where(both(each, negated(changed)), count, 0.0) for each, count in zip(faulty, good, strict=True))
            ),
            Readings(*unread),
        )
        gated = self._gated(readings, seen, faulty)
        output = Diagnosis(
            active,
            faulty,
            self._candidates(ranking.rivals, both(exceeded >= self.samples, negated(changed)), faulty),
            self._testable(lanes, suspected, seen, [both(follows, each) for each in open_]),
            self._recovering(faulty, good),
            gated,
            self._values(readings, seen, faulty, gated),
            seen.prediction,
            seen.deviation,
            seen.torque_loss,
            seen.loss_deviation,
            seen.speed,
            seen.lateral_speed,
            where(ranking.exceeding, ranking.best, active),
            where(ranking.exceeding, ranking.lead, 0.0),
        )
        nearest = kin(self.weighing.hypotheses, likelihoods, self.impossible)
        taken = where(changed, active, source)
        return after, Verdict(output, adopted(self.weighing.hypotheses, taken, nearest, far_off, changed))

    def _counted(self, state: DecisionState, ranking: Ranking) -> tuple[Any, Any]:
        """For how many samples in a row the best hypothesis has led by the gap, and any has been beyond its limit."""
        led = where(ranking.best == state.leading, state.led, 0.0) + 1.0
        led = where(both(ranking.exceeding, ranking.lead > self.weighing.limits.gap), led, 0.0)
        return led, where(ranking.exceeding, state.exceeded + 1.0, 0.0)

    def _declares(self, ranking: Ranking, led: Any) -> Any:
        """Whether the best hypothesis has led for long enough."""
        patient = any_of(0.0, *(ranking.best == k for k, each in enumerate(self.weighing.hypotheses) if each.actuators))
        return led >= where(patient, self.samples_of_actuators, self.samples)

    def _recovering(self, faulty: Elements, good: Sequence[Any]) -> Elements:
        """Declared, but as it should for the last samples."""
        hoped = self.hopes / self.weighing.sample_time
        return Elements(*(both(each, count > hoped) for each, count in zip(faulty, good, strict=True)))

    # -- hypotheses ----------------------------------------------------------------------------------------------

    def _slides(self, acceleration: Any) -> Any:
        """Whether the tyres may slide; not known without the acceleration."""
        return absolute(where(present(acceleration), acceleration, 0.0)) > self.cornering

    def _tells(self, seen: Any, follows: Any) -> list[Any]:
        """Whether this sample may speak for each hypothesis: nothing does unless `follows`, braked wheels may lock."""
        braked = both(follows, seen.driven)
        wheels = {name for name in SENSORS if name.startswith("wheel_speed")}
        return [braked if wheels & set(each.sensors) else follows for each in self.weighing.hypotheses]

    def _open(self, unread: Sequence[Any], suspected: Elements) -> tuple[list[Any], Any]:
        """Which hypotheses can be told with the sensors that are left, and the factor of all limits."""
        most = self.missing / self.weighing.sample_time
        gone = [where(count > most, 1.0, 0.0) for count in unread]
        newly = {name: both(gone[place], negated(suspected[place])) for place, name in enumerate(SENSORS)}
        enough = sum(gone[1:], gone[0]) <= len(SENSORS) - self.fewest
        open_ = []
        for each in self.weighing.hypotheses:
            needed = {*each.sensors, *(TOLD_BY[name] for name in each.actuators if name in TOLD_BY)}
            open_.append(all_of(enough, *(negated(newly[name]) for name in SENSORS if name in needed)))
        return open_, where(any_of(0.0, *newly.values()), self.poorer, 1.0)

    # -- elements ------------------------------------------------------------------------------------------------

    def _elements_of(self, number: Any) -> Elements:
        """What a hypothesis suspects."""
        return Elements(*(any_of(0.0, *(number == k for k in self._naming(name))) for name in ELEMENTS))

    def _naming(self, name: str) -> list[int]:
        return [k for k, each in enumerate(self.weighing.hypotheses) if name in each.suspects]

    def _candidates(self, rivals: Sequence[Any], unsure: Any, faulty: Elements) -> Elements:
        return Elements(
            *(
                all_of(unsure, negated(known), any_of(0.0, *(rivals[k] for k in self._naming(name))))
                for name, known in zip(ELEMENTS, faulty, strict=True)
            )
        )

    def _testable(self, lanes: Sequence[Any], suspected: Elements, seen: Any, open_: Sequence[Any]) -> Elements:
        """Whether a loss would show: a reading far enough from zero, a share of torque known well; and may be told."""
        flags = []
        for place, name in enumerate(ELEMENTS):
            number = self.weighing.number(name) or 0
            own = lanes[number]
            if name in SENSORS:
                away, deviation = (where(suspected[place], s[place], o[place]) for s, o in _pairs(seen, own))
                shows = absolute(away) > self.shows * deviation
            else:
                deviation = where(suspected[place], seen.loss_deviation, own.loss_deviation)
                shows = self.shows * deviation < 1.0
            flags.append(both(shows, open_[number]))
        return Elements(*(where(flag, 1.0, 0.0) for flag in flags))

    def _good(
        self, before: Elements, suspected: Elements, readings: Sequence[Any], seen: Any, effects: Tree
    ) -> tuple[Any, ...]:
        """For how many samples each suspect has been as it should; unbroken where its fault would not show."""
        counts = []
        for place, (name, count) in enumerate(zip(ELEMENTS, before, strict=True)):
            if name in SENSORS:
                prediction, deviation = seen.prediction[place], seen.deviation[place]
                right = absolute(readings[place] - prediction) < self.agrees * deviation
                effect = prediction if effects is None else effects[place]
                lost = where(absolute(prediction) > self.shows * deviation, self.doubtful, 0.0)
                worth = where(absolute(effect) > self.shows * deviation, 1.0, lost)
            else:
                right = seen.torque_loss < maximum(self.loss_recovered, seen.loss_deviation)
                worth = where(self.shows * seen.loss_deviation < 1.0, 1.0, 0.0)
            following = where(right, count + worth, 0.0)
            counts.append(where(suspected[place], following, 0.0))
        return tuple(counts)

    def _after_return(self, active: Any, suspected: Elements, good: Sequence[Any]) -> Any:
        """The active hypothesis without those that have recovered."""
        back = [
            both(each, count * self.weighing.sample_time >= self.recovers)
            for each, count in zip(suspected, good, strict=True)
        ]
        following = active
        for number, each in enumerate(self.weighing.hypotheses):
            for kept in ((), *((name,) for name in each.suspects if len(each.suspects) > 1)):
                target = self.weighing.number(*kept)
                gone = [back[ELEMENTS.index(name)] for name in each.suspects if name not in kept]
                if target is None or not gone:
                    continue
                stay = [negated(back[ELEMENTS.index(name)]) for name in kept]
                following = where(all_of(active == number, *gone, *stay), float(target), following)
        return following

    def _gated(self, readings: Sequence[Any], seen: Any, faulty: Elements) -> Readings:
        """Readings far off that belong to nobody declared."""
        return Readings(
            *(
                all_of(
                    negated(known),
                    present(reading),
                    absolute(where(present(reading), reading, 0.0) - prediction) > self.gate * deviation,
                )
                for reading, prediction, deviation, known in zip(
                    readings, seen.prediction, seen.deviation, faulty, strict=False
                )
            )
        )

    def _values(self, readings: Sequence[Any], seen: Any, faulty: Elements, gated: Readings) -> Readings:
        """What stands in for every sensor."""
        return Readings(
            *(
                where(all_of(present(reading), negated(known), negated(off)), reading, estimate)
                for reading, estimate, known, off in zip(readings, seen.estimate, faulty, gated, strict=False)
            )
        )


def judge(hypotheses: tuple[Hypothesis, ...], limits: Limits, sample_time: float = 0.01) -> Decision:
    """The judge over a bank of these hypotheses.

    Args:
        hypotheses: in the order of the lanes, healthy first
        limits: from calibration
        sample_time: [s]
    """
    return Decision(Weighing(hypotheses, limits, sample_time))


def _pairs(first: Any, second: Any) -> list[tuple[Any, Any]]:
    return [(first.prediction, second.prediction), (first.deviation, second.deviation)]


def _selected(lanes: Sequence[Any], number: Any) -> Any:
    """The output of one lane, by a number that is known at run time only."""
    columns = zip(*([leaf for _, leaf in leaves_of(lane)] for lane in lanes), strict=True)
    return rebuild(skeleton(LeaveOutFilter.Output), [chosen(column, number) for column in columns])
