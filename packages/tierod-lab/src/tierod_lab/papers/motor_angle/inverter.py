"""Accuracy of the angle from commanded voltages, with dead time and forward drop of the inverter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Table
from tierod.core.graph import scan
from tierod.methods.identification.inverter import InverterFit, identify_inverter
from tierod.methods.identification.motor_recording import MotorRecording
from tierod.models.stator_frame_motor import CommandedMotorParameters
from tierod.monitors.motor_angle.evidence import InverterLoss
from tierod.monitors.motor_angle.facts import inverter_remarks
from tierod.monitors.motor_angle.observer import COMMANDED, MotorAngleObserver, MotorAngleTuning
from tierod.vehicles import load
from tierod_lab.ground.motor import Inverter
from tierod_lab.papers.motor_angle.observer_drives import SAMPLE_TIME, ObserverDrive, parameters, rms, to_and_fro
from tierod_lab.papers.motor_angle.reported import INVERTER, SEEDS, TARGET
from tierod_lab.studies.effort import Effort

LOSSY = Inverter(dead_time=1e-6, forward_drop=0.7, knee_current=1.0)
"""Inverter that takes 0.83 V from every phase, as much as the bench's motor induces at 24 rad/s."""
WRONG = 2.0
"""Factor of a wrong knee current, up or down."""
LEARNT = "learnt in the drive, knee"
HELD = "held, knee"
"""Start of the names of observers that estimate the knee current, and of those that keep it."""


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Voltages as commanded",
        (
            "A recording often holds the voltage that was commanded, not the one that the inverter made. Dead "
            "time and semiconductors take a constant voltage of each phase against its current, less below a knee. The "
            "bench's inverter has 1 µs of dead time and 0.7 V of drop here. The observer knows the command alone; its "
            "states are then the loss and the logarithm of the knee besides.",
        ),
    )
    count, seconds = (2, 8.0) if effort.quick else (8, 20.0)
    identifies, *judged = (to_and_fro(seed, seconds, inverter=LOSSY) for seed in SEEDS.of(INVERTER, 1 + count))
    drives, fit = judged, identified(identifies)
    found = {name: _errors(observer, drives) for name, observer in _observers(fit).items()}
    found["voltage measured"] = _errors(MotorAngleObserver(parameters()[1]), drives, commanded=False)
    yield _identified_table(fit)
    yield _table(found)
    yield _chart(drives[0])
    yield from _claims(found, drives)


def identified(seen: ObserverDrive) -> InverterFit:
    """Identify voltage loss and knee current from one drive."""
    current, command = (seen.commanded[:, k] + 1j * seen.commanded[:, k + 1] for k in (0, 2))
    recording = MotorRecording("drive", SAMPLE_TIME, seen.time, current, command, seen.samples[:, 4])
    return identify_inverter([recording], parameters()[0].motor_pole_pairs)


def said_wrong(seen: ObserverDrive, knee: float) -> bool:
    """Whether the remarks of a finding report that the knee current of the vehicle file is wrong.

    Args:
        seen: a drive
        knee: knee current of the vehicle file [A]
    """
    observer = _observer(knee)
    found = scan(observer, seen.commanded)
    last = {name: float(found[f"inverter_{name}"][-1]) for name in InverterLoss._fields[:3]}
    lost = InverterLoss(**last, nominal_knee=knee, widest=observer.tuning.widest_knee)
    # The first remark, on commanded voltages, always appears; a second one reports the wrong knee current.
    return len(inverter_remarks(lost, COMMANDED)) > 1


def _observer(knee: float, loss: float | None = None, tuning: MotorAngleTuning | None = None) -> MotorAngleObserver:
    known = load("motor-bench").parameters_for(CommandedMotorParameters)
    changed = replace(
        known,
        sample_time=SAMPLE_TIME,
        inverter_knee_current=knee,
        inverter_voltage_loss=known.inverter_voltage_loss if loss is None else loss,
    )
    return MotorAngleObserver(changed, tuning or MotorAngleTuning())


def _observers(fit: InverterFit) -> dict[str, MotorAngleObserver]:
    held = MotorAngleTuning(first_knee=0.0)
    found = {
        "command taken for the voltage": MotorAngleObserver(parameters()[1]),
        "loss and knee identified": _observer(fit.knee, fit.loss),
    }
    for knee in (1.0 / WRONG, 1.0, WRONG):
        found[f"{LEARNT} {knee:g} A assumed"] = _observer(knee)
    for knee in (1.0 / WRONG, WRONG):
        found[f"{HELD} {knee:g} A assumed"] = _observer(knee, tuning=held)
    return found


