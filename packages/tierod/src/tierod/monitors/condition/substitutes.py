"""Substitutes of every sensor: the filter of the other sensors, and algebraic relations in its absence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.graph.maths import maximum
from tierod.diagnosis.substitution import SubstitutionGraph, graph_from
from tierod.diagnosis.switchover import SupplyState, Switchover
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.models.rolling_car import RollingCar
from tierod.monitors.condition.signals import (
    OF_AUTOMATED,
    OF_CARS,
    SENSOR_TABLE,
    CarParameters,
    ConditionSample,
    Readings,
)
from tierod.physics.central_axis import rolling_yaw_rate
from tierod.vehicles import Vehicle

FILTER = "filter-of-the-others"
"""Name of the substitute by the bank: the filter that leaves out all faulty elements."""
LEAST_SPEED = 1.0
"""Lower bound of the speed as a divisor [m/s]."""
GROWTH = {each.name: each.growth for each in SENSOR_TABLE}
"""Growth of the error of a held value, from usual rates of change [unit of the signal per s]."""
FADE = 0.2
"""Time constant of the transition between two fault-free sources [s]: far longer than a sample, shorter than a turn."""

_OF_CARS = {"name": FILTER, "needs": [], "source": "fault-free beginnings of the recordings of two real cars"}


@lru_cache(maxsize=4)
def substitution_graph(calibrated: bool = True, filters: bool = True) -> SubstitutionGraph:
    """Substitutes of every sensor, the best first, with their measured errors.

    Args:
        calibrated: whether the errors are those of calibrated vehicles, or of a vehicle without calibration
        filters: whether there is a bank with the filter of the other sensors; rules have none
    """
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
    """Row of a substitute with the error that applies."""
    kept = {key: value for key, value in row.items() if key != "uncalibrated"}
    return kept if calibrated else {**kept, "deviation": row["uncalibrated"]}


def plain_relations(readings: ConditionSample, vehicle: CarParameters) -> dict[str, dict[str, Scalar]]:
    """Substitutes by algebraic relations: sensor -> name of the substitute -> value [unit of the sensor].

    Args:
        readings: a `ConditionSample`
        vehicle: parameters of `AutomatedVehicle` or `RollingCar`

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
    """Supply every sensor's signal: its own reading, or the best substitute that is available.

    Args:
        switchover: switchover with the graph of substitutes
        vehicle: parameters of `AutomatedVehicle` or `RollingCar`
    """

    switchover: Switchover
    vehicle: CarParameters

    class Sample(NamedTuple):
        """Readings and targets, flags of declared sensors, and the values of all sensors by the filters."""

        readings: ConditionSample
        faulty: Readings
        filtered: Readings

    @classmethod
    def of_car(cls, parameters: RollingCar.Parameters, sample_time: float = 0.01) -> Reconfiguration:
        """Reconfiguration of a car: the filter of the other sensors alone, with its errors on two real cars.

        Args:
            parameters: parameters of `RollingCar`
            sample_time: sampling interval [s]
        """
        return cls(_switchover(graph_of_cars(), sample_time), parameters)

    @classmethod
    def of_vehicle(
        cls, vehicle: Vehicle, sample_time: float = 0.01, calibrated: bool = True, filters: bool = True
    ) -> Reconfiguration:
        """Reconfiguration of a whole vehicle by the shipped graph of substitutes.

        Args:
            vehicle: vehicle with the parameters of `AutomatedVehicle`
            sample_time: sampling interval [s]
            calibrated, filters: see `substitution_graph`

        Raises:
            ParameterError: parameters are missing
        """
        switchover = _switchover(substitution_graph(calibrated, filters), sample_time)
        return cls(switchover, vehicle.parameters_for(AutomatedVehicle.Parameters))

    @property
    def Output(self) -> type:
        """Supplied signal of every sensor."""
        return self.switchover.Output

    def init(self) -> tuple[SupplyState, ...]:
        """State before the first sample."""
        return self.switchover.init()

    def step(self, state: tuple[SupplyState, ...], sample: Sample) -> tuple[tuple[SupplyState, ...], Tree]:
        """Process one sample."""
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
