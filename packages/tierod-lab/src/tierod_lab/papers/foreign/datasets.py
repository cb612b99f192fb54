"""Monitors on plants of others: CommonRoad's car, a foreign column, motulator's motors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tierod.core.block import leaves, skeleton
from tierod.core.errors import InputError
from tierod.core.findings import Status
from tierod.core.graph import Result, scan
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.monitors.diagnose import diagnose
from tierod.monitors.motor_angle.definition import MotorAngleMonitor
from tierod.monitors.motor_angle.observer import MotorAngleSample
from tierod.vehicles import Vehicle, load
from tierod_lab.papers.condition import real_cars
from tierod_lab.papers.condition.drives import DRIFT, OFFSETS, STUCK, Injected
from tierod_lab.papers.foreign import rubbing_column
from tierod_lab.papers.foreign.motor_drives import MACHINES, SAMPLE_TIME, MotorDrive, motor_drive
from tierod_lab.papers.foreign.multibody_car import MultibodyCar
from tierod_lab.papers.foreign.rubbing_column import RubbingCar, course, driven, sliding_level
from tierod_lab.papers.friction.cases import HEALTHY, STATES
from tierod_lab.papers.friction.reported import monitor
from tierod_lab.studies.metrics import Row


def faults_of(sensor: str, start: float, lasting: float) -> tuple[Injected, ...]:
    """The faults of a sensor: those of the study of real cars, a stuck reading and a drift."""
    end = start + lasting
    return (
        *real_cars.faults_of(sensor, start, lasting),
        Injected(sensor, STUCK, start=start, end=end),
        Injected(sensor, DRIFT, 0.1 * OFFSETS[sensor], start, end),
    )


def over_car(task: tuple[int, bool]) -> list[Row]:
    """CommonRoad's multi-body car turns by its own Magic Formula tyres, springs and load transfer.

    Its vehicle file has its masses and lengths, and a stiffness from its tyres. The bank keeps the limits that were
    found on the RAV4. Faults are those of the study of real cars, and besides a reading that stands still and one that
    drifts by a tenth of the offset a second, put into the recording alone.
    """
    seed, quick = task
    # Learning time, starts and duration of the faults are those of the highway minute in the study of real cars.
    car = MultibodyCar("CommonRoad's car", ("", ""), "rav4", None, 30.0, (33.0, 42.0, 51.0), 6.0, seed=seed)
    return real_cars.judged(car, quick=quick, kinds=faults_of)


SPREAD = {
    "mass": 0.04,
    "yaw_inertia": 0.04,
    "front_stiffness": 0.08,
    "rear_stiffness": 0.08,
    "mechanical_trail": 0.1,
    "pneumatic_trail": 0.1,
    "pinion_inertia": 0.1,
    "pinion_damping": 0.2,
    "build_up": 0.3,
}
"""Standard deviation of the logarithm of each parameter over the cars; the monitor keeps its vehicle file."""
COLUMNS = list(rubbing_column.SIGNALS)
FREE, RISEN = (Status.HEALTHY,), (Status.RISING, Status.FAULT, Status.SUSPECT)
"""Verdicts that count as fault-free and as increased friction."""


def over_column(task: tuple[str, int, int, float]) -> list[Row]:
    """Wheel and pinion on an elastic shaft, with friction by LuGre or by generalised Maxwell slip.

    The car's equations were written for this study and share none with tierod. Each car differs from the vehicle file;
    it drives once without fault, which gives its level, and again with each level of friction. The truth is the mean
    level of friction over the rates at which the monitor looked.
    """
    law, number, seed, minutes = task
    random = np.random.default_rng([seed, number, 7])
    nominal = RubbingCar(law, HEALTHY)
    changes = {name: getattr(nominal, name) * float(np.exp(size * random.normal())) for name, size in SPREAD.items()}
    rows: list[Row] = []
    level: tuple[float, float] | None = None
    for place, friction in enumerate(STATES.values()):
        row, learnt = _on_column(replace(nominal, level=friction, **changes), level, [seed, number, place], minutes)
        level = level if place else learnt
        rows.append({"car": float(number), "law": law, "level": friction, **row})
    return rows


def _on_column(
    car: RubbingCar, level: tuple[float, float] | None, seeds: Sequence[int], minutes: float
) -> tuple[Row, tuple[float, float] | None]:
    """Row of one drive, and the level that the monitor learnt, with its deviation [N*m]."""
    seed = int(np.random.SeedSequence(list(seeds)).generate_state(1)[0])
    seen = driven(car, course(minutes, seed), seed)
    judge = monitor(level)
    names = [name for name, _ in leaves(skeleton(judge.Sample))]
    result = scan(judge, np.ascontiguousarray(seen[:, [COLUMNS.index(name) for name in names]]))
    rates = seen[result["estimate.enabled"] > 0.5, COLUMNS.index("steering_wheel_rate")]
    last = result.at(-1)
    error = float(last.estimate.friction_torque) - (sliding_level(car, rates) if len(rates) else np.nan)
    deviation, own = float(last.estimate.friction_deviation), last.verdict.baseline
    status = judge.finding(result).status
    judged = status in (*FREE, *RISEN)
    row: Row = {
        "error": error,
        "deviation": deviation,
        "covered": float(abs(error) <= 1.96 * deviation),
        "judged": float(judged),
        "wrong": float(judged and (status in RISEN) != (car.level > HEALTHY)),
        "said": str(status),
    }
    return row, (own.level, own.deviation) if own.seconds > 0.0 else None


ANGLE = MotorAngleSample._fields.index("motor_angle_mechanical")  # Column of the faulty sensor in the samples
Fault = Callable[[np.ndarray, np.ndarray, float], np.ndarray]
"""Function from reading [rad], time since the fault [s] and pole pairs to the faulty reading [rad]."""


def _from_begin(angle: np.ndarray, since: np.ndarray, gain: float) -> np.ndarray:
    """The reading with another gain from the begin of the fault on; 0 holds it."""
    begin = angle[int(np.argmax(since >= 0.0))]
    return np.where(since >= 0.0, begin + gain * (angle - begin), angle)


FAULTS: Mapping[str, Fault] = {
    "offset of 0.3 rad electrical": lambda angle, since, pairs: np.where(since >= 0.0, angle + 0.3 / pairs, angle),
    "drift of 0.35 rad/s electrical": lambda angle, since, pairs: angle + 0.35 / pairs * np.maximum(since, 0.0),
    "gain of 1.05": lambda angle, since, pairs: _from_begin(angle, since, 1.05),
    "stuck": lambda angle, since, pairs: _from_begin(angle, since, 0.0),
}
"""Faults by name."""


def machine_file(name: str, salient: bool = True) -> Vehicle:
    """Vehicle with the parameters of a machine.

    Args:
        name: name in `MACHINES`
        salient: whether it gives both inductances; otherwise that of the d axis alone
    """
    machine, base = MACHINES[name], load("motor-bench")
    known = {
        "motor_resistance": machine.resistance,
        "motor_inductance": machine.direct,
        "motor_saliency": machine.quadrature / machine.direct,
        "motor_flux": machine.flux,
        "motor_pole_pairs": float(machine.pole_pairs),
        "motor_inertia": machine.inertia,
        "motor_damping": 1e-6,
    }
    if not salient:
        del known["motor_saliency"]
    plain = base.parameters["motor_resistance"]
    changed = {each: replace(base.parameters.get(each, plain), value=value) for each, value in known.items()}
    kept = {each: value for each, value in base.parameters.items() if each != "motor_saliency"}
    return replace(base, parameters={**kept, **changed})


def over_motors(task: tuple[str, int, float]) -> list[Row]:
    """Drives that motulator simulates under its own current vector control, to and fro under loads that step.

    Surface and interior magnets of three ratings. The vehicle file has the machine's true parameters, and tuning and
    thresholds stay those of the 12 V motor. Faults begin at seven tenths of the recording and are put into it alone.
    """
    name, seed, seconds = task
    try:
        drive, pairs = motor_drive(name, seed, seconds), float(MACHINES[name].pole_pairs)
    except InputError:
        return []
    judge = MotorAngleMonitor.of_vehicle(machine_file(name), SAMPLE_TIME)
    free = scan(judge, drive.samples)
    known = free["compared.known"] > 0.5
    # The complex exponential wraps the error, so that a whole turn between the two angles does not count.
    away = np.angle(np.exp(1j * pairs * (free["estimate.motor_angle"] - drive.angle)))[known]
    error = float(np.sqrt(np.mean(away**2))) if known.any() else np.nan
    since = SAMPLE_TIME * np.arange(len(drive.angle)) - 0.7 * seconds
    alarmed = float(np.isfinite(first_alarm(free, np.ones(len(since), bool))))
    turning = SAMPLE_TIME * float(known.sum())
    rows: list[Row] = [{"machine": name, "fault": "", "alarmed": alarmed, "error": error, "turning": turning}]
    for fault, change in FAULTS.items():
        samples = drive.samples.copy()
        samples[:, ANGLE] = change(samples[:, ANGLE], since, pairs)
        delay = first_alarm(scan(judge, samples), since >= 0.0)
        rows.append({"machine": name, "fault": fault, "found": float(np.isfinite(delay)), "delay": delay})
    if MACHINES[name].direct != MACHINES[name].quadrature:
        plain = diagnose(recorded(drive), machine_file(name, salient=False), "motor-angle", spread=False).findings[0]
        accused = float(plain.status is Status.FAULT)
        rows.append({"machine": name, "fault": "one inductance of two", "accused": accused, "said": str(plain.status)})
    return rows


def recorded(drive: MotorDrive) -> Recording:
    """The drive as a recording of its available signals."""
    time = SAMPLE_TIME * np.arange(len(drive.angle))
    columns = zip(MotorAngleSample._fields, drive.samples.T, strict=True)
    there = {name: values for name, values in columns if np.isfinite(values).any()}
    return Recording({name: Channel(name, time, values, SIGNALS[name].unit) for name, values in there.items()})


def first_alarm(outputs: Result, during: np.ndarray) -> float:
    """Time from the first sample of `during` to the first alarm in it [s]; infinite without one."""
    alarms = np.logical_or.reduce([outputs[name] > 0.5 for name in outputs.names if name.startswith("alarms.")])
    begin = int(np.argmax(during))
    return SAMPLE_TIME * int(np.argmax(alarms[begin:])) if alarms[during].any() else np.inf
