"""All that runs on board, as one compiled block: bank of filters, rules, substitutes, counters of the fault memory."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Tree, named_tuple
from tierod.core.graph import Bank, JudgeSample, Verdict
from tierod.core.graph.maths import any_of, both, negated, present, where
from tierod.diagnosis.debounce import DebounceCounters
from tierod.diagnosis.trouble_codes import TroubleCodes, load_trouble_codes
from tierod.monitors.condition.bank.judge import ConditionJudge, Judgement
from tierod.monitors.condition.calibration.limits import has_own_limits
from tierod.monitors.condition.courses import LEAST_DOUBT
from tierod.monitors.condition.residuals.in_vehicle_file import calibration_of
from tierod.monitors.condition.residuals.parameters import ResidualParameters
from tierod.monitors.condition.rule_monitor import RuleMonitor, rule_monitor
from tierod.monitors.condition.signals import ELEMENTS, SENSORS
from tierod.monitors.condition.states import NOT_ISOLABLE
from tierod.monitors.condition.substitutes import Faulty, Filtered, Reconfiguration
from tierod.monitors.condition.vehicle_bank import bank_of
from tierod.vehicles import Vehicle

CODES = (*(name.replace("_", "-") for name in ELEMENTS), NOT_ISOLABLE)
"""Trouble codes that are counted, by name."""

Codes: Any = named_tuple("Codes", [(name.replace("-", "_"), Annotated[float, ""]) for name in CODES])
"""A verdict for each trouble code: 1 failed, -1 passed, 0 none yet."""


class OnBoard(NamedTuple):
    """What is said of one sample.

    Args:
        judgement: of the bank
        rules: of every rule monitor that runs beside it
        supplied: every sensor's signal as others may use it
        codes: debounced verdicts for the fault memory
    """

    judgement: Judgement
    rules: tuple[Any, ...]
    supplied: Any
    codes: Any


class OnBoardState(NamedTuple):
    """Of the parts, and for how many samples in a row several have been in doubt."""

    judge: Any
    rules: tuple[Any, ...]
    supplied: Any
    counters: Any
    doubted: Any


@dataclass(frozen=True)
class OnBoardJudge:
    """The judge over the bank, and all that follows from what it says.

    Args:
        judge: of the bank
        rules: monitors by rules that run beside it; what they say changes nothing else
        reconfiguration: of the sensors; a reading that is not believed is passed on to nobody
        counters: of `CODES`, in their order
        least_doubt: for which several must be in doubt before that counts as a fault of one of them
    """

    judge: ConditionJudge
    rules: tuple[RuleMonitor, ...]
    reconfiguration: Reconfiguration
    counters: DebounceCounters
    least_doubt: Annotated[float, "s"] = LEAST_DOUBT

    def feedback(self) -> Tree:
        """Lanes are told what the judge tells them."""
        return self.judge.feedback()

    def init(self) -> OnBoardState:
        """All sound, nothing supplied, nothing counted."""
        rules = tuple(each.init() for each in self.rules)
        return OnBoardState(self.judge.init(), rules, self.reconfiguration.init(), self.counters.init(), 0.0)

    def step(self, state: OnBoardState, sample: JudgeSample) -> tuple[OnBoardState, Verdict]:
        """One sample on."""
        judged, verdict = self.judge.step(state.judge, sample)
        judgement: Judgement = verdict.output
        ruled = [each.step(memory, sample.sample) for each, memory in zip(self.rules, state.rules, strict=True)]
        supplying, supplied = self._supplied(state.supplied, sample.sample, judgement)
        doubted = where(any_of(0.0, *judgement.decision.candidates), state.doubted + 1.0, 0.0)
        results = self._results(sample.sample, judgement, doubted)
        counting, codes = self.counters.step(state.counters, self.counters.Sample(*results))
        after = OnBoardState(judged, tuple(memory for memory, _ in ruled), supplying, counting, doubted)
        output = OnBoard(judgement, tuple(said for _, said in ruled), supplied, Codes(*codes))
        return after, verdict._replace(output=output)

    def _supplied(self, state: Any, sample: Any, judgement: Judgement) -> tuple[Any, Any]:
        decision = judgement.decision
        believed = {
            name: where(gated > 0.5, math.inf, getattr(sample, name))
            for name, gated in zip(SENSORS, decision.gated, strict=True)
        }
        faulty = Faulty(*(getattr(decision.faulty, name) for name in SENSORS))
        offered = Reconfiguration.Sample(sample._replace(**believed), faulty, Filtered(*decision.value))
        return self.reconfiguration.step(state, offered)

    def _results(self, sample: Any, judgement: Judgement, doubted: Any) -> list[Any]:
        """Of every code: 1 failed, -1 passed, 0 no result; nothing passes that could not have shown a fault."""
        decision = judgement.decision
        results = []
        for name in ELEMENTS:
            sound = both(getattr(decision.testable, name), negated(getattr(decision.candidates, name)))
            if name in SENSORS:
                sound = both(sound, present(getattr(sample, name)))
            results.append(where(getattr(decision.faulty, name), 1.0, where(sound, -1.0, 0.0)))
        lasting = doubted * self.judge.decision.weighing.sample_time >= self.least_doubt
        agree = both(doubted < 0.5, any_of(0.0, *decision.testable))
        return [*results, where(lasting, 1.0, where(agree, -1.0, 0.0))]


def on_board(
    vehicle: Vehicle, sample_time: float = 0.01, rules: Sequence[str] = ("rules",), codes: TroubleCodes | None = None
) -> Bank:
    """The whole monitor of a vehicle as one block.

    Args:
        vehicle: with the parameters of `AutomatedVehicle` and `ResidualParameters`
        sample_time: [s]
        rules: variants of the rules that run beside the bank, see `rule_monitor`
        codes: table of trouble codes; the shipped one if None

    Raises:
        ParameterError: parameters that are missing
    """
    bank, car = bank_of(vehicle, sample_time), vehicle.parameters_for(ResidualParameters)
    beside = tuple(
        rule_monitor(car, calibration_of(vehicle, name == "rules-printed"), name, sample_time) for name in rules
    )
    substitutes = Reconfiguration.of_vehicle(vehicle, sample_time, has_own_limits(vehicle))
    table = codes or load_trouble_codes()
    causes = tuple(tuple(sorted(CODES.index(each) for each in table.causes(name) if each in CODES)) for name in CODES)
    counters = DebounceCounters(tuple(table.codes[name].debounce for name in CODES), causes)
    return replace(bank, judge=OnBoardJudge(bank.judge, beside, substitutes, counters))
