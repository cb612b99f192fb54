"""Reaction to the statements about sensors and actuators: substitutes of sensors, and debounced trouble codes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple, get_type_hints

from tierod.core.block import Scalar, Tree, named_tuple
from tierod.core.findings import Status
from tierod.core.graph.maths import any_of, both, maximum, present, where
from tierod.core.statuses import code_of
from tierod.diagnosis.switchover import NOTHING, SubstitutionGraph, Supplied, SupplyState, Switchover, graph_from
from tierod.diagnosis.trouble_codes import DebounceCounter, DebounceCounters, TroubleCodes, load_trouble_codes
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.models.single_track import RollingCar
from tierod.monitors.condition.signals import (
    ELEMENTS,
    OF_AUTOMATED,
    OF_CARS,
    SENSOR_TABLE,
    SENSORS,
    CarParameters,
    ConditionSample,
    Elements,
    Readings,
    Statements,
    readings_of,
)
from tierod.physics.motion import rolling_yaw_rate
from tierod.vehicles import Vehicle

FILTER = "filter-of-the-others"  # name of the substitute by the bank: the filter that leaves out all faulty elements
LEAST_SPEED = 1.0  # lower bound of the speed as a divisor [m/s]
GROWTH = {each.name: each.growth for each in SENSOR_TABLE}
"""Growth of the error of a held value, from usual rates of change [unit of the signal per s]."""
FADE = 0.2
"""Time constant of the transition between two fault-free sources [s]: far longer than a sample, shorter than a turn."""

_OF_CARS = {"name": FILTER, "needs": [], "source": "fault-free beginnings of the recordings of two real cars"}


@lru_cache(maxsize=4)
def substitution_graph(calibrated: bool = True, filters: bool = True) -> SubstitutionGraph:
    """Substitutes of every sensor, the best first, with their measured errors."""
    from tierod.core.toml import Document

    path = Path(__file__).with_name("substitutes.toml")
    table = Document.read(path, "table of substitutes").content
    return graph_from(
        {
            sensor: [_way(each, calibrated) for each in ways if filters or each["name"] != FILTER]
            for sensor, ways in table.items()
        }
    )


@lru_cache(maxsize=1)
def graph_of_cars() -> SubstitutionGraph:
    """Substitutes of the sensors of a car: the filter of the others alone, with its error on two real cars."""
    return graph_from(
        {each.name: [{**_OF_CARS, "deviation": each.error_on_cars}] for each in SENSOR_TABLE if each.name in OF_CARS}
    )


def _way(row: Mapping[str, Any], calibrated: bool) -> dict[str, Any]:
    kept = {key: value for key, value in row.items() if key != "uncalibrated"}
    return kept if calibrated else {**kept, "deviation": row["uncalibrated"]}


def plain_relations(readings: ConditionSample, vehicle: CarParameters) -> dict[str, dict[str, Scalar]]:
    """Substitutes by algebraic relations: sensor -> name of the substitute -> value [unit of the sensor].

    Validity: rolling rear tyres, gentle turns, and fault-free sensors on the right-hand side of the relation.
    Source: Li, Frey, Gauterin, eqs (7), (9), (30) to (33), (46), simplified and corrected.
    """
    left, right, yaw_rate, angle, torque, force = (getattr(readings, name) for name in OF_AUTOMATED)
    scale, track = vehicle.wheel_speed_scale, vehicle.track_width
    difference = vehicle.wheel_speed_difference
    from_left, from_right = left / (scale * (1.0 - 0.5 * difference)), right / (scale * (1.0 + 0.5 * difference))
    turning, steered = yaw_rate - vehicle.yaw_rate_offset, angle - vehicle.steering_wheel_angle_offset
    base = vehicle.front_distance + vehicle.rear_distance
    speed = 0.5 * (from_left + from_right)
    load = vehicle.mass / base
    understeer = load * (
        vehicle.rear_distance / vehicle.front_cornering_stiffness
        - vehicle.front_distance / vehicle.rear_cornering_stiffness
    )
    rolling = rolling_yaw_rate(vehicle.steering_ratio * steered, speed, base)
    by_angle = rolling / (1.0 + understeer * speed * speed / base)
    asked = readings.steering_motor_1_target_torque + readings.steering_motor_2_target_torque
    spring = vehicle.rack_ratio * vehicle.rack_stiffness * steered
    return {
        "wheel_speed_rear_left": {
            "other-wheel-and-yaw-rate": (from_right - track * turning) * scale * (1.0 - 0.5 * difference)
        },
        "wheel_speed_rear_right": {
            "other-wheel-and-yaw-rate": (from_left + track * turning) * scale * (1.0 + 0.5 * difference)
        },
        "yaw_rate": {
            "rear-wheels": (from_right - from_left) / track + vehicle.yaw_rate_offset,
            "steering-angle-and-speed": by_angle + vehicle.yaw_rate_offset,
        },
        "steering_wheel_angle": {
            "yaw-rate-and-speed": turning
            * (base + understeer * speed * speed)
            / (vehicle.steering_ratio * maximum(speed, LEAST_SPEED))
            + vehicle.steering_wheel_angle_offset
        },
        "steering_shaft_torque": {
            "targets-of-the-motors": asked + vehicle.steering_shaft_torque_offset,
            "tie-rod-force": vehicle.rack_ratio * (force - vehicle.tie_rod_force_offset + spring)
            + vehicle.steering_shaft_torque_offset,
        },
        "tie_rod_force": {
            "steering-torque": (torque - vehicle.steering_shaft_torque_offset) / vehicle.rack_ratio
            - spring
            + vehicle.tie_rod_force_offset
        },
    }


def _switchover(graph: SubstitutionGraph, sample_time: float) -> Switchover:
    return Switchover(graph, tuple(GROWTH[name] for name in graph.sensors), FADE, sample_time)


@dataclass(frozen=True)
class Reconfiguration:
    """Supply every sensor's signal: its own reading, or the best substitute that is available."""

    switchover: Switchover  # switchover with the graph of substitutes
    vehicle: CarParameters  # parameters of `AutomatedVehicle` or `RollingCar`

    class Sample(NamedTuple):
        """Readings and targets, flags of declared sensors, and the values of all sensors by the filters."""

        readings: ConditionSample
        faulty: Readings
        filtered: Readings

    @classmethod
    def of_car(cls, parameters: RollingCar.Parameters, sample_time: float = 0.01) -> Reconfiguration:
        """Reconfiguration of a car: the filter of the other sensors alone, with its errors on two real cars."""
        return cls(_switchover(graph_of_cars(), sample_time), parameters)

    @classmethod
    def of_vehicle(
        cls, vehicle: Vehicle, sample_time: float = 0.01, calibrated: bool = True, filters: bool = True
    ) -> Reconfiguration:
        """Reconfiguration of a whole vehicle by the shipped graph of substitutes."""
        switchover = _switchover(substitution_graph(calibrated, filters), sample_time)
        return cls(switchover, vehicle.parameters_for(AutomatedVehicle.Parameters))

    @property
    def Output(self) -> type:
        return self.switchover.Output

    def init(self) -> tuple[SupplyState, ...]:
        return self.switchover.init()

    def step(self, state: tuple[SupplyState, ...], sample: Sample) -> tuple[tuple[SupplyState, ...], Tree]:
        relations = plain_relations(sample.readings, self.vehicle)
        graph = self.switchover.graph
        offered = []
        for sensor, ways in zip(graph.sensors, graph.ways, strict=True):
            values = relations.get(sensor, {}) | {FILTER: getattr(sample.filtered, sensor)}
            own = getattr(sample.readings, sensor), getattr(sample.faulty, sensor)
            offered.append((*own, *(values[way.name] for way in ways)))
        offer = self.switchover.Sample
        kinds = list(offer.__annotations__.values())
        return self.switchover.step(state, offer(*(kind(*each) for kind, each in zip(kinds, offered, strict=True))))


