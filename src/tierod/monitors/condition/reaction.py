"""Reactions to the statements about sensors and actuators: substitutes of sensors, and debounced trouble codes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, named_tuple
from tierod.core.findings import Status
from tierod.core.graph.maths import any_of, both, either, present, where
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
"""Doubt between several elements that ends sooner is on the way to a verdict, and not reported [s]."""

NOT_ISOLABLE = "condition-not-isolable"
"""Trouble code of a fault that shows and cannot be isolated."""

CODES = (*(name.replace("_", "-") for name in ELEMENTS), NOT_ISOLABLE)
"""Trouble codes that are counted, by name."""

Codes: Any = named_tuple("Codes", [(name.replace("-", "_"), Annotated[float, ""]) for name in CODES])
"""A verdict for each trouble code: 1 failed, -1 passed, 0 none yet."""

Supplies: Any = named_tuple("Supplies", [(name, Supplied) for name in SENSORS])
"""Every sensor's signal as others may use it."""


class Judged(NamedTuple):
    """Output of any variant of the monitor at one sample.

    Args:
        statements: about every sensor and actuator
        testable: whether a fault of each would show now
        value: of every sensor, its own where it is trusted, otherwise the estimate from the others
        gated: readings that are too far off to be used, declared or not
        lead: what a fault is declared by: of filters the lead of the likeliest hypothesis over all others [nat per
            sample], of rules the share of what the best one asks that holds
        low_grip: whether tyres slide, so that no fault is declared
    """

    statements: Statements
    testable: Elements
    value: Readings
    gated: Readings
    lead: Annotated[Scalar, ""]
    low_grip: Annotated[Scalar, ""]


class ConditionOutput(NamedTuple):
    """Output of every variant of the monitor: all of `Judged`, and the reaction to it.

    Args:
        statements, testable, value, gated, lead, low_grip: see `Judged`
        supplied: every sensor's signal as others may use it
        codes: debounced verdicts for a fault memory
    """

    statements: Statements
    testable: Elements
    value: Readings
    gated: Readings
    lead: Annotated[Scalar, ""]
    low_grip: Annotated[Scalar, ""]
    supplied: Supplies
    codes: Codes


class Since(NamedTuple):
    """The status of every element at the sample before, and the time from which on it holds.

    Args:
        time: since the start of the run [s]
        status: codes; -1 before the first sample
        began: time from which on each holds; negative where it holds since the start [s]
    """

    time: Scalar
    status: Elements
    began: Elements

    @classmethod
    def initial(cls) -> Since:
        """Before the first sample."""
        unknown = Elements(*(-1.0,) * len(ELEMENTS))
        return cls(0.0, unknown, unknown)

    def followed_by(self, statements: Statements, sample_time: Scalar) -> tuple[Since, Statements]:
        """One sample on: the next memory, and the statements with the time from which on each holds.

        Args:
            statements: without that time
            sample_time: [s]
        """
        began = Elements(
            *(
                where(either(each.status == before, before < 0.0), start, self.time)
                for each, before, start in zip(statements, self.status, self.began, strict=True)
            )
        )
        dated = Statements(*(each._replace(since=start) for each, start in zip(statements, began, strict=True)))
        return Since(self.time + sample_time, Elements(*(each.status for each in statements)), began), dated


class ReactionState(NamedTuple):
    """State of substitutes and counters, and the number of samples in a row with several elements in doubt."""

    supply: tuple[SupplyState, ...]
    counters: tuple[DebounceCounter.State, ...]
    doubted: Scalar


@dataclass(frozen=True)
class FaultReaction:
    """Supply every sensor's signal, and count the trouble codes.

    Args:
        reconfiguration: of the sensors; a gated reading is supplied to nothing
        counters: of `CODES`, in their order
        sample_time: [s]
        least_doubt: for which several must be in doubt before that counts as a fault of one of them
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
            reconfiguration: of the sensors
            sample_time: [s]
            codes: the table; the shipped one if None
        """
        table = codes or load_trouble_codes()
        causes = tuple(
            tuple(sorted(CODES.index(each) for each in table.causes(name) if each in CODES)) for name in CODES
        )
        counters = DebounceCounters(tuple(table.codes[name].debounce for name in CODES), causes)
        return cls(reconfiguration, counters, sample_time)

    def init(self) -> ReactionState:
        """Nothing supplied, nothing counted."""
        return ReactionState(self.reconfiguration.init(), self.counters.init(), 0.0)

    def step(
        self, state: ReactionState, sample: ConditionSample, judged: Judged
    ) -> tuple[ReactionState, ConditionOutput]:
        """One sample on.

        Args:
            state: after the sample before
            sample: of the vehicle
            judged: by the variant, of this sample
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
        trusted = [where(far > 0.5, math.inf, reading) for far, reading in zip(judged.gated, readings, strict=True)]
        faulty = [each.status == code_of(Status.FAULT) for each in judged.statements[: len(SENSORS)]]
        readings = sample._replace(**dict(zip(SENSORS, trusted, strict=True)))
        flags = Readings(*(where(each, 1.0, 0.0) for each in faulty))
        after, supplied = self.reconfiguration.step(state, Reconfiguration.Sample(readings, flags, judged.value))
        return after, Supplies(*(getattr(supplied, name, Supplied(0.0, 0.0, NOTHING)) for name in SENSORS))

    def _results(self, sample: ConditionSample, judged: Judged, doubted: Scalar) -> Sequence[Scalar]:
        """Result of every code: 1 failed, -1 passed, 0 none; a code that could not have shown a fault does not pass."""
        results, readings = [], readings_of(sample)
        for place, each in enumerate(judged.statements):
            healthy = each.status == code_of(Status.HEALTHY)
            passed = both(healthy, present(readings[place])) if place < len(SENSORS) else healthy
            results.append(where(each.status == code_of(Status.FAULT), 1.0, where(passed, -1.0, 0.0)))
        lasting = doubted * self.sample_time >= self.least_doubt
        agree = both(doubted < 0.5, any_of(0.0, *judged.testable))
        return [*results, where(lasting, 1.0, where(agree, -1.0, 0.0))]
