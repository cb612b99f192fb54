"""Units that take the place of a plant: a trolley on two tracks of its own."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import maximum, sqrt, where
from tierod.export.fmu_archive import write_unit
from tierod.export.fmu_description import Model
from tierod.export.interface import Interface, Options
from tierod.export.subject import subject_of_block
from tierod_lab.ground.run import usual_inputs

STEP = 0.002


class Rolling(NamedTuple):
    speed: Scalar
    lateral: Scalar
    yaw_rate: Scalar
    time: Scalar


@dataclass(frozen=True)
class Trolley:
    """A linear single-track car: angle in degrees, right is positive, speed in km/h, as others have it."""

    mass: Annotated[float, "kg"] = 1500.0
    v0: Annotated[float, "m/s"] = 10.0
    lasts: Annotated[float, "s"] = 1e9
    step_time: Annotated[float, "s"] = STEP

    class Sample(NamedTuple):
        steer_angle_deg: Annotated[Scalar, "deg"]
        long_force: Annotated[Scalar, "N"]

    class Output(NamedTuple):
        v_kmh: Annotated[Scalar, "km/h"]
        yaw_rate_deg_s: Annotated[Scalar, "deg/s"]
        lateral_speed: Annotated[Scalar, "m/s"]

    def init(self) -> Rolling:
        return Rolling(self.v0, 0.0, 0.0, 0.0)

    def step(self, state: Rolling, sample: Sample) -> tuple[Rolling, Output]:
        stiffness, front, rear, inertia = 1.2e5, 1.2, 1.5, 2500.0
        steer = -sample.steer_angle_deg * 0.017453292519943295 / 15.0
        speed = maximum(state.speed, 1.0)
        ahead = stiffness * (steer - (state.lateral + front * state.yaw_rate) / speed)
        behind = -stiffness * (state.lateral - rear * state.yaw_rate) / speed
        left = sqrt(self.lasts - state.time)
        after = Rolling(
            maximum(state.speed + self.step_time * sample.long_force / self.mass, 0.0),
            state.lateral + self.step_time * ((ahead + behind) / self.mass - speed * state.yaw_rate),
            state.yaw_rate + self.step_time * (front * ahead - rear * behind) / inertia,
            state.time + self.step_time,
        )
        speed = where(left > -1.0, state.speed, left)
        shown = self.Output(3.6 * speed, -57.29577951308232 * state.yaw_rate, state.lateral)
        return after, shown


PLANT = """
fmu = "trolley.fmu"
start_speed = "v0"
values = { lasts = LASTS }

[inputs]
steer_angle_deg = { signal = "steering_wheel_angle", sign = -1 }
long_force = "drive_force"

[outputs]
vehicle_speed = "v_kmh"
yaw_rate = { variable = "yaw_rate_deg_s", sign = -1 }
lateral_speed = "lateral_speed"
"""


def exported(block, path):
    """A block as a plant, in a unit."""
    subject = subject_of_block("plant", block, 1.0 / block.step_time, type(block).__name__)
    options = Options("double", libm=False, fused=True)
    starts = usual_inputs(block)
    return write_unit(Model(Interface(subject, options), starts, present=True), path)
