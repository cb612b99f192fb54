"""Sensors and actuators that are judged, the types made from them, the hypotheses of their faults, and their structure.

A further sensor needs a row of `SENSOR_TABLE`, an output of the vehicle's model, and a trouble code; substitutes and
checks of recordings have tables of their own."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from itertools import combinations, product
from typing import Annotated, Any, NamedTuple, TypeAlias

from tierod.core.block import Scalar, named_tuple
from tierod.core.errors import ParameterError, nearest
from tierod.core.signals import SIGNALS
from tierod.core.statuses import Statement
from tierod.methods.analysis.structure import Equation, StructuralModel, isolability, structure_of
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.models.single_track import RollingCar
from tierod.vehicles import Vehicle

CarParameters: TypeAlias = AutomatedVehicle.Parameters | RollingCar.Parameters
"""Parameters of a vehicle with known torques, or of a car that is judged by its motion alone."""


class Sensor(NamedTuple):
    """Sensor that is judged; every number is in the unit of its signal unless another one is given."""

    name: str  # name of its signal
    noise: float  # standard deviation of one reading; data sheets of production sensors, rounding included
    plausible: float  # width of the range in which a failed sensor may read
    growth: float  # growth of the error of a held value, from usual rates of change [unit per s]
    # root mean square error of the filter without the sensor, the larger of two real cars; for sensors that cars do not
    # have, which are never supplied, the usual change in one second
    error_on_cars: float
    # correlation time of the errors of its prediction [s]; from the variance of means over two or ten seconds, on
    # fault-free drives of three virtual demonstrators, it is 0.2 to 0.7 s for the yaw rate, 0.6 to 2.0 s for the angle,
    # and 0.05 s at most for all others. In a hard bend it is longer
    lasting: float = 0.1
    jumps: bool = False  # whether its signal has jumps, as the torque has with the requested torque of the motors


SENSOR_TABLE = (
    # The noise of a wheel includes the unevenness of the road, that of the angle its rounding to 0.1 degrees and the
    # unknown time of the reading within the sample; torque and force come from strain gauges.
    Sensor("wheel_speed_rear_left", 0.022, 30.0, 1.0, 0.051),
    Sensor("wheel_speed_rear_right", 0.022, 30.0, 1.0, 0.065),
    Sensor("yaw_rate", 0.0032, 4.0, 0.3, 0.019, lasting=1.0),
    Sensor("steering_wheel_angle", 6e-4, 16.0, 1.5, 0.21, lasting=2.0),
    Sensor("steering_shaft_torque", 0.11, 60.0, 3.0, 3.0, jumps=True),
    Sensor("tie_rod_force", 20.5, 4000.0, 200.0, 200.0),
    # Judged in production cars only: the model of the automated vehicle does not predict its front wheels.
    Sensor("wheel_speed_front_left", 0.022, 30.0, 1.0, 0.041),
    Sensor("wheel_speed_front_right", 0.022, 30.0, 1.0, 0.060),
)
"""Sensors that are judged, in the order of all outputs."""

SENSORS = tuple(each.name for each in SENSOR_TABLE)  # names of the sensors

OF_AUTOMATED = tuple(name for name in SENSORS if name in AutomatedVehicle.Output._fields)
OF_CARS = tuple(name for name in RollingCar.Output._fields if name in SENSORS)
"""Sensors of an automated vehicle with known torques, and sensors of a car that is judged by its motion."""

WHEELS = SENSORS[:2]
FRONT_WHEELS = tuple(name for name in SENSORS if name.startswith("wheel_speed_front"))
ALL_WHEELS = WHEELS + FRONT_WHEELS  # wheel speed sensors: of the rear axle, of the front axle, of both

SHAFT_TORQUE = "steering_shaft_torque"  # sensor of the joint torque of both steering motors

ACCELERATIONS = ("longitudinal_acceleration", "lateral_acceleration")
"""Auxiliary sensors without a hypothesis and without a substitute; the motion by the other sensors checks them."""

ACCELERATION_NOISE = 0.12  # standard deviation of one reading of an acceleration [m/s**2]


class Actuator(NamedTuple):
    """Actuator that is judged."""

    name: str  # name of the actuator
    target: str  # signal of its requested torque
    needs: str = ""  # sensor without which its torque is not observable; "" without such a sensor


ACTUATOR_TABLE = (
    Actuator("steering_motor_1", "steering_motor_1_target_torque", SHAFT_TORQUE),
    Actuator("steering_motor_2", "steering_motor_2_target_torque", SHAFT_TORQUE),
    Actuator("drive_left", "target_drive_torque_left"),
    Actuator("drive_right", "target_drive_torque_right"),
)
"""Actuators that are judged, in the order of all outputs."""

ACTUATORS = tuple(each.name for each in ACTUATOR_TABLE)  # names of the actuators

TARGETS = tuple(each.target for each in ACTUATOR_TABLE)  # signals of their requested torques, in the same order

MOTORS, DRIVES = ACTUATORS[:2], ACTUATORS[2:]
"""Pair of actuators that turns the column, and pair that drives the vehicle. If a shared supply or enabling fails, both
lose the same share of torque."""

STEERING_TORQUES = ("steering_shaft_torque", "tie_rod_force", *MOTORS)
"""Elements in the balance of torques about the steering axis."""

ELEMENTS = SENSORS + ACTUATORS  # all elements that are judged, in the order of all outputs

NEEDED = {each.name: each.needs for each in ACTUATOR_TABLE if each.needs}
"""Actuator -> sensor without which it is not observable."""


def _of_signals(name: str, signals: tuple[str, ...]) -> Any:
    return named_tuple(name, [(each, Annotated[float, SIGNALS[each].unit]) for each in signals])


Readings: Any = _of_signals("Readings", SENSORS)  # one number per sensor, in its unit

Measured: Any = _of_signals("Measured", (*OF_AUTOMATED, *ACCELERATIONS))
"""One number per sensor of an automated vehicle, accelerations included, in its unit."""

Elements: Any = named_tuple("Elements", [(name, Annotated[float, ""]) for name in ELEMENTS])
"""One number per sensor and actuator; mostly whether (1) or not (0)."""

Statements: Any = named_tuple("Statements", [(name, Statement) for name in ELEMENTS])
"""One statement per sensor and actuator."""

ConditionSample: Any = _of_signals(
    "ConditionSample",
    (
        *(*OF_AUTOMATED, *ACCELERATIONS, *TARGETS, "target_steering_wheel_angle", "target_vehicle_speed"),
        *(name for name in SENSORS if name not in OF_AUTOMATED),
    ),
)
"""One sample of the vehicle; NaN where a signal is missing.