def _errors(observer: MotorAngleObserver, drives: Sequence[ObserverDrive], commanded: bool = True) -> np.ndarray:
    """Root mean square and largest error of every drive [rad], (2, n)."""
    found = []
    for seen in drives:
        away = scan(observer, seen.commanded if commanded else seen.samples)["motor_angle"] - seen.angle
        found.append((rms(away), np.abs(away).max()))
    return np.array(found).T


def _identified_table(fit: InverterFit) -> Table:
    true = LOSSY.supply_voltage * LOSSY.dead_time / SAMPLE_TIME + LOSSY.forward_drop
    rows = (
        ("loss (V)", f"{true:.3f}", f"{fit.loss:.4f} ± {fit.loss_deviation:.4f}"),
        ("knee (A)", f"{LOSSY.knee_current:.3f}", f"{fit.knee:.4f} ± {fit.knee * fit.knee_deviation:.4f}"),
    )
    note = (
        f"Left of the command: {100.0 * fit.unexplained:.1f} %; without a loss {100.0 * fit.without:.0f} %. "
        "tierod identify inverter does this."
    )
    return Table("The inverter, identified from another drive", ("", "true", "identified"), rows, note)


def _table(found: Mapping[str, np.ndarray]) -> Table:
    rows = tuple(
        (name, f"{np.median(each[0]):.4f}", f"{each[0].max():.4f}", f"{each[1].max():.3f}")
        for name, each in found.items()
    )
    note = (
        f"{len(next(iter(found.values()))[0])} drives; the true knee is at {LOSSY.knee_current:g} A, the loss 0.83 V."
    )
    header = ("what is known of the voltage", "rms, median", "rms, worst", "largest")
    return Table("Error of the angle (rad)", header, rows, note)


def _chart(seen: ObserverDrive) -> Chart:
    thin = slice(None, None, 100)
    marks = []
    for knee in (1.0 / WRONG, WRONG):
        found = scan(_observer(knee), seen.commanded)
        marks.append(Lines(f"{knee:g} A assumed", seen.time[thin], found["inverter_knee_current"][thin]))
    panel = Panel("", "time (s)", "knee (A)", tuple(marks), levels=(("true", LOSSY.knee_current),))
    return Chart(
        "motor-angle-knee",
        "A wrong knee is learnt",
        "Only while the motor turns faster than 8 rad/s; slower, a knee takes the place of the back-EMF.",
        "Two courses begin at half and twice the true knee and meet it within seconds.",
        (panel,),
    )


def _claims(found: Mapping[str, np.ndarray], drives: Sequence[ObserverDrive]) -> Iterator[Claim]:
    known = found["loss and knee identified"][0]
    yield Claim(
        "motor-angle.commanded.identified",
        "The angle is observable from commanded voltages and an identified inverter",
        TARGET,
        None,
        float(known.max()),
        at_most(0.01),
        "rad",
        f"Worst rms of {len(known)} drives; dead time 1 µs, 0.7 V; with measured voltages "
        f"{found['voltage measured'][0].max():.4f} rad.",
    )
    learnt = np.concatenate([each[0] for name, each in found.items() if name.startswith(LEARNT)])
    yield Claim(
        "motor-angle.commanded.learnt",
        "So do they with a knee of the vehicle file that is right, half or twice the true one",
        TARGET,
        None,
        float(learnt.max()),
        at_most(0.01),
        "rad",
        f"Worst rms of {len(learnt)} drives; held at half or twice, the worst is "
        f"{max(each[0].max() for name, each in found.items() if name.startswith(HELD)):.2f} rad.",
    )
    wrong = [said_wrong(seen, knee) for seen in drives for knee in (1.0 / WRONG, WRONG)]
    yield Claim(
        "motor-angle.commanded.wrong-knee-said",
        "A knee of the vehicle file that is half or twice the true one is said",
        TARGET,
        None,
        100.0 * float(np.mean(wrong)),
        at_least(100.0),
        "percent",
        f"Of {len(wrong)} drives.",
    )
    right = [said_wrong(seen, LOSSY.knee_current) for seen in drives]
    yield Claim(
        "motor-angle.commanded.right-knee-kept",
        "A right knee is not called wrong",
        TARGET,
        None,
        100.0 * float(np.mean(right)),
        at_most(0.0),
        "percent",
        f"Of {len(right)} drives.",
    )