LEAST_DOUBT = 0.5
"""Shortest doubt between several elements that is reported [s]; a shorter one usually precedes a verdict."""

EVIDENCE = "evidence_for_a_fault"  # name of the trace with the evidence by which a fault is declared
NOT_ISOLABLE = "condition-not-isolable"  # trouble code of a fault that is detected but not isolated

CODES = (*(name.replace("_", "-") for name in ELEMENTS), NOT_ISOLABLE)
"""Names of the trouble codes with a debounce counter."""

Codes: Any = named_tuple("Codes", [(name.replace("-", "_"), Annotated[float, ""]) for name in CODES])
"""Verdict on each trouble code: 1 failed, -1 passed, 0 none yet."""

Supplies: Any = named_tuple("Supplies", [(name, Supplied) for name in SENSORS])
"""Signal of every sensor, or its substitute, for other functions."""


class Judged(NamedTuple):
    """Judgement of any variant of the monitor at one sample."""

    statements: Statements  # statements about every sensor and actuator
    testable: Elements  # whether a fault of each would show now
    spread: Elements
    value: Readings  # value of every sensor: its reading where it is trusted, otherwise the estimate from the others
    gated: Readings  # flags of outlying readings that must not be used
    # evidence for a fault: for filters the lead of the most likely hypothesis over all others [nat per sample], for
    # rules the fulfilled share of the best rule's conditions
    lead: Annotated[Scalar, ""]
    low_grip: Annotated[Scalar, ""]  # whether tyres slide, so that no fault is declared
    # time from the start of the run until which the residuals supported a fault of each element [s]; negative without
    # evidence for one
    supported: Elements
    ended: Elements  # whether the residuals have contradicted each declared fault since then


ConditionOutput: Any = named_tuple(
    "ConditionOutput",
    [*get_type_hints(Judged, include_extras=True).items(), ("supplied", Supplies), ("codes", Codes)],
)
"""Output of every variant of the monitor: the judgement, the signal of every sensor or its substitute, and the
debounced verdicts for a fault memory."""


class ReactionState(NamedTuple):
    """State of substitutes and counters, and the number of consecutive samples with several elements in doubt."""

    supply: tuple[SupplyState, ...]
    counters: tuple[DebounceCounter.State, ...]
    doubted: Scalar


@dataclass(frozen=True)
class FaultReaction:
    """Supply every sensor's signal or its substitute, and debounce the trouble codes."""

    reconfiguration: Reconfiguration  # substitutes of the sensors; they do not use gated readings
    counters: DebounceCounters  # debounce counters of `CODES`, in their order
    sample_time: Annotated[float, "s"] = 0.01  # sampling interval [s]
    # time for which several elements must be in doubt before `NOT_ISOLABLE` fails
    least_doubt: Annotated[float, "s"] = LEAST_DOUBT

    @classmethod
    def of(
        cls, reconfiguration: Reconfiguration, sample_time: float = 0.01, codes: TroubleCodes | None = None
    ) -> FaultReaction:
        table = codes or load_trouble_codes()
        causes = tuple(
            tuple(sorted(CODES.index(each) for each in table.causes(name) if each in CODES)) for name in CODES
        )
        counters = DebounceCounters(tuple(table.codes[name].debounce for name in CODES), causes)
        return cls(reconfiguration, counters, sample_time)

    def init(self) -> ReactionState:
        return ReactionState(self.reconfiguration.init(), self.counters.init(), 0.0)

    def step(
        self, state: ReactionState, sample: ConditionSample, judged: Judged
    ) -> tuple[ReactionState, ConditionOutput]:
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