Wheel speeds are circumferential speeds. The angle is that of the column; the shaft torque acts below both steering
motors; the tie-rod force is the sum of both sides, positive if it opposes a turn to the left. Accelerations are
specific forces at the sensor. Targets are the requested torques of the motors, at their shafts, and of the drives, at
the wheels, followed by the set points of the control for angle and speed. The last sensors exist in cars only.
"""

PLACES = [ConditionSample._fields.index(name) for name in SENSORS]  # column indices of the sensors in a sample


def readings_of(sample: ConditionSample) -> Readings:
    return Readings(*(getattr(sample, name) for name in SENSORS))


def readings_by(values: Mapping[str, Scalar], other: Scalar = 0.0) -> Readings:
    return Readings(*(values.get(name, other) for name in SENSORS))


def listed(names: Sequence[str], word: str = "and") -> str:
    """Names of signals in plain words, the last two joined by a word."""
    plain = [name.replace("_", " ") for name in names]
    return f" {word} ".join([", ".join(plain[:-1]), plain[-1]] if len(plain) > 1 else plain)


HEALTHY = "healthy"  # name of the fault-free hypothesis


@dataclass(frozen=True)
class Hypothesis:
    """Fault hypothesis: these elements are faulty, all others are fault-free."""

    name: str  # "healthy", or the names of the faulty elements joined by " + "
    sensors: tuple[str, ...] = ()  # faulty sensors, names from `SENSORS`
    actuators: tuple[str, ...] = ()  # faulty actuators, names from `ACTUATORS`

    @property
    def suspects(self) -> tuple[str, ...]:
        return self.sensors + self.actuators

    def agrees(self, other: Hypothesis) -> bool:
        """Whether both suspect the same actuators, or one of them suspects none.

        The lost torque is one state of a lane: the joint loss of two actuators is another quantity than that of one.
        """
        return not self.actuators or not other.actuators or self.actuators == other.actuators


def hypotheses() -> tuple[Hypothesis, ...]:
    """All 52 hypotheses for a whole vehicle, in a fixed order.

    Fault-free; one sensor (6); one actuator (4); two sensors (15); a sensor and an actuator (24); two actuators that
    share a supply and lose the same share (2).
    """
    singles = [((name,), ()) for name in OF_AUTOMATED]
    motors = [((), (name,)) for name in ACTUATORS]
    pairs = [(pair, ()) for pair in combinations(OF_AUTOMATED, 2)]
    mixed = [((sensor,), (actuator,)) for sensor, actuator in product(OF_AUTOMATED, ACTUATORS)]
    shared = [((), MOTORS), ((), DRIVES)]
    return tuple(
        Hypothesis(" + ".join((*sensors, *actuators)) or HEALTHY, sensors, actuators)
        for sensors, actuators in [((), ()), *singles, *motors, *pairs, *mixed, *shared]
    )


def hypotheses_of_cars() -> tuple[Hypothesis, ...]:
    """All hypotheses for a car: fault-free, and one or two faulty sensors.

    Both wheels of an axle are excluded, since their fault looks like slip of the axle.
    """
    pairs = [each for each in combinations(OF_CARS, 2) if each not in (WHEELS, FRONT_WHEELS)]
    return tuple(Hypothesis(" + ".join(each) or HEALTHY, each) for each in [(), *((name,) for name in OF_CARS), *pairs])


SLIDING = Hypothesis("sliding tyres")
"""Hypothesis that the tyres slide without any fault; it is no diagnosis, but prevents one."""


ERRORS = ("front_force_error", "rear_force_error", "tie_rod_force_error")  # states for errors of the model's forces
OFFSETS = (
    *("yaw_rate_offset", "angle_offset", "wheel_speed_difference", "wheel_speed_scale", "drive_excess"),
    *("grade_acceleration", "bank_acceleration"),
)
"""Slowly varying states: offsets of sensors, radii of wheels, slopes of the road."""


class _Actuated:
    """Model of the vehicle with the acting torques as inputs.

    The steering motors work on one shaft, so that only their sum acts on the vehicle.
    """

    State, Output = AutomatedVehicle.State, AutomatedVehicle.Output

    class Input(NamedTuple):
        """Acting torques [N*m]."""

        steering_torque: Annotated[float, "N*m"]
        drive_left: Annotated[float, "N*m"]
        drive_right: Annotated[float, "N*m"]

    @staticmethod
    def transition(x: AutomatedVehicle.State, u: Input, p: AutomatedVehicle.Parameters) -> AutomatedVehicle.State:
        return AutomatedVehicle.transition(x._replace(torque_loss=0.0), _asked(u), p)

    @staticmethod
    def output(x: AutomatedVehicle.State, u: Input, p: AutomatedVehicle.Parameters) -> AutomatedVehicle.Output:
        return AutomatedVehicle.output(x._replace(torque_loss=0.0), _asked(u), p)


def _asked(u: _Actuated.Input) -> AutomatedVehicle.Input:
    torques = (u.steering_torque, 0.0, u.drive_left, u.drive_right)
    return AutomatedVehicle.Input(*torques, *torques, 0.0, 0.0, 0.0, 0.0)


def rolls(vehicle: Vehicle) -> bool:
    """Whether a vehicle is judged by its motion: its file lacks more parameters of a whole vehicle than of a car."""
    return len(_lacking(vehicle, RollingCar.Parameters)) < len(_lacking(vehicle, AutomatedVehicle.Parameters))


def _lacking(vehicle: Vehicle, wanted: type[Any]) -> list[str]:
    needed = (each for each in fields(wanted) if each.default is MISSING and each.default_factory is MISSING)
    return [each.name for each in needed if each.name not in vehicle]


def rolling_structure(vehicle: Vehicle, without: Collection[str] = (), steering_known: bool = True) -> StructuralModel:
    """Structural model of a car without known torques: speed and yaw rate may change arbitrarily at any time."""
    motion = ("speed", "acceleration", "yaw_rate", "yaw_acceleration", *(() if steering_known else ("steering_error",)))
    model = structure_of(
        RollingCar,
        vehicle.parameters_for(RollingCar.Parameters),
        {name: name for name in SENSORS if name in RollingCar.Output._fields},
        without=[name for name in RollingCar.State._fields if name not in motion],
        free=[name for name in motion if name not in ("speed", "yaw_rate")],
    )
    return model.without(*(name for name in without if name in model.by_name))


def vehicle_structure(vehicle: Vehicle, without: Collection[str] = (), forces_known: bool = True) -> StructuralModel:
    """Structural model of a vehicle with its sensors and actuators; every fault has the name of its element."""
    for name in without:
        if name not in (*SENSORS, *ACCELERATIONS):
            raise ParameterError(f"there is no sensor '{name}'{nearest(name, (*SENSORS, *ACCELERATIONS))}")
    if rolls(vehicle):
        return rolling_structure(vehicle, without, forces_known)
    model = structure_of(
        _Actuated,
        vehicle.parameters_for(AutomatedVehicle.Parameters),
        {**{name: name for name in OF_AUTOMATED}, **{f"known {name}": name for name in ("drive_left", "drive_right")}},
        known_inputs=("drive_left", "drive_right"),
        without=(*OFFSETS, "torque_loss", *(ERRORS if forces_known else ())),
        free=() if forces_known else ERRORS,
    ).without(*without)
    motors = [Equation.of(f"known {name}", {name}, {name}, name) for name in MOTORS]
    return model.plus(Equation.of("sum of the steering motors", {"steering_torque", *MOTORS}), *motors)


def further_sensors(model: StructuralModel) -> tuple[Equation, ...]:
    """Equations of sensors that a car could have in addition to those of the model, each with a fault of its own."""
    of_one = {
        "speed over ground": "speed",
        "optical sideslip sensor": "lateral_speed",
        **({} if "yaw_rate" in model.by_name else {"yaw rate sensor": "yaw_rate"}),
        "rack position sensor": "column_angle",
        "torque of steering motor 1, from its current": "steering_motor_1",
        "torque of steering motor 2, from its current": "steering_motor_2",
        "torque of the left drive, from its current": "drive_left",
        "torque of the right drive, from its current": "drive_right",
    }
    offered = [Equation.of(name, {state}, {name}, name) for name, state in of_one.items() if state in model.unknowns]
    for name in (*SENSORS, *ACCELERATIONS):
        if name in model.by_name:
            again = f"second {name.replace('_', ' ')}"
            offered.append(Equation.of(again, model.by_name[name].unknowns, {again}, again))
    return tuple(offered)


def limitations(vehicle: Vehicle, missing: Collection[str]) -> tuple[str, ...]:
    """Sentences on faults that are not detectable or not isolable without some sensors."""
    model = vehicle_structure(vehicle, missing)
    single = isolability(model)
    lack = f"without {listed(sorted(missing))}, " if missing else ""
    unseen, alike = single.undetectable, [group for group in single.groups if len(group) > 1]
    notes = [f"{lack}faults of {listed(unseen)} do not show in any equation"] if unseen else []
    notes += [f"{lack}faults of {listed(group)} are not distinguished from each other" for group in alike]
    if not notes and single.faults:
        notes = [f"{lack}single faults of {listed(single.faults)} are still distinguished by the equations"]
    return tuple(notes)
