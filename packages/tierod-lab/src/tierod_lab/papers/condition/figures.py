"""Figures of the paper redrawn from virtual drives: residuals beyond their thresholds, true and declared states."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from tierod.core.content import Chart, Heading, Item, Panel
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod_lab.papers.condition.drives import LOSS, SENSORS, TEST_SECONDS, Drive, Injected, both_motors, lost
from tierod_lab.papers.condition.recorded import recorded
from tierod_lab.papers.condition.rules.all_residuals import AllResiduals
from tierod_lab.papers.condition.rules.fit import samples_of
from tierod_lab.papers.condition.rules.parameters import ACTUATOR_RESIDUALS, SENSOR_RESIDUALS
from tierod_lab.papers.condition.rules.readings import Excitation
from tierod_lab.papers.condition.rules.rule_monitor import RuleMonitor
from tierod_lab.papers.condition.runs import BEST, VARIANTS, calibrations, diagnosed
from tierod_lab.papers.condition.tables import curves, flags, states
from tierod_lab.papers.condition.truth import Declared, truths
from tierod_lab.papers.condition.vehicles import SHORT
from tierod_lab.studies.effort import Effort

RULES = "rules"  # Variant whose residuals and thresholds are shown: the corrected equations

TEXT = (
    "The cases that the paper shows, on our short round: a lost left rear wheel speed (7, 8, 10), both steering motors "
    "without torque (13, 14), the left drive (16, 17), a lost yaw rate (21, 23), steering motor 1 (26, 27). Residuals "
    "are those of the corrected equations; a flag is up where one is beyond its threshold of calibration.",
)
BOTH = (
    "At fault in truth, and declared so. The bank has a hypothesis of both motors, as where their supply is lost; "
    "rules name both as one of several."
)
UNITS = ("m/s", "m/s", "rad/s", "rad", "N·m", "N")
EIGHT = tuple(f"r{number}a" for number in range(1, 9))  # Residuals of the actuators in the paper
_SEED, _LATE = 11, 21


def items(effort: Effort) -> Iterator[Item]:
    if RULES not in VARIANTS:
        return
    shown = [name for name in (RULES, BEST) if name in VARIANTS]
    known = calibrations(shown, (1,), effort)
    view = _View(known, shown)
    yield Heading("Figures of the paper", TEXT)
    yield _validation(view)
    wheel = Drive(SHORT, TEST_SECONDS, 1, _SEED, (Injected("wheel_speed_rear_left", LOSS),))
    yield view.symptoms("7", "Residuals with a lost left rear wheel speed", wheel, SENSOR_RESIDUALS, (15.0, 45.0))
    yield view.states("8", "States with a lost left rear wheel speed", wheel, SENSORS, (15.0, 45.0))
    yield _reconfigured(view, wheel)
    motors = both_motors()
    yield view.symptoms("13", "Both steering motors lost", motors, ACTUATOR_RESIDUALS, (100.0, 106.0), EIGHT)
    pair = ("steering_motor_1", "steering_motor_2")
    yield view.states("14", "Both steering motors lost", motors, pair, (100.0, 106.0), BOTH)
    drive = Drive(SHORT, 130.0, 1, _LATE, (lost("drive_left", end=130.0),))
    yield view.symptoms("16", "The left drive lost", drive, ACTUATOR_RESIDUALS, (98.0, 130.0), EIGHT)
    yield view.states("17", "The left drive lost", drive, ("drive_left", "drive_right"), (98.0, 130.0))
    yaw = Drive(SHORT, TEST_SECONDS, 1, _SEED, (Injected("yaw_rate", LOSS),))
    yield view.states("21", "A lost yaw rate", yaw, ("yaw_rate",), (15.0, 45.0))
    four = ("r2", "r4", "r7", "r11")
    yield view.symptoms("23", "Residuals with a lost yaw rate", yaw, SENSOR_RESIDUALS, (15.0, 45.0), four)
    motor = Drive(SHORT, 135.0, 1, _LATE, (lost("steering_motor_1", start=123.5, end=135.0),))
    yield view.states("26", "Steering motor 1 lost", motor, pair, (118.0, 130.0))
    four = ("r1a", "r4a", "r5a", "r6a")
    yield view.symptoms("27", "Residuals with steering motor 1 lost", motor, ACTUATOR_RESIDUALS, (118.0, 130.0), four)


class _View:
    def __init__(self, known: Mapping[tuple[str, int], Any], names: Sequence[str]):
        self.known, self.names = known, names
        self.monitor: RuleMonitor = known[VARIANTS[RULES].module, 1].monitor(RULES)

    def symptoms(
        self,
        number: str,
        title: str,
        drive: Drive,
        residuals: Sequence[Any],
        span: tuple[float, float],
        only: Sequence[str] = (),
    ) -> Chart:
        """Chart of the residuals that are beyond their thresholds."""
        recording = recorded(drive)
        ratios = self._ratios(recording)
        time = recording["yaw_rate"].time
        inside = (time >= span[0]) & (time < span[1])
        names = [each.name for each in residuals if each.name in (only or ratios)]
        # `flags` draws from bottom to top.
        rows = {name: (np.abs(ratios[name]) > 1.0)[inside] for name in reversed(names)}
        fault = drive.injected[0]
        panel = flags(title, time[inside], rows, fault.start, fault.end)
        return Chart(
            f"condition-figure-{number}",
            f"{title} (Figure {number})",
            "One row for each residual; up: beyond its threshold.",
            "Flags of residuals over time, up while something has failed.",
            (panel,),
        )

    def states(
        self,
        number: str,
        title: str,
        drive: Drive,
        elements: Sequence[str],
        span: tuple[float, float],
        caption: str = "",
    ) -> Chart:
        """Chart of true and declared states."""
        recording = recorded(drive)
        said = {name: diagnosed(name, drive, recording, self.known) for name in self.names}
        time = recording["yaw_rate"].time
        inside = (time >= span[0]) & (time < span[1])
        real = truths(drive, time)
        fault_free = np.zeros(len(time), bool)
        panels = []
        for element in elements:
            declared = {VARIANTS[name].title: _state(each, element)[inside] for name, each in said.items()}
            known = real.get(element, fault_free)[inside]
            panels.append(states(element.replace("_", " "), time[inside], known, declared))
        return Chart(
            f"condition-figure-{number}",
            f"{title} (Figure {number})",
            caption or "At fault in truth, and declared so; declared states are drawn a little higher.",
            "Real and declared state over time.",
            tuple(panels),
        )

    def _ratios(self, recording: Recording) -> dict[str, np.ndarray]:
        monitor = self.monitor
        result = scan(AllResiduals(monitor.sensors, monitor.actuators), samples_of(recording))
        lively = Excitation._make(result[f"excitation.{name}"] for name in Excitation._fields)
        return {
            name: np.where(result[f"there.{name}"] > 0.5, threshold.ratio(result[f"residuals.{name}"], lively), 0.0)  # type: ignore[arg-type]  # arrays
            for name, threshold in monitor.thresholds.items()
        }


def _state(each: Declared, element: str) -> np.ndarray:
    return np.where(each.said("faulty", element), 1.0, 0.5 * each.said("candidates", element))


def _validation(view: _View) -> Chart:
    drive = Drive(SHORT, TEST_SECONDS, 1, _SEED)
    recording = recorded(drive)
    time = recording["yaw_rate"].time
    inside = (time >= 15.0) & (time < 45.0)
    values = diagnosed(view.names[-1], drive, recording, view.known).value
    panels: list[Panel] = []
    for name, unit in zip(SENSORS, UNITS, strict=True):
        both = {"read": recording[name].values[inside], "expected by the model": np.asarray(values[name])[inside]}
        title = name.replace("_", " ")
        panels.append(
            curves(title, f"{title.split()[-1]} [{unit}]" if unit != "m/s" else "speed [m/s]", time[inside], both)
        )
    return Chart(
        "condition-figure-5",
        "What the model expects of each sensor (Figure 5)",
        "Half a minute of the short round, nothing at fault.",
        "Six pairs of curves that hardly differ.",
        tuple(panels),
    )


def _reconfigured(view: _View, drive: Drive) -> Chart:
    recording = recorded(drive)
    time = recording["yaw_rate"].time
    inside = (time >= 15.0) & (time < 45.0)
    name = "wheel_speed_rear_left"
    said = diagnosed(view.names[-1], drive, recording, view.known)
    values = {"true": recording[f"truth_{name}"].values, "read": recording[name].values, "given on": said.value[name]}
    cut = {key: each[inside] for key, each in values.items()}
    panel = curves("left rear wheel", "speed [m/s]", time[inside], cut, 3)
    return Chart(
        "condition-figure-10",
        "A lost wheel speed and what replaces it (Figure 10)",
        "Readings and true speed differ by the error of the tyre radius in the sensor; the value passed on is what the "
        "fault-free sensor would read.",
        "A speed that drops to zero between 20 and 40 s, and one in its place that goes on.",
        (panel,),
    )
