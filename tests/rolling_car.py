"""A monitor whose result is known in closed form: the sideslip of a car that rolls without slip."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar
from tierod.core.facts import Verdict
from tierod.core.findings import Element, Estimate, Status
from tierod.monitors.session import BlockSession, Conclusion, Monitor, Variant
from tierod.vehicles import load

OWN = 0.01
"""The estimator's own standard deviation [rad]."""

MASS = 1700.0
"""Mass of the car [kg]."""


@dataclass(frozen=True)
class Geometry:
    """Sideslip of a car that rolls without slip: yaw rate times distance over speed."""

    rear_distance: Annotated[float, "m"]
    mass: Annotated[float, "kg"]

    class Sample(NamedTuple):
        yaw_rate: Annotated[Scalar, "rad/s"]
        vehicle_speed: Annotated[Scalar, "m/s"]

    class Output(NamedTuple):
        angle: Annotated[Scalar, "rad"]
        deviation: Annotated[Scalar, "rad"]

    def init(self) -> Scalar:
        return 0.0

    def step(self, state: Scalar, sample: Sample) -> tuple[Scalar, Output]:
        angle = self.rear_distance * sample.yaw_rate / sample.vehicle_speed
        return state, self.Output(angle, OWN + 0.0 * self.mass)


class GeometrySession(BlockSession):
    """Gives the largest angle; a fault above a limit, or by a misfit where no estimate is meant.

    With `laden`, the axle lies further behind the centre of gravity of a heavier car.
    """

    def __init__(self, vehicle, limit, misfit, laden):
        share = vehicle["mass"] / MASS if laden else 1.0
        super().__init__(
            Geometry(share * vehicle["rear_distance"], vehicle["mass"]),
            {"angle": ("angle", "rad"), "deviation": ("angle_standard_deviation", "rad")},
        )
        self.limit, self.misfit, self.largest = limit, misfit, 0.0

    def collect(self, time, signals, result):
        self.largest = max(self.largest, float(np.nanmax(result["angle"])))

    def conclude(self):
        faulty = self.largest > self.limit
        status = Status.FAULT if faulty else Status.HEALTHY
        estimate = None if self.misfit else Estimate("angle", self.largest, OWN, "rad", {"fault": self.limit})
        elements = (Element("yaw_rate", "sensor", status),)
        return Conclusion(Verdict("geometry", status, estimate=estimate), elements=elements)


def monitor(limit=9.0, misfit=False, laden=False):
    variant = Variant(
        "only", "One.", "none", lambda vehicle, rate, level: GeometrySession(vehicle, limit, misfit, laden)
    )
    return Monitor(
        "geometry", "Angle", "Angle.", "none", ("yaw_rate", "vehicle_speed"), (), 50.0, 10.0, 0.1, {"only": variant},
        "only",
    )  # fmt: skip


def car(rear_distance, deviation, mass_deviation=0.0):
    vehicle = load("revsted-car")
    parameters = dict(vehicle.parameters)
    for name, value, spread in (("rear_distance", rear_distance, deviation), ("mass", MASS, mass_deviation)):
        parameters[name] = dataclasses.replace(parameters[name], value=value, standard_deviation=spread)
    return dataclasses.replace(vehicle, parameters=parameters)
