"""What the diagnoses make of the drives: rows of every fault, of fault-free driving, and of single residuals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.errors import TierodError
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.definition import condition_monitor
from tierod.monitors.condition.limits import NAME, aligned, designed_on, table_of, watch
from tierod.monitors.condition.parameters import calibrate as calibrate_parameters
from tierod.monitors.condition.reaction import FILTER, plain_relations
from tierod.monitors.condition.signals import ConditionSample
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import Vehicle, load
from tierod.work.fingerprint import fingerprint
from tierod_lab.campaign.code import reported_seed
from tierod_lab.methods.unscented import UnscentedFilter
from tierod_lab.papers.condition.drives import LOSS, SHORT, TEST_SECONDS, Drive, Injected, lost
from tierod_lab.papers.condition.real_cars import CARS, judged
from tierod_lab.papers.condition.recorded import NOT_HEALTHY, ODD, calibration_set, fault_free, recorded
from tierod_lab.papers.condition.rules.calibration import calibrate_residuals, samples_of
from tierod_lab.papers.condition.rules.models import StiffRack, one_body, two_bodies
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, CarParameters, ResidualCalibration, part
from tierod_lab.papers.condition.rules.rule_monitor import VARIANTS as RULES
from tierod_lab.papers.condition.rules.rule_monitor import rule_monitor
from tierod_lab.papers.condition.scoring import KNOWN, Declared, declared_of, scored, truth_of
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.metrics import Row

BANK, SHIPPED = "bank", "uncalibrated"  # The bank of filters, calibrated and by the shipped vehicle file
METHODS = (*RULES, BANK)
USED = 100  # Demonstrators up to this number were used while thresholds were chosen, and are not reported
MOTOR, LATE = "steering_motor_1", 123.5  # The actuator that Figures 26 to 28 lose, and when [s]


@cache
def first_vehicle() -> int:
    """Number of the first demonstrator, which determines its parameters and the seeds of its drives.

    It changes with the judged monitor.
    """
    return USED + 1 + 10 * (reported_seed(condition_monitor(load("smartload"))) % 100_000)


def vehicles(effort: Effort) -> tuple[int, ...]:
    """Numbers of the three demonstrators of a study; a single one if it is quick."""
    return tuple(range(first_vehicle(), first_vehicle() + (1 if effort.quick else 3)))


_blocks: dict[tuple[str, str], Block] = {}


def _shipped_car() -> CarParameters:
    """Parameters of the vehicle file, which the rules use."""
    found: CarParameters = load("smartload").parameters_for(CarParameters)
    return found


@dataclass(frozen=True)
class Known:
    """A vehicle as the diagnoses know it."""

    vehicle: Vehicle  # with parameters and limits of the bank
    # calibration of the residuals, by whether the misprints are kept
    residuals: Mapping[bool, ResidualCalibration] = field(default_factory=dict)

    def block(self, method: str) -> Any:
        """The block of a diagnosis, which each process builds once, since blocks are not pickled."""
        key = method, fingerprint(self.vehicle, self.residuals)
        if key not in _blocks:
            rules = self.residuals.get(method == "rules-printed")
            _blocks[key] = (
                rule_monitor(_shipped_car(), rules, method)
                if method in RULES and rules
                else condition_monitor(self.vehicle)
            )
        return _blocks[key]

    def declared(self, method: str, recording: Recording) -> Declared:
        """Declarations of a diagnosis over a drive."""
        samples = samples_of(recording) if method in RULES else aligned(recording)
        declared = declared_of(scan(self.block(method), samples), recording["yaw_rate"].time)
        # Rules give neither kind nor size: the zeros of their statements are no estimates.
        return declared._replace(kind={}, size={}, deviation={}) if method in RULES else declared


_known: dict[tuple[int, bool], Known] = {}


def calibrations(numbers: Iterable[int], effort: Effort) -> dict[int, Known]:
    """Vehicles calibrated on their fault-free drives, by number; made once in the process."""
    wanted = [(number, effort.quick) for number in dict.fromkeys(numbers)]
    missing = [each for each in wanted if each not in _known]
    made = effort.made(calibrated, missing, lambda each: f"the calibration of vehicle {each[0]}")
    _known.update(zip(missing, made, strict=True))
    return {each[0]: _known[each] for each in wanted}


def calibrated(task: tuple[int, bool]) -> Known:
    """Parameters, limits and residuals of a vehicle by its number, on little driving if quick."""
    driven = calibration_set(*task)
    vehicle = calibrate_parameters(driven.fitted, load("smartload")).vehicle
    watched = watch(driven.healthy, vehicle)
    hours = sum(each.hours for each in watched)
    designed = designed_on(np.concatenate([each.blocks for each in watched]), 1000.0, hours)
    table = table_of(designed, f"drives of demonstrator {task[0]}")
    vehicle = replace(vehicle, thresholds={**vehicle.thresholds, NAME: table})
    healthy = driven.healthy[: 1 if task[1] else None]
    residuals = {
        each: calibrate_residuals(_shipped_car(), driven.fitted, healthy, printed=each) for each in (False, True)
    }
    return Known(vehicle, residuals)


class Task(NamedTuple):
    """A drive and the diagnoses that judge it."""

    drive: Drive
    known: Known
    methods: tuple[str, ...] = (BANK,)
    test: str = ""  # name of the group of drives


def tasks(drives: Iterable[Drive], effort: Effort, methods: tuple[str, ...] = (BANK,), test: str = "") -> list[Task]:
    """Tests of calibrated vehicles, or of the shipped vehicle file where the one diagnosis is `SHIPPED`."""
    chosen = list(drives)
    if methods == (SHIPPED,):
        return [Task(drive, Known(load("smartload")), methods, test) for drive in chosen]
    known = calibrations((drive.vehicle for drive in chosen), effort)
    return [Task(drive, known[drive.vehicle], methods, test) for drive in chosen]


def diagnosed(task: Task) -> list[Row]:
    """Rows of every fault of a drive, or of a fault-free drive, by every diagnosis."""
    recording = recorded(task.drive)
    truth = truth_of(task.drive, recording)
    extra: Row = {"test": task.test, "swing": float(task.drive.swing), "later": (task.drive.later or ("",))[0]}
    return [
        {"method": method, **extra, **row}
        for method in task.methods
        for row in scored(task.drive, truth, task.known.declared(method, recording))
    ]


def sensors(task: Task) -> list[Row]:
    """Six sensors, four faults, two rounds, 60 s each, the fault from 20 to 40 s (an outlier for a second): 48 tests.

    Accuracy is that of eq (53): the share of the samples at which the state of the sensor is right. It counts samples
    as wrong at which a lost signal is near zero in truth. A fault is observable where, over 0.1 s, its likelihood ratio
    exceeds that of three standard deviations of the accuracy required of a reconfigured value.
    """
    return diagnosed(task)


def actuators(task: Task) -> list[Row]:
    """Both steering motors and a drive on three rounds, 200 s each, without torque, or without half, from 104 s on.

    The steering torque is split 65 to 35 between the motors, and back, every 0.12 s, or in a fixed split. Both motors,
    or both drives, fail together as where their supply does: half the torque of both is all the torque of one until the
    split changes, or a drive turns the vehicle.
    """
    return diagnosed(task)


def uncalibrated(task: Task) -> list[Row]:
    """Vehicles judged with the vehicle file as it is shipped: its parameters with their standard deviations, its limits
    that several vehicles need together.

    The tests of sensors and actuators with a fixed split of the steering torque, as is common; kinds of faults and
    fault-free hours as for calibrated vehicles.
    """
    return diagnosed(task)


def healthy(task: Task) -> list[Row]:
    """Rounds drawn at random, ten minutes each, with slopes, bumps, wind, halts and wet patches; no calibration has
    driven them.

    Then the same with a mass, a cornering stiffness or a tyre radius that is 10 % more or less than when the vehicle
    was calibrated. A false alarm is a declaration that begins without a fault.
    """
    return diagnosed(task)


def beyond(task: Task) -> list[Row]:
    """Every kind of fault of every sensor in several sizes, two faults at once, and offsets down to a twentieth of
    those of the tests.

    Kind and size are what is said 2 s after the declaration. Of a pair, the second fault comes 2 s after the first;
    right is who names both and nothing else most of the time in which both are observable.
    """
    return diagnosed(task)


def odd(task: tuple[str, Known]) -> list[Row]:
    """A fault-free vehicle that stands, reverses, slides, is logged from the middle of a drive on, lacks a sensor, or
    was wired or scaled wrongly.

    The whole monitor runs over each recording; it may not call any sensor or actuator faulty, not for a moment, and
    must say what keeps it from judging.
    """
    name, known = task
    recording = ODD[name]()
    try:
        found = diagnose(recording, known.vehicle, "condition")
    except TierodError as error:
        return [{"recording": name, "verdict": "refused", "cause": str(error), "unexpected": 1.0, "seconds": 0.0}]
    finding, end = found.findings[0], recording.span[1]
    episodes = [each for element in found.elements for each in element.episodes if not each.candidates]
    right = finding.status is NOT_HEALTHY.get(name, Status.HEALTHY)
    row: dict[str, float | str] = {"recording": name, "verdict": str(finding.status), "cause": finding.cause}
    row["unexpected"] = float(not (right and (finding.status is Status.HEALTHY or bool(finding.cause))))
    row["seconds"] = sum((end if each.end is None else each.end) - each.start for each in episodes)
    return [row]


def late(known: Known) -> list[Row]:
    """A steering motor without torque from 123.5 s on, when hardly any is asked of it (Figures 26 to 28).

    Time until each residual of Figure 27 exceeds its threshold, and until the bank declares the motor.
    """
    drive = Drive(SHORT, 200.0, 1, 21, (lost(MOTOR, start=LATE),))
    recording = recorded(drive)
    time = recording["yaw_rate"].time
    ratios = ratios_of(known, recording)
    flags = {name: ratios[name] > 1.0 for name in ("r1a", "r4a", "r5a", "r6a")}
    flags[BANK] = known.declared(BANK, recording).said("faulty", MOTOR)
    found = {name: flag & (time >= LATE - 1e-9) for name, flag in flags.items()}
    return [
        {"what": name, "delay": float(time[np.argmax(flag)] - LATE) if flag.any() else np.inf}
        for name, flag in found.items()
    ]


def ratios_of(known: Known, recording: Recording) -> dict[str, np.ndarray]:
    """Magnitude of every corrected residual over its threshold; zero where it is not present."""
    monitor = known.block("rules")
    result = scan(monitor.residuals, samples_of(recording))
    return {
        name: np.abs(np.where(result[f"there.{name}"] > 0.5, result[f"residuals.{name}"], 0.0)) / threshold
        for name, threshold in zip(RESIDUALS, monitor.thresholds, strict=True)
    }


def residuals(task: Task) -> list[Row]:
    """Share of a fault's time in which each residual of the sensors is beyond its threshold."""
    recording, fault = recorded(task.drive), task.drive.injected[0]
    time = recording["yaw_rate"].time
    during = (time >= fault.start) & (time < fault.end)
    return [
        {
            "element": fault.element,
            "wheel": float(fault.element.startswith("wheel")),
            "kind": fault.kind,
            "residual": name,
            "uses": float(fault.element in RESIDUALS[name].signals),
            "beyond": float(np.mean(ratio[during] >= 1.0)),
        }
        for name, ratio in ratios_of(task.known, recording).items()
        if not name.endswith("a") and name in RESIDUALS and name.startswith("r")
    ]


