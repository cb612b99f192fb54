"""The monitor of the motor angle sensor on motulator's drives, fault-free and with injected faults."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.claims import Claim, at_least, exactly
from tierod.core.content import Heading, Item, Table
from tierod.core.errors import InputError
from tierod.core.findings import Finding, Status
from tierod.core.graph import Result, scan
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.monitors.diagnose import diagnose
from tierod.monitors.motor_angle.definition import MotorAngleMonitor
from tierod.monitors.motor_angle.observer import MotorAngleSample
from tierod.vehicles import Vehicle, load
from tierod_lab.papers.foreign.motor_drives import MACHINES, SAMPLE_TIME, MotorDrive, motor_drive
from tierod_lab.papers.foreign.reported import MACHINES as BY_NAME
from tierod_lab.papers.foreign.reported import MOTORS
from tierod_lab.studies.effort import Effort

GOAL = "goal of tierod, as at home"
SECONDS, START = 10.0, 7.0  # Duration of a drive, and start of the fault in it [s]
ANGLE = MotorAngleSample._fields.index("motor_angle_mechanical")  # Column of the faulty sensor in the samples
TEXT = (
    "Drives that motulator simulates under its own current vector control: surface and interior magnets of three "
    "ratings, to and fro under loads that step. The vehicle file has the machine's true parameters, and tuning and "
    "thresholds stay those of the 12 V motor. Faults are put into the recording. Seeds follow from the judged monitor.",
)
Fault = Callable[[np.ndarray, np.ndarray, float], np.ndarray]
"""Function from reading [rad], time since the fault [s] and pole pairs to the faulty reading [rad]."""


def _offset(angle: np.ndarray, since: np.ndarray, pole_pairs: float) -> np.ndarray:
    return np.where(since >= 0.0, angle + 0.3 / pole_pairs, angle)


def _drift(angle: np.ndarray, since: np.ndarray, pole_pairs: float) -> np.ndarray:
    return np.asarray(angle + 0.35 / pole_pairs * np.maximum(since, 0.0))


def _gain(angle: np.ndarray, since: np.ndarray, pole_pairs: float) -> np.ndarray:
    del pole_pairs
    begin = int(np.argmax(since >= 0.0))
    return np.where(since >= 0.0, angle[begin] + 1.05 * (angle - angle[begin]), angle)


def _stuck(angle: np.ndarray, since: np.ndarray, pole_pairs: float) -> np.ndarray:
    del pole_pairs
    return np.where(since >= 0.0, angle[int(np.argmax(since >= 0.0))], angle)


FAULTS: Mapping[str, Fault] = {
    "offset of 0.3 rad electrical": _offset,
    "drift of 0.35 rad/s electrical": _drift,
    "gain of 1.05": _gain,
    "stuck": _stuck,
}
"""Faults by name."""


class Judged(NamedTuple):
    """Results of one drive, fault-free and with every fault."""

    machine: str  # name in `MACHINES`
    turning: float  # time in which the observed angle was valid [s]
    error: float  # root mean square error of the observed electrical angle in that time [rad]
    false: tuple[str, ...]  # tests with a false alarm
    delays: Mapping[str, float]  # detection delay by fault [s]; infinite where no test alarmed
    # finding with a vehicle file that gives the d-axis inductance alone; None for a machine with surface magnets
    plain: Finding | None = None


def vehicle(name: str, salient: bool = True) -> Vehicle:
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
    plain = base.parameters["motor_resistance"]
    changed = {each: replace(base.parameters.get(each, plain), value=value) for each, value in known.items()}
    if not salient:
        del changed["motor_saliency"]
    return replace(base, parameters={**base.parameters, **changed})


def judged(task: tuple[str, int, float]) -> Judged:
    """Judge a drive of a machine, fault-free and with every fault.

    Args:
        task: name of the machine, seed, and duration of the drive [s]
    """
    name, seed, seconds = task
    drive, pole_pairs = motor_drive(name, seed, seconds), float(MACHINES[name].pole_pairs)
    monitor = MotorAngleMonitor.of_vehicle(vehicle(name), SAMPLE_TIME)
    free = scan(monitor, drive.samples)
    known = free["compared.known"] > 0.5
    # The complex exponential wraps the error, so that a whole turn between the two angles does not count.
    away = np.angle(np.exp(1j * pole_pairs * (free["estimate.motor_angle"] - drive.angle)))[known]
    start = START * seconds / SECONDS
    since = SAMPLE_TIME * np.arange(len(drive.angle)) - start
    delays = {}
    for fault, change in FAULTS.items():
        samples = drive.samples.copy()
        samples[:, ANGLE] = change(samples[:, ANGLE], since, pole_pairs)
        alarms = alarms_of(scan(monitor, samples), since >= 0.0)
        delays[fault] = min(alarms.values(), default=np.inf)
    error = float(np.sqrt(np.mean(away**2))) if known.any() else np.nan
    false = tuple(alarms_of(free, np.ones(len(since), bool)))
    plain = None
    if MACHINES[name].direct != MACHINES[name].quadrature:
        plain = diagnose(recorded(drive), vehicle(name, salient=False), "motor-angle", spread=False).findings[0]
    return Judged(name, SAMPLE_TIME * float(known.sum()), error, false, delays, plain)


def recorded(drive: MotorDrive) -> Recording:
    """The drive as a recording of its available signals."""
    time = SAMPLE_TIME * np.arange(len(drive.angle))
    columns = zip(MotorAngleSample._fields, drive.samples.T, strict=True)
    there = {name: values for name, values in columns if np.isfinite(values).any()}
    return Recording({name: Channel(name, time, values, SIGNALS[name].unit) for name, values in there.items()})


def alarms_of(outputs: Result, during: np.ndarray) -> dict[str, float]:
    """Detection delay from the first sample of `during`, for every test that alarms in it [s]."""
    begin = int(np.argmax(during))
    found = {}
    for name in outputs.names:
        if name.startswith("alarms.") and (outputs[name][during] > 0.5).any():
            found[name.partition(".")[2]] = SAMPLE_TIME * int(np.argmax(outputs[name][begin:] > 0.5))
    return found


def items(effort: Effort) -> Iterator[Item]:
    yield Heading("Motors of motulator", TEXT)
    seed, drives = MOTORS.of(BY_NAME, 1)[0], 3 if effort.thorough else 1
    machines = list(MACHINES)[:1] if effort.quick else list(MACHINES)
    tasks = [(name, seed + number, SECONDS) for name in machines for number in range(drives)]
    try:
        found = effort.made(judged, tasks)
    except InputError as error:
        yield Heading("Not judged", (str(error),))
        return
    yield from shown(found)


def shown(found: Sequence[Judged]) -> Iterator[Item]:
    """Table and claims."""
    names = list(dict.fromkeys(each.machine for each in found))
    names.sort(key=lambda name: -sum(bool(each.false) for each in found if each.machine == name))
    rows = []
    for name in names:
        own = [each for each in found if each.machine == name]
        false = sorted({test for each in own for test in each.false})
        cells = []
        for fault in FAULTS:
            times = [each.delays[fault] for each in own]
            reached = [each for each in times if np.isfinite(each)]
            cells.append(f"{len(reached)} of {len(times)}" + (f", {max(reached):.2f} s" if reached else ""))
        turning, error = sum(each.turning for each in own), max(each.error for each in own)
        rows.append((name, f"{turning:.0f} s", ", ".join(false) or "none", f"{error:.3f}", *cells))
    header = ("machine", "turning", "false alarms", "error of the angle [rad el]", *FAULTS)
    note = "Of each fault: drives in which it was found, and the longest delay. Machines with false alarms come first."
    yield Table("The motor's angle sensor on motulator's drives", header, tuple(rows), note)
    yield Claim(
        "motors.false-alarms",
        "Fault-free drives of motulator with an alarm.",
        GOAL,
        None,
        float(sum(bool(each.false) for each in found)),
        exactly(0.0),
        "",
        f"Of {len(found)}, {sum(each.turning for each in found):.0f} s of turning.",
    )
    unaware = [each for each in found if each.plain is not None]
    yield Claim(
        "motors.without-saliency",
        "Fault-free drives of interior magnets called a fault where the vehicle file gives one inductance of two.",
        GOAL,
        None,
        float(sum(each.plain.status is Status.FAULT for each in unaware if each.plain)) if unaware else None,
        exactly(0.0),
        "",
        f"Of {len(unaware)}; found: {', '.join(sorted({each.plain.status.value for each in unaware if each.plain}))}. "
        "Such a motor turns the observed angle under load; the finding asks for motor_saliency.",
    )
    tried = [delay for each in found for delay in each.delays.values()]
    yield Claim(
        "motors.faults-found",
        "Share of the faults of the sensor that are found on motulator's drives.",
        GOAL,
        None,
        float(np.mean(np.isfinite(tried))),
        at_least(0.99),
        "",
        f"{len(tried)} faults in the recording alone.",
    )
