"""Reaction to the statements about sensors and actuators: substitutes of sensors, and debounced trouble codes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, named_tuple
from tierod.core.findings import Status
from tierod.core.graph.maths import any_of, both, present, where
from tierod.core.statement import code_of
from tierod.diagnosis.debounce import DebounceCounter, DebounceCounters
from tierod.diagnosis.switchover import NOTHING, Supplied, SupplyState
from tierod.diagnosis.trouble_codes import TroubleCodes, load_trouble_codes
from tierod.monitors.condition.signals import (
    ELEMENTS,
    SENSORS,
    ConditionSample,
    Elements,
    Readings,
    Statements,
    readings_of,
)
from tierod.monitors.condition.substitutes import Reconfiguration

LEAST_DOUBT = 0.5
"""Shortest doubt between several elements that is reported [s]; a shorter one usually precedes a verdict."""

NOT_ISOLABLE = "condition-not-isolable"
"""Trouble code of a fault that is detected but not isolated."""

CODES = (*(name.replace("_", "-") for name in ELEMENTS), NOT_ISOLABLE)
"""Names of the trouble codes with a debounce counter."""

Codes: Any = named_tuple("Codes", [(name.replace("-", "_"), Annotated[float, ""]) for name in CODES])
"""Verdict on each trouble code: 1 failed, -1 passed, 0 none yet."""

Supplies: Any = named_tuple("Supplies", [(name, Supplied) for name in SENSORS])
"""Signal of every sensor, or its substitute, for other functions."""


class Judged(NamedTuple):
    """Judgement of any variant of the monitor at one sample.

    Args:
        statements: statements about every sensor and actuator
        testable: whether a fault of each would show now
        spread: standard deviation of each reading less its prediction by the others, and of the lost share of each
            actuator's torque; 0 where a variant has none
        value: value of every sensor: its reading where it is trusted, otherwise the estimate from the others
        gated: flags of outlying readings that must not be used
        lead: evidence for a fault: for filters the lead of the most likely hypothesis over all others [nat per sample],
            for rules the fulfilled share of the best rule's conditions
        low_grip: whether tyres slide, so that no fault is declared
        supported: time from the start of the run until which the residuals supported a fault of each element [s];
            negative without evidence for one
        ended: whether the residuals have contradicted each declared fault since then
    """

    statements: Statements
    testable: Elements
    spread: Elements
    value: Readings
    gated: Readings
    lead: Annotated[Scalar, ""]
    low_grip: Annotated[Scalar, ""]
    supported: Elements
    ended: Elements


class ConditionOutput(NamedTuple):
    """Output of every variant of the monitor: the judgement, and the reaction to it.

    Args:
        statements, testable, spread, value, gated, lead, low_grip, supported, ended: see `Judged`
        supplied: signal of every sensor, or its substitute
        codes: debounced verdicts for a fault memory
    """

    statements: Statements
    testable: Elements
    spread: Elements
    value: Readings
    gated: Readings
    lead: Annotated[Scalar, ""]
    low_grip: Annotated[Scalar, ""]
    supported: Elements
    ended: Elements
    supplied: Supplies
    codes: Codes


class ReactionState(NamedTuple):
    """State of substitutes and counters, and the number of consecutive samples with several elements in doubt."""

    supply: tuple[SupplyState, ...]
    counters: tuple[DebounceCounter.State, ...]
    doubted: Scalar


@dataclass(frozen=True)
class FaultReaction:
    """Supply every sensor's signal or its substitute, and debounce the trouble codes.

    Args:
        reconfiguration: substitutes of the sensors; they do not use gated readings
        counters: debounce counters of `CODES`, in their order
        sample_time: sampling interval [s]
        least_doubt: time for which several elements must be in doubt before `NOT_ISOLABLE` fails
    """

    reconfiguration: Reconfiguration
    counters: DebounceCounters
    sample_time: Annotated[float, "s"] = 0.01
    least_doubt: Annotated[float, "s"] = LEAST_DOUBT

    @classmethod
    def of(
        cls, reconfiguration: Reconfiguration, sample_time: float = 0.01, codes: TroubleCodes | None = None
    ) -> FaultReaction:
        """Reaction with the debouncing of a table of trouble codes.

        Args:
            reconfiguration: substitutes of the sensors
            sample_time: sampling interval [s]
            codes: table of trouble codes; None takes the shipped one
        """
        table = codes or load_trouble_codes()
        causes = tuple(
            tuple(sorted(CODES.index(each) for each in table.causes(name) if each in CODES)) for name in CODES
        )
        counters = DebounceCounters(tuple(table.codes[name].debounce for name in CODES), causes)
        return cls(reconfiguration, counters, sample_time)

    def init(self) -> ReactionState:
        """State before the first sample: nothing supplied, nothing counted."""
        return ReactionState(self.reconfiguration.init(), self.counters.init(), 0.0)

    def step(
        self, state: ReactionState, sample: ConditionSample, judged: Judged
    ) -> tuple[ReactionState, ConditionOutput]:
        """Process one sample.

        Args:
            state: state after the previous sample
            sample: sample of the vehicle
            judged: judgement of the variant on this sample
        """
        supply, supplied = self._supplied(state.supply, sample, judged)
        suspected = [each.status == code_of(Status.SUSPECT) for each in judged.statements]
        doubted = where(any_of(0.0, *suspected), state.doubted + 1.0, 0.0)
        counters, codes = self.counters.step(
            state.counters, self.counters.Sample(*self._results(sample, judged, doubted))
        )
        output = ConditionOutput(*judged, Supplies(*supplied), Codes(*codes))
        return ReactionState(supply, counters, doubted), output

    def _supplied(
        self, state: tuple[SupplyState, ...], sample: ConditionSample, judged: Judged
    ) -> tuple[tuple[SupplyState, ...], Supplies]:
        readings = readings_of(sample)
        # An infinite reading counts as missing: no substitute must use it either.
        trusted = [where(far > 0.5, math.inf, reading) for far, reading in zip(judged.gated, readings, strict=True)]
        faulty = [each.status == code_of(Status.FAULT) for each in judged.statements[: len(SENSORS)]]
        readings = sample._replace(**dict(zip(SENSORS, trusted, strict=True)))
        flags = Readings(*(where(each, 1.0, 0.0) for each in faulty))
        after, supplied = self.reconfiguration.step(state, Reconfiguration.Sample(readings, flags, judged.value))
        return after, Supplies(*(getattr(supplied, name, Supplied(0.0, 0.0, NOTHING)) for name in SENSORS))

    def _results(self, sample: ConditionSample, judged: Judged, doubted: Scalar) -> Sequence[Scalar]:
        """Test result of every code: 1 failed, -1 passed, 0 none; without testability a code does not pass."""
        results, readings = [], readings_of(sample)
        for place, each in enumerate(judged.statements):
            healthy = each.status == code_of(Status.HEALTHY)
            passed = both(healthy, present(readings[place])) if place < len(SENSORS) else healthy
            results.append(where(each.status == code_of(Status.FAULT), 1.0, where(passed, -1.0, 0.0)))
        lasting = doubted * self.sample_time >= self.least_doubt
        agree = both(doubted < 0.5, any_of(0.0, *judged.testable))
        return [*results, where(lasting, 1.0, where(agree, -1.0, 0.0))]
