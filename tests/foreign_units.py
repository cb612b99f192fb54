"""Units that take the place of a plant: a trolley on two tracks of its own, exported by us or by pythonfmu."""

import subprocess
import sys
import zipfile
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


def without_binary(path, target, platform="win64"):
    """The same unit for another platform."""
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            other = name.replace("binaries/linux64", f"binaries/{platform}").replace(".so", ".dll")
            new.writestr(other if name.startswith("binaries") else name, old.read(name))
    return target


OF_PYTHON = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Trolley(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.SteeringWheelAngle_deg, self.LongForce, self.v0, self.fails_at = 0.0, 0.0, 10.0, 1e9
        self.v_kmh, self.yawRate, self.vy = 36.0, 0.0, 0.0
        self.speed = self.lateral = self.rate = 0.0
        for name in ("SteeringWheelAngle_deg", "LongForce"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("v_kmh", "yawRate", "vy"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))
        for name in ("v0", "fails_at"):
            tunable = Fmi2Variability.tunable
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=tunable))

    def setup_experiment(self, start_time, stop_time=None, tolerance=None):
        pass

    def exit_initialization_mode(self):
        self.speed = self.v0
        self.show()

    def show(self):
        self.v_kmh, self.yawRate, self.vy = 3.6 * self.speed, self.rate, self.lateral

    def do_step(self, time, size):
        if time > self.fails_at:
            raise RuntimeError("the tyre left its range")
        steer, speed = self.SteeringWheelAngle_deg * 0.017453292519943295 / 15.0, max(self.speed, 1.0)
        front = 1.2e5 * (steer - (self.lateral + 1.2 * self.rate) / speed)
        rear = -1.2e5 * (self.lateral - 1.5 * self.rate) / speed
        self.lateral += size * ((front + rear) / 1500.0 - speed * self.rate)
        self.rate += size * (1.2 * front - 1.5 * rear) / 2500.0
        self.speed = max(self.speed + size * self.LongForce / 1500.0, 0.0)
        self.show()
        return True
"""


def of_python(folder):
    """The trolley as pythonfmu exports it."""
    (folder / "trolley.py").write_text(OF_PYTHON)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "trolley.py"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return folder / "Trolley.fmu"
