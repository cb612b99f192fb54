"""The monitor of the driver's hands and its variants."""

from __future__ import annotations

from collections.abc import Callable

from tierod.core.block import Block
from tierod.core.errors import ParameterError
from tierod.monitors.driver_torque.decisions import DECISIONS
from tierod.monitors.driver_torque.delayed import DELAY, DelayedHandTorque
from tierod.monitors.driver_torque.design import gear_is_too_fast
from tierod.monitors.driver_torque.drive import TRUTH
from tierod.monitors.driver_torque.finding import LEAST_READY
from tierod.monitors.driver_torque.hands import HandsMonitor
from tierod.monitors.driver_torque.monitor import DriverTorqueMonitor
from tierod.monitors.driver_torque.observer import ColumnObserver
from tierod.monitors.driver_torque.session import DriverTorqueSession
from tierod.monitors.driver_torque.signs import ColumnSigns
from tierod.monitors.driver_torque.tuning import FINE, PRODUCTION, SensorNoise, tuning_at, usual_tuning
from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.session import Monitor, Session, Variant
from tierod.monitors.registry import variants_with_plugins
from tierod.vehicles import Vehicle

PAPER = "Raffone, Observers of an electric power steering column"

FAST = 500.0
"""Rate from which sensors are assumed to be those of a test bench [Hz]; buses of cars are slower."""

_DELAYED = ("disturbance_torque", "disturbance_torque_deviation", "nis")

LATER = f"The torque is given {1e3 * DELAY:.0f} ms after it acted; truth and error refer to the time at which it acted."
NO_GEAR = (
    "The gear's vibration is too fast for {rate:g} samples per second, so it is left out: bar and gear are one spring, "
    "and gear and motor one inertia."
)

Opener = Callable[[Vehicle, float, Baseline | None], Session]
Observer = Callable[[Vehicle, float, SensorNoise, bool], Block]
"""Builder of an observer from vehicle, rate [Hz], sensor noise, and whether the motor's angle is used."""


def opener(
    name: str, observer: Observer, lacking: tuple[str, ...] = (), delay: float = 0.0, whole_column: bool = False
) -> Opener:
    """Function that opens a session with an observer.

    Args:
        name: of the variant
        observer: builder of the observer
        lacking: outputs that it does not have
        delay: time by which its torque is late [s]
        whole_column: whether it keeps the gear even where the gear's vibration is too fast for the sampling
    """

    def open_(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
        if not vehicle.calibrated:
            raise ParameterError(
                f"the torques of the vehicle '{vehicle.name}' are raw counts, but the wheel's inertia needs N·m; give "
                "the N·m of one count in the channel map, and take torque_unit out of the vehicle file"
            )

        def build(column: Vehicle, noise: SensorNoise, with_motor: bool) -> DriverTorqueMonitor:
            hands = HandsMonitor.of_vehicle(column, 1.0 / rate, noise=noise)
            signs = ColumnSigns(
                column["motor_ratio"], 1.0 / rate, torsion_bar_stiffness=column["torsion_bar_stiffness"]
            )
            return DriverTorqueMonitor(observer(column, rate, noise, with_motor), hands, signs)

        remark = LATER if delay > 0.0 else ""
        if not whole_column and gear_is_too_fast(vehicle, 1.0 / rate):
            remark = f"{remark} {NO_GEAR.format(rate=rate)}".lstrip()
        usual = FINE if rate >= FAST else PRODUCTION
        return DriverTorqueSession(
            build, usual, vehicle, rate, f"driver-torque, {name}", lacking, round(delay * rate), remark
        )

    return open_


def _default(vehicle: Vehicle, rate: float, noise: SensorNoise, with_motor: bool) -> ColumnObserver:
    tuning = tuning_at(rate, usual_tuning(vehicle), noise, with_motor)
    return ColumnObserver.of_vehicle(vehicle, 1.0 / rate, tuning=tuning)


def _delayed(vehicle: Vehicle, rate: float, noise: SensorNoise, with_motor: bool) -> DelayedHandTorque:
    tuning = tuning_at(rate, usual_tuning(vehicle), noise, with_motor)
    return DelayedHandTorque.of_vehicle(vehicle, 1.0 / rate, tuning=tuning)


INTERACTING = Variant(
    "interacting",
    "Three filters in parallel: for a hand torque that changes at a rate, one that jumps, and friction that reverses.",
    f"beyond {PAPER}; docs/explanation/driver-torque.md",
    opener("interacting", _default),
    DECISIONS,
)

FIXED_LAG = Variant(
    "fixed-lag",
    "The torque of the hands 20 ms ago, from all samples until now: smoother and more accurate, but late.",
    f"beyond {PAPER}; docs/explanation/driver-torque.md",
    opener("fixed-lag", _delayed, _DELAYED, DELAY),
    DECISIONS,
)

DRIVER_TORQUE = Monitor(
    name="driver-torque",
    title="Torque of the driver's hands",
    summary="Estimates the torque that the driver's hands put on the wheel, and decides whether they are on it.",
    source=PAPER,
    drive=f"At least {LEAST_READY:g} s in which the wheel turns: a drive, or a bench whose motor turns the column.",
    required=("steering_wheel_angle", "driver_torque"),
    optional=("motor_torque", "motor_target_torque", "motor_angle_mechanical", TRUTH),
    rate=1000.0,
    minimum_rate=50.0,
    maximum_age=0.05,
    variants=variants_with_plugins(
        "driver-torque",
        {
            "interacting": "tierod.monitors.driver_torque.definition:INTERACTING",
            "fixed-lag": "tierod.monitors.driver_torque.definition:FIXED_LAG",
        },
    ),
    default="interacting",
    slower=(500.0, 200.0, 100.0, 50.0),
    estimates=True,
)
