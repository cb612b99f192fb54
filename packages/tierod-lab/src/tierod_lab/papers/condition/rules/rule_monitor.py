"""The rules as a monitor: residuals, thresholds, symptoms, and the status of every sensor and actuator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import (
    absolute,
    all_of,
    any_of,
    both,
    either,
    greatest_of,
    minimum,
    negated,
    present,
    where,
)
from tierod.core.statuses import Statement, Status, code_of
from tierod.monitors.condition.judge import Residual, SpanOfFault, Spans
from tierod.monitors.condition.reaction import ConditionOutput, FaultReaction, Judged, ReactionState
from tierod.monitors.condition.signals import (
    ACTUATORS,
    ELEMENTS,
    OF_AUTOMATED,
    SENSORS,
    ConditionSample,
    Elements,
    Measured,
    Readings,
    Statements,
    readings_by,
)
from tierod_lab.papers.condition.rules.actuator_set import ActuatorSet, Repaired, Targets, actuator_set
from tierod_lab.papers.condition.rules.calibration import ResidualCalibration
from tierod_lab.papers.condition.rules.diagnosis import RuleDiagnosis
from tierod_lab.papers.condition.rules.parameters import (
    ACTUATOR_RESIDUALS,
    RESIDUALS,
    SENSOR_RESIDUALS,
    ResidualParameters,
)
from tierod_lab.papers.condition.rules.readings import Excitation, ResidualThreshold
from tierod_lab.papers.condition.rules.residual_set import ResidualSet, residual_set
from tierod_lab.papers.condition.rules.symptoms import rules

MAIN = dict(zip(OF_AUTOMATED, ("r10", "r14", "r4", "r2", "r3", "r19"), strict=True))
"""Sensor -> main residual, which compares its reading with the expected one."""

HALF = 3.8
"""Residual in standard deviations that lies at its threshold [-]: half a threshold, which fault-free drives hardly
reach, is then as likely with as without a fault."""


@dataclass(frozen=True)
class RuleMonitor:
    """Status of six sensors and four actuators by rules.

    Args:
        sensors: residuals r1 to r19
        actuators: residuals r1a and following, from readings of which the faulty ones are replaced by expected ones
        sensor_thresholds, actuator_thresholds: one threshold for each residual, in their order

    Build it by `rule_monitor`.
    """

    sensors: ResidualSet
    actuators: ActuatorSet
    sensor_thresholds: tuple[ResidualThreshold, ...]
    actuator_thresholds: tuple[ResidualThreshold, ...]
    rules: RuleDiagnosis
    spans: SpanOfFault

    Sample = ConditionSample

    class State(NamedTuple):
        sensors: ResidualSet.State
        actuators: ActuatorSet.State
        rules: RuleDiagnosis.State
        faulty: tuple[Scalar, ...]
        spans: Spans

    Output = Judged

    @property
    def thresholds(self) -> dict[str, ResidualThreshold]:
        """Threshold of every residual by name."""
        return dict(zip(RESIDUALS, (*self.sensor_thresholds, *self.actuator_thresholds), strict=True))

    def init(self) -> State:
        return self.State(
            self.sensors.init(),
            self.actuators.init(),
            self.rules.init(),
            (0.0,) * len(OF_AUTOMATED),
            Spans.initial(),
        )

    def step(self, state: State, sample: ConditionSample) -> tuple[State, Judged]:
        sensors, seen = self.sensors.step(state.sensors, sample)
        expected = self._expected(seen)
        not_testable = self._not_testable(seen, expected)
        # With the verdict of the last sample, since that of this one depends on the residuals of the actuators.
        repaired = self._repaired(state.faulty, seen, expected)
        targets = Targets(*(getattr(sample, name) for name in Targets._fields))
        actuators, driven = self.actuators.step(state.actuators, ActuatorSet.Sample(targets, repaired))
        ratios = _ratios(seen, self.sensor_thresholds, seen.excitation)
        ratios |= _ratios(driven, self.actuator_thresholds, seen.excitation)
        after, said = self.rules.step(
            state.rules, self.rules.Sample(*(ratios[name] for name in self.rules.table.residuals))
        )
        faulty = tuple(getattr(said.faulty, name, 0.0) for name in OF_AUTOMATED)
        settled = {name: each > self.sensors.settling for name, each in sensors.there._asdict().items()}
        unexplained = _exceeding(ratios, settled)
        spans, statements = state.spans.followed_by(
            self._statements(said, not_testable, unexplained), self._residuals(ratios, seen), self.spans
        )
        seen_now = {name: 1.0 - each for name, each in zip(OF_AUTOMATED, not_testable, strict=True)}
        testable = Elements(*(seen_now.get(name, 0.0 if name in SENSORS else 1.0) for name in ELEMENTS))
        scores = greatest_of(*(each.evidence for each in statements))
        judged = Judged(
            *(statements, testable, Elements(*(0.0,) * len(ELEMENTS)), expected, readings_by({}), scores, 0.0),
            *(spans.supported, spans.ended(self.spans)),
        )
        return self.State(sensors, actuators, after, faulty, spans), judged

    def _residuals(self, ratios: dict[str, Scalar], seen: ResidualSet.Output) -> dict[str, Residual]:
        """Main residual of every sensor, and the smallest of all that the rule of an actuator takes as abnormal."""
        found = {
            name: Residual(HALF * ratios[MAIN[name]], present(ratios[MAIN[name]]), reading=reading)
            for name, reading in zip(OF_AUTOMATED, seen.held, strict=False)
        }
        for rule in self.rules.table.rules:
            if rule.fault in ACTUATORS and rule.raised:
                least = reduce(minimum, (absolute(ratios[name]) for name in sorted(rule.raised)))
                found[rule.fault] = Residual(HALF * least, present(least))
        return found

    def _statements(self, said: RuleDiagnosis.Output, not_testable: Sequence[Scalar], exceeding: Scalar) -> Statements:
        """Status and score of every element; rules estimate neither kind nor magnitude.

        Every element is a candidate while a residual exceeds its limit and no rule explains it.
        """
        made = []
        # A single candidate is no explanation either: its rule does not hold.
        explained = either(any_of(0.0, *said.faulty), sum(said.candidates, 0.0) > 1.5)
        unexplained = both(exceeding, negated(explained))
        known = (*OF_AUTOMATED, *ACTUATORS)
        blinded = dict(zip(OF_AUTOMATED, not_testable, strict=True))
        for name in ELEMENTS:
            # Sensors that the rules do not use, such as front wheels, are never testable; actuators always are.
            blind = blinded.get(name, 0.0 if name in ACTUATORS else 1.0)
            # An element without a rule is never declared.
            faulty, candidate, score = (getattr(each, name, 0.0) for each in said[:3])
            quiet = where(blind > 0.5, code_of(Status.NOT_TESTABLE), code_of(Status.HEALTHY))
            suspect = either(candidate > 0.5, both(unexplained, 1.0 if name in known else 0.0))
            status = where(faulty > 0.5, code_of(Status.FAULT), where(suspect, code_of(Status.SUSPECT), quiet))
            made.append(Statement(status, 0.0, 0.0, 0.0, 0.0, score))
        return Statements(*made)

    def _expected(self, seen: ResidualSet.Output) -> Readings:
        """Expected reading of each sensor: its reading plus its main residual, or its reading where that is missing."""
        # Not strict: the two accelerations at the end of the readings are not judged.
        readings = dict(zip(OF_AUTOMATED, seen.held, strict=False))
        return readings_by(
            {
                name: where(
                    getattr(seen.there, MAIN[name]) > 0.5,
                    readings[name] + getattr(seen.residuals, MAIN[name]),
                    readings[name],
                )
                for name in OF_AUTOMATED
            }
        )

    def _repaired(self, faulty: Sequence[Scalar], seen: ResidualSet.Output, expected: Readings) -> Repaired:
        values = seen.held._asdict()
        values |= {
            name: where(wrong > 0.5, getattr(expected, name), values[name])
            for name, wrong in zip(OF_AUTOMATED, faulty, strict=True)
        }
        return Repaired(Measured(**values), seen.motion, seen.held.steering_shaft_torque, seen.residuals.r19)

    def _not_testable(self, seen: ResidualSet.Output, expected: Readings) -> list[Scalar]:
        """Flag of each sensor whose loss would not show.

        Reading and expected reading are within the threshold of the main residual, or that residual is missing.
        """
        names = [each.name for each in SENSOR_RESIDUALS]
        flags: list[Scalar] = []
        for name, reading in zip(OF_AUTOMATED, seen.held, strict=False):
            main = MAIN[name]
            bound = self.sensor_thresholds[names.index(main)].at(seen.excitation)
            near = all_of(
                getattr(seen.there, main) > 0.5,
                absolute(getattr(expected, name)) < bound,
                absolute(reading) < bound,
            )
            flags.append(where(near, 1.0, where(getattr(seen.there, main) > 0.5, 0.0, 1.0)))
        return flags


def _ratios(
    seen: ResidualSet.Output | ActuatorSet.Output, thresholds: tuple[ResidualThreshold, ...], excitation: Excitation
) -> dict[str, Scalar]:
    """Ratios of the residuals to their thresholds; infinite, which counts as missing, where one is not present.

    A residual that was never present on fault-free drives has an infinite threshold; it is neither normal nor abnormal.
    """
    return {
        name: where(both(there > 0.5, present(threshold.base)), threshold.ratio(value, excitation), _ABSENT)
        for name, value, there, threshold in zip(
            seen.residuals._fields, seen.residuals, seen.there, thresholds, strict=True
        )
    }


def _exceeding(ratios: Mapping[str, Scalar], settled: Mapping[str, Scalar]) -> Scalar:
    """Whether any residual exceeds its limit; one without a signal, or whose filters have just begun, does not."""
    found = []
    for name, ratio in ratios.items():
        sensors = [settled[each] for each in RESIDUALS[name].signals if each in settled]
        found.append(all_of(present(ratio), absolute(ratio) > 1.0, *sensors))
    return any_of(0.0, *found)


_ABSENT = float("inf")


@dataclass(frozen=True)
class RulesWithReaction:
    """The rules as a variant of the monitor, with the reaction to their statements."""

    monitor: RuleMonitor  # the rules
    reaction: FaultReaction  # substitutes of the sensors and trouble codes

    Sample = ConditionSample
    Output = ConditionOutput

    class State(NamedTuple):
        monitor: RuleMonitor.State
        reaction: ReactionState

    def init(self) -> State:
        return self.State(self.monitor.init(), self.reaction.init())

    def step(self, state: State, sample: ConditionSample) -> tuple[State, ConditionOutput]:
        monitor, judged = self.monitor.step(state.monitor, sample)
        reaction, output = self.reaction.step(state.reaction, sample, judged)
        return self.State(monitor, reaction), output


def rule_monitor(
    car: ResidualParameters,
    calibration: ResidualCalibration,
    variant: str = "rules",
    sample_time: float = 0.01,
) -> RuleMonitor:
    """A variant of the rules for a vehicle.

    Args:
        calibration: calibration of `calibrate_residuals`, whose `printed` suits the variant
        variant: "rules", "rules-printed", "rules-discriminating", or the path of a rule file
        sample_time: sampling interval [s]
    """
    known = calibration.coefficients
    return RuleMonitor(
        residual_set(car, known, sample_time, calibration.printed),
        actuator_set(car, known, sample_time),
        tuple(calibration.thresholds[each.name] for each in SENSOR_RESIDUALS),
        tuple(calibration.thresholds[each.name] for each in ACTUATOR_RESIDUALS),
        RuleDiagnosis(rules(variant), sample_time, (OF_AUTOMATED, ACTUATORS)),
        SpanOfFault(sample_time, lasting=True),
    )
