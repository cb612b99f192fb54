"""The rules at work: residuals, thresholds, symptoms, and what they say of every sensor and actuator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import named_tuple
from tierod.core.graph.maths import absolute, all_of, both, present, where
from tierod.diagnosis.rules import RuleDiagnosis
from tierod.monitors.condition.residuals.actuator_set import ActuatorSet, Repaired, Targets, actuator_set
from tierod.monitors.condition.residuals.calibration import ResidualCalibration
from tierod.monitors.condition.residuals.catalogue import ACTUATOR_RESIDUALS, SENSOR_RESIDUALS
from tierod.monitors.condition.residuals.parameters import ResidualParameters
from tierod.monitors.condition.residuals.readings import Measured
from tierod.monitors.condition.residuals.residual_set import ResidualSet, residual_set
from tierod.monitors.condition.residuals.thresholds import Excitation, ResidualThreshold
from tierod.monitors.condition.rule_files import rules
from tierod.monitors.condition.signals import ACTUATORS, SENSORS, ConditionSample

SensorStates: Any = named_tuple("SensorStates", [(name, Annotated[float, ""]) for name in SENSORS])
"""One number for each sensor."""

ActuatorStates: Any = named_tuple("ActuatorStates", [(name, Annotated[float, ""]) for name in ACTUATORS])
"""One number for each actuator."""

MAIN = dict(zip(SENSORS, ("r10", "r14", "r4", "r2", "r3", "r19"), strict=True))
"""The residual of every sensor that compares it to what it should read."""


@dataclass(frozen=True)
class RuleMonitor:
    """State of six sensors and four actuators by rules.

    Args:
        sensors: residuals r1 to r19
        actuators: residuals r1a and on, with sensors that are faulty replaced by what the models expect
        sensor_thresholds, actuator_thresholds: one for each residual, in their order
        rules: evaluated side by side

    Build it by `rule_monitor`.
    """

    sensors: ResidualSet
    actuators: ActuatorSet
    sensor_thresholds: tuple[ResidualThreshold, ...]
    actuator_thresholds: tuple[ResidualThreshold, ...]
    rules: RuleDiagnosis

    Sample = ConditionSample

    class State(NamedTuple):
        """Of the parts, and which sensors were faulty a sample ago."""

        sensors: Any
        actuators: Any
        rules: Any
        faulty: Any

    class Output(NamedTuple):
        """What is said of every sensor and actuator.

        Args:
            sensors, actuators: 1 where it is declared faulty
            sensor_candidates, actuator_candidates: 1 for each of several that are not told apart
            sensor_scores, actuator_scores: how well the symptoms fit a fault of it
            not_testable: 1 where a sensor reads nothing and nothing is expected, so that its loss could not be seen
            expected: what the models expect each sensor to read
        """

        sensors: SensorStates
        actuators: ActuatorStates
        sensor_candidates: SensorStates
        actuator_candidates: ActuatorStates
        sensor_scores: SensorStates
        actuator_scores: ActuatorStates
        not_testable: SensorStates
        expected: SensorStates

    def init(self) -> State:
        """At rest, all sound."""
        return self.State(
            self.sensors.init(),
            self.actuators.init(),
            self.rules.init(),
            SensorStates(*[0.0] * len(SENSORS)),
        )

    def step(self, state: State, sample: ConditionSample) -> tuple[State, Output]:
        """One sample on."""
        sensors, seen = self.sensors.step(state.sensors, sample)
        expected = self._expected(seen)
        repaired = self._repaired(state.faulty, seen, expected)
        targets = Targets(*(getattr(sample, name) for name in Targets._fields))
        actuators, driven = self.actuators.step(state.actuators, ActuatorSet.Sample(targets, repaired))
        ratios = _ratios(seen, self.sensor_thresholds, seen.excitation)
        ratios |= _ratios(driven, self.actuator_thresholds, seen.excitation)
        after, said = self.rules.step(
            state.rules, self.rules.Sample(*(ratios[name] for name in self.rules.table.residuals))
        )
        faulty = _in_order(SensorStates, said.faulty)
        output = self.Output(
            faulty,
            _in_order(ActuatorStates, said.faulty),
            _in_order(SensorStates, said.candidates),
            _in_order(ActuatorStates, said.candidates),
            _in_order(SensorStates, said.scores),
            _in_order(ActuatorStates, said.scores),
            self._not_testable(seen, expected),
            expected,
        )
        return self.State(sensors, actuators, after, faulty), output

    def _expected(self, seen: Any) -> Any:
        """What each sensor should read: its reading and what its main residual adds, the model alone for the rest."""
        readings = dict(zip(SENSORS, seen.held, strict=False))
        return SensorStates(
            *(
                where(
                    getattr(seen.there, MAIN[name]) > 0.5,
                    readings[name] + getattr(seen.residuals, MAIN[name]),
                    readings[name],
                )
                for name in SENSORS
            )
        )

    def _repaired(self, faulty: Any, seen: Any, expected: Any) -> Repaired:
        """The readings with those of faulty sensors replaced."""
        values = seen.held._asdict()
        values |= {name: where(getattr(faulty, name) > 0.5, getattr(expected, name), values[name]) for name in SENSORS}
        return Repaired(Measured(**values), seen.motion, seen.held.steering_shaft_torque, seen.residuals.r19)

    def _not_testable(self, seen: Any, expected: Any) -> Any:
        """Reading and expectation of each sensor, both within the threshold of its main residual."""
        names = [each.name for each in SENSOR_RESIDUALS]
        flags = []
        for name, reading in zip(SENSORS, seen.held, strict=False):
            main = MAIN[name]
            bound = self.sensor_thresholds[names.index(main)].at(seen.excitation)
            near = all_of(
                getattr(seen.there, main) > 0.5,
                absolute(getattr(expected, name)) < bound,
                absolute(reading) < bound,
            )
            flags.append(where(near, 1.0, where(getattr(seen.there, main) > 0.5, 0.0, 1.0)))
        return SensorStates(*flags)


def _ratios(seen: Any, thresholds: tuple[ResidualThreshold, ...], excitation: Excitation) -> dict[str, Any]:
    """How many thresholds each residual is away from zero; infinity, which is no number, where it is not there.

    One that no healthy drive has shown has an infinite threshold: it is neither normal nor abnormal.
    """
    return {
        name: where(both(there > 0.5, present(threshold.base)), threshold.ratio(value, excitation), _ABSENT)
        for name, value, there, threshold in zip(
            seen.residuals._fields, seen.residuals, seen.there, thresholds, strict=True
        )
    }


_ABSENT = float("inf")


def _in_order(states: Any, faults: Any) -> Any:
    """The numbers of a rule table in the order of all sensors or actuators; 0 for one that has no rule."""
    return states(*(getattr(faults, name, 0.0) for name in states._fields))


def rule_monitor(
    car: ResidualParameters,
    calibration: ResidualCalibration,
    variant: str = "rules",
    sample_time: float = 0.01,
) -> RuleMonitor:
    """A variant of the rules on a vehicle.

    Args:
        car: the vehicle
        calibration: from `calibrate_residuals`, with the same `printed`
        variant: "rules", "rules-printed", "rules-discriminating", or the path of a rule file
        sample_time: [s]
    """
    known = calibration.coefficients
    return RuleMonitor(
        residual_set(car, known, sample_time, calibration.printed),
        actuator_set(car, known, sample_time),
        tuple(calibration.thresholds[each.name] for each in SENSOR_RESIDUALS),
        tuple(calibration.thresholds[each.name] for each in ACTUATOR_RESIDUALS),
        RuleDiagnosis(rules(variant), sample_time, (SENSORS, ACTUATORS)),
    )
