"""A driver takes the wheel under position control: detection delay, time until the torque is gone, false detections."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.claims import Claim, at_least, at_most, exactly
from tierod.core.content import Chart, Item, Lines, Panel, Table
from tierod.experiments.effort import Effort
from tierod.papers.column.closed_loop import BEGIN, ClosedLoop, Run, holding, run, sweep
from tierod.papers.column.control.reference import Sweep
from tierod.papers.column.reported import GRIPS, SEEDS, SWEEPS
from tierod.papers.column.tracking import CHOSEN, PRINTED, deaf, loop_with
from tierod.proving_ground.cars.column_bench import ColumnBench

HOLDS = {"light, 10 N·m/rad": 10.0, "firm, 30 N·m/rad": 30.0, "stiff, 100 N·m/rad": 100.0}
"""Stiffness of the arms by kind of hold [N m/rad]."""
FIRM = "firm, 30 N·m/rad"
FREQUENCIES = (0.1, 0.3, 1.0, 3.0)
"""Frequencies of the sines in which the driver takes the wheel [Hz]."""
CROSSED = 1.0
"""Hand torque at which the detection delay begins [N m]."""


class Taken(NamedTuple):
    """Times of one grip [s]; NaN for an event that did not occur.

    Args:
        crossed: from the grip until the true hand torque exceeds 1 N m
        found: from that crossing until the driver is detected
        gone: from the grip until the motor torque is zero
        freed: from the crossing until the motor torque is zero
    """

    crossed: float
    found: float
    gone: float
    freed: float


def taken(done: Run, grip: float) -> Taken:
    """Times of a grip that begins at the time `grip` [s]."""
    after = done.time >= grip
    hands = np.abs(done.signals["plant.truth_hand_torque"]) > CROSSED
    crossed = _first(done.time, after & hands)
    found = _first(done.time, after & (done.signals["controller.driver.found"] > 0.5))
    gone = _first(done.time, after & (done.signals["plant.motor_target_torque"] == 0.0))
    return Taken(crossed - grip, found - crossed, gone - grip, gone - crossed)


def _first(time: np.ndarray, holds: np.ndarray) -> float:
    where = np.nonzero(holds)[0]
    return float(time[where[0]]) if len(where) else float("nan")


def items(loops: Mapping[str, ClosedLoop], effort: Effort) -> Iterator[Item]:
    """Tables, chart and claims on grips, false detections and wrong inertias."""
    loop = loops[CHOSEN]
    yield from _grips(effort)
    yield _picture(loop)
    yield from _false(loops, effort)
    yield from _inertia(loop)


def _grips(effort: Effort) -> Iterator[Item]:
    count = 4 if effort.quick else 16
    kinds = [(name, frequency) for name in HOLDS for frequency in FREQUENCIES]
    grips = effort.made(_taken, [(name, frequency, k, count) for name, frequency in kinds for k in range(count)])
    holds = {kind: grips[count * place : count * (place + 1)] for place, kind in enumerate(kinds)}
    rows = []
    for (name, frequency), found in holds.items():
        columns = [np.array(column) for column in zip(*found, strict=True)]
        rows.append((f"{name}, {frequency:g} Hz", *(cell for column in columns for cell in _cells(column))))
    yield Table(
        f"A driver holds against sines of 30° ({count} grips over a period each), in ms: median, worst",
        (
            "hold",
            "1 N·m after the grip",
            "worst",
            "found after 1 N·m",
            "worst",
            "torque gone after the grip",
            "worst",
            "torque gone after 1 N·m",
            "worst",
        ),
        tuple(rows),
        "The hands hold the wheel where they took it. A grip near the turning point of a slow sine meets no torque for "
        "long: nothing is to be found before the wheel moves against the hands. A negative time: found before 1 N·m.",
    )
    firm = {frequency: found for (name, frequency), found in holds.items() if name == FIRM}
    yield from _claims(firm)


def _taken(case: tuple[str, float, int, int]) -> Taken:
    """One of several grips spread over a period, with other noise than in the design of the rule."""
    hold, frequency, k, count = case
    grip = BEGIN + 2.0 + (k + 0.2) / count / frequency
    loop = replace(loop_with(CHOSEN), bench=holding(HOLDS[hold]))
    return taken(run(loop, Sweep(start=frequency, stop=frequency), grip + 2.0, SEEDS.of(GRIPS, count)[k], grip), grip)


def _claims(firm: Mapping[float, list[Taken]]) -> Iterator[Item]:
    all_found = [each.found for found in firm.values() for each in found]
    soon = [each.gone for frequency, found in firm.items() for each in found if frequency >= 1.0]
    yield Claim(
        "position.driver-found",
        "A driver who holds the wheel firmly is found soon after 1 N·m.",
        "tierod",
        None,
        1e3 * float(np.max(all_found)),
        at_most(60.0),
        "ms",
        f"Worst of {len(all_found)} grips, 0.1 to 3 Hz; median {1e3 * float(np.median(all_found)):.0f} ms.",
    )
    yield Claim(
        "position.control-gone",
        "The motor's torque is gone soon after a firm grip at 1 and 3 Hz.",
        "tierod",
        None,
        1e3 * float(np.max(soon)),
        at_most(350.0),
        "ms",
        f"Worst of {len(soon)} grips at 1 and 3 Hz. Slower sines take their time to reach 1 N·m; the table has them.",
    )


def _cells(column: np.ndarray) -> tuple[str, str]:
    there = column[np.isfinite(column)]
    if not len(there):
        return "–", "–"
    missed = len(column) - len(there)
    return f"{1e3 * np.median(there):.0f}", f"{1e3 * there.max():.0f}" + (f" ({missed} never)" if missed else "")


def _picture(loop: ClosedLoop) -> Chart:
    grip = BEGIN + 3.1
    done = run(replace(loop, bench=holding(HOLDS[FIRM])), Sweep(start=1.0, stop=1.0), grip + 1.0, 2, grip)
    shown = (done.time > grip - 0.3) & (done.time < grip + 0.7)
    time, signals = done.time[shown] - grip, done.signals

    def curve(name: str, values: np.ndarray, dashed: bool = False) -> Lines:
        return Lines(name, time, values[shown], dashed)

    return Chart(
        "takeover",
        "A driver takes the wheel",
        "A firm hold of 30 N·m/rad while the shaft follows 1 Hz. Time counts from the grip.",
        "The hands' torque passes 1 newton metre, the motor's torque falls to zero within a tenth of a second.",
        (
            Panel(
                "Angles",
                "time in s",
                "angle in °",
                (
                    curve("reference", np.degrees(done.reference.angle), True),
                    curve("output shaft", np.degrees(signals["plant.truth_gear_angle"])),
                    curve("steering wheel", np.degrees(signals["plant.steering_wheel_angle"])),
                ),
            ),
            Panel(
                "Torque of the hands",
                "time in s",
                "torque in N·m",
                (
                    curve("true", signals["plant.truth_hand_torque"]),
                    curve("observed", signals["hand_torque"]),
                ),
                levels=(("1 N·m", CROSSED), ("−1 N·m", -CROSSED)),
            ),
            Panel(
                "Torque of the motor",
                "time in s",
                "torque in N·m",
                (curve("asked for", signals["plant.motor_target_torque"]),),
            ),
        ),
    )


def _false(loops: Mapping[str, ClosedLoop], effort: Effort) -> Iterator[Item]:
    count = 1 if effort.quick else 4
    ends = {
        name: sum(sweep(loops[name], seed, effort.quick)[1].found for seed in SEEDS.of(SWEEPS, count))
        for name in PRINTED
    }
    yield Claim(
        "position.no-false-end",
        "The sweep never ends because of a driver who is not there.",
        "tierod",
        None,
        float(sum(ends.values())),
        exactly(0.0),
        "",
        f"False ends in {count * len(ends)} sweeps, {count} with each printed observer.",
    )


def _inertia(loop: ClosedLoop) -> Iterator[Item]:
    errors = (-0.2, -0.15, -0.1, -0.05, -0.02, 0.0, 0.02, 0.05, 0.1, 0.15, 0.2)
    controller = loop.controller
    unaware = replace(
        loop,
        controller=replace(controller, intervention=replace(controller.intervention, inertia_uncertainty=0.0)),
    )
    rows = []
    ended: dict[bool, list[float]] = {True: [], False: []}
    for share in errors:
        bench = ColumnBench()
        wrong = replace(bench, wheel_inertia=bench.wheel_inertia * (1.0 + share))
        cells = []
        for aware, each in ((False, unaware), (True, loop)):
            done = run(replace(each, bench=wrong), Sweep(start=3.0, stop=3.0), BEGIN + 8.0, 12)
            ends = int(done.signals["controller.driver.found"].sum())
            if ends:
                ended[aware].append(abs(share))
            if not aware:
                feigned = _feigned(loop, wrong)
                cells.append(f"{feigned:.2f}")
            cells.append("ended" if ends else "goes on")
        rows.append((f"{100.0 * share:+g} %", *cells))
    yield Table(
        "Inertia of the steering wheel wrong, sine of 30° at 3 Hz without hands",
        ("wheel", "feigned torque of hands at 3 Hz, N·m", "control, nothing forgiven", "control, file's 4 % forgiven"),
        tuple(rows),
        "Amplitude of the observed torque at the frequency of the sine. What is forgiven is twice the standard "
        "deviation that the file gives for the wheel's inertia, times the planned acceleration.",
    )
    highest = [min([*ended[aware], 1.0]) for aware in (False, True)]
    held = [max((abs(share) for share in errors if abs(share) < end), default=0.0) for end in highest]
    yield Claim(
        "position.inertia-tolerated",
        "A wrong inertia of the steering wheel does not feign a driver.",
        "tierod",
        None,
        100.0 * held[1],
        at_least(2.0),
        "%",
        f"Largest error of those tried, either sign, with which 3 Hz goes on; {100.0 * held[0]:g} % with nothing "
        "forgiven for it.",
    )


def _feigned(loop: ClosedLoop, bench: ColumnBench) -> float:
    """Amplitude of the observed hand torque at 3 Hz without hands, with driver detection disabled [N m]."""
    done = run(replace(deaf(loop), bench=bench), Sweep(start=3.0, stop=3.0), BEGIN + 6.0, 12)
    steady = done.time >= BEGIN + 2.0 - 1e-9
    turning = np.exp(-6j * np.pi * done.time[steady])
    return float(2.0 * abs(done.signals["hand_torque"][steady] @ turning) / steady.sum())