def racks(task: str) -> list[Row]:
    """The paper's filter of the angle has four states (eqs 3, 4); the residuals use two, since the teeth swing at some
    hundred times the sampling rate.

    Both on a minute of driving, and on the same with the angle lost from 20 to 40 s. The rack's position, made from the
    angle by eq (5), counts the one sensor twice.
    """
    car = _shipped_car()
    rack = part(StiffRack.Parameters, car)
    block: UnscentedFilter = one_body(rack) if task == "one body" else two_bodies(rack)
    copies = car.rack_ratio if task == "angle twice" else np.nan
    rows = []
    for faults in ((), (Injected("steering_wheel_angle", LOSS),)):
        drive = Drive(SHORT, TEST_SECONDS, 1, 11, faults)
        made = recorded(drive)
        torque, force, angle = (
            made[name].values for name in ("steering_shaft_torque", "tie_rod_force", "steering_wheel_angle")
        )
        copied = [copies * angle] if task != "one body" else []
        result = scan(block, np.stack([torque, force, *copied, angle], axis=1))
        rows.append((angle - result["mean.steering_wheel_angle"], result["variance.steering_wheel_angle"][-1]))
    (free, variance), (followed, _) = rows
    # The angle is lost at 20 s, sample 2000.
    jump, after = (float(np.max(np.abs(followed[at : at + 10]))) for at in (2000, 3000))
    return [
        {
            "filter": task,
            "rms": 1e3 * float(np.sqrt(np.mean(free[200:] ** 2))),
            "variance": float(variance),
            "kept": after / jump,
        }
    ]


