"""A small car for faults: ports, an actuator, parameters with ranges, a road, and channels."""

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.block import named_tuple
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod_lab.ground.parts import Demand, Road, pass_through, ports_type
from tierod_lab.ground.sensors import Sensor, SensorSet

PORTS = ("driver_torque", "vehicle_speed", "motor_torque")


class Output(NamedTuple):
    yaw_rate: Annotated[Any, "rad/s"]
    driver_torque: Annotated[Any, "N*m"]
    motor_torque: Annotated[Any, "N*m"]
    vehicle_speed: Annotated[Any, "m/s"]
    sideslip_angle: Annotated[Any, "rad"]
    truth_distance: Annotated[Any, "m"]
    truth_speed: Annotated[Any, "m/s"]


@dataclass(frozen=True)
class Motor:
    lag: Annotated[float, "s", POSITIVE] = 0.002


@dataclass(frozen=True)
class Steering:
    level: Annotated[float, "N*m", NOT_NEGATIVE] = 4.0
    motor: Motor = field(default_factory=Motor)

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("motor_torque",)


@dataclass(frozen=True)
class Car:
    steering: Steering = field(default_factory=Steering)
    mass: Annotated[float, "kg", POSITIVE] = 1600.0
    step_time: float = 1e-3

    Sample = named_tuple("Sample", [("road", Road), ("demand", Demand), ("ports", ports_type(PORTS))])

    def init(self) -> Any:
        return (0.0, 0.0, 0.0, 0.0)

    def step(self, state: Any, sample: Any) -> tuple[Any, Output]:
        distance, *held = state
        torque = 100.0 * sample.road.curvature + self.steering.level
        kept_torque, torque_read = pass_through(sample.ports.driver_torque, held[0], torque)
        kept_speed, _ = pass_through(sample.ports.vehicle_speed, held[1], sample.demand.speed)
        kept_motor, motor = pass_through(sample.ports.motor_torque, held[2], 2.0 * torque_read)
        output = Output(
            sample.demand.speed * sample.road.curvature,
            torque,
            motor,
            sample.demand.speed,
            sample.road.bank_angle,
            distance,
            sample.demand.speed,
        )
        return (distance + sample.demand.speed * self.step_time, kept_torque, kept_speed, kept_motor), output


SENSORS = SensorSet(
    {
        "yaw_rate": Sensor(),
        "driver_torque": Sensor(),
        "motor_torque": Sensor(),
        "vehicle_speed": Sensor(quantum=0.5, rate=50.0, saturation=(0.0, 100.0)),
    }
)