def substitutes(task: Task) -> list[Row]:
    """Every substitute of a sensor beside what the sensor would read without fault and noise, root mean square.

    The bank's filter that leaves the sensor out: from the declaration of an offset to its end. Plain relations: over
    fault-free drives. With the parameters of a calibration, and with those of the shipped file. The table that the
    monitor goes by, substitutes.toml, holds these figures.
    """
    recording, sensor_set = recorded(task.drive), task.drive.driven.sensors
    rows: list[Row] = []
    for calibrated, known in ((1.0, task.known), (0.0, Known(load("smartload")))):
        if task.drive.injected:
            (fault,) = task.drive.injected
            declared = known.declared(BANK, recording)
            during = declared.faulty[fault.element] & (declared.time < fault.end) & (declared.time >= fault.start)
            related: Mapping[str, Any] = {fault.element: {FILTER: declared.value[fault.element]}}
        else:
            during = np.arange(len(recording["yaw_rate"].values)) >= 200  # warm-up
            readings: Any = ConditionSample(
                *(recording[name].values if name in recording else np.nan for name in ConditionSample._fields)
            )
            related = plain_relations(readings, known.vehicle.parameters_for(AutomatedVehicle.Parameters))
        for sensor, ways in related.items():
            right = fault_free(sensor, recording, sensor_set)
            for name, value in ways.items():
                square = float(np.mean(np.square(value - right)[during])) if during.any() else np.nan
                row = {"sensor": sensor, "substitute": name, "calibrated": calibrated}
                rows.append({**row, "square": square, "over_asked": float(np.sqrt(square)) / KNOWN[sensor]})
    return rows


def real(task: tuple[int, bool]) -> list[Row]:
    """A minute of a RAV4 on a highway and 20 s of a passenger car in tight bends, with the sensors that both have.

    Their torques are unknown, so the bank judges them by their motion. Its limits come from the first half of the
    highway minute, its noises from there and from the first 9 s of the passenger car. What is later is judged: each
    sensor fails at three instants. A fault is observable where it exceeds three standard deviations of the accuracy
    required of the demonstrator's sensors, or of the estimate by the other sensors of this car where that is less
    exact; missed by the latter alone stands beside it.
    """
    number, quick = task
    return judged(CARS[number], quick)
