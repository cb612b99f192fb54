"""Position control of the column on observed states, in the order of the paper, with its figure 10."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from tierod.core.content import Chart, Heading, Item, Lines, Panel
from tierod.core.graph import scan
from tierod_lab.papers.column import tracking
from tierod_lab.papers.column.closed_loop import BEGIN, SAMPLE_TIME, ClosedLoop, Run, belief, sweep
from tierod_lab.studies.effort import Effort

TEXT = (
    "The paper closes the loop with a first attempt at a linear quadratic regulator on observed states and shows one "
    "sweep. Here the regulator has integral action, a plan from the flat output (the steering wheel's angle, of which "
    "the reference's derivatives give every state and torque), friction fed forward, limits of torque and its rate. "
    "What it finds from one sample acts from the next on.",
    "The plant is the simulated bench with its gear and Dahl friction; noise of 0.05° and 0.2° on the angles of "
    "steering wheel and motor, 0.02 N·m on the torsion bar. The angle that counts is that of the gear, which no sensor "
    "measures. Where nothing else is said, the observer is the paper's mechanical reduction.",
)


def items(effort: Effort) -> Iterator[Item]:
    loops = {name: tracking.loop_with(name) for name in tracking.observers(belief())}
    chosen = loops[tracking.CHOSEN]
    yield Heading("Position control", TEXT)
    yield from tracking.items(loops, effort)
    shown = {name: loops[name] for name in tracking.PRINTED}
    yield chart(sweep(chosen, 1, effort.quick)[0], shown)


EVERY = 10
"""Decimation of the drawn curves [samples]."""

WINDOW = 21
"""Width of the centred, and thus delay-free, moving average of differentiated angles [samples]."""


def chart(done: Run, loops: Mapping[str, ClosedLoop]) -> Chart:
    """Chart of the six graphs of figure 10.

    Args:
        done: the sweep under control
        loops: loops by name whose observers are shown in the fourth graph, fed with the measurements of the sweep
    """
    return Chart(
        "figure-10",
        "Figure 10 anew",
        "The sweep of the output shaft, 30° from 0.1 to 3 Hz, on the simulated bench. Differences are averaged over "
        f"{WINDOW} ms without delay, afterwards; the filtered and estimated curves are what the control had.",
        "Six graphs of the sweep. Reference and shaft lie on each other; estimated curves lie on those from "
        "differences; the observers see torques of hands of some tenths of a newton metre where there are none.",
        tuple(Panel(title, "time in s", unit, marks) for (title, unit), marks in _marks(done, loops).items()),
    )


def _marks(done: Run, loops: Mapping[str, ClosedLoop]) -> dict[tuple[str, str], tuple[Lines, ...]]:
    signals, ratio = done.signals, next(iter(loops.values())).control.column.motor_ratio
    wheel, motor = signals["measured.steering_wheel_angle"], signals["measured.motor_angle_mechanical"] / ratio

    def curve(name: str, values: np.ndarray, dashed: bool = False) -> Lines:
        return Lines(name, (done.time - BEGIN)[::EVERY], values[::EVERY], dashed)

    def degrees(name: str, values: np.ndarray, dashed: bool = False) -> Lines:
        return curve(name, np.degrees(values), dashed)

    angle, rate = "angle in °", "rate in °/s"
    return {
        ("Output shaft", angle): (
            degrees("reference", done.reference.angle, True),
            degrees("output shaft", signals["plant.truth_gear_angle"]),
        ),
        ("Steering wheel", angle): (
            degrees("measured", wheel),
            degrees("filtered", signals["observed.steering_wheel_angle"]),
        ),
        ("Rate of the steering wheel", rate): (
            degrees("from differences", differences(wheel)),
            degrees("estimated", signals["observed.steering_wheel_rate"]),
        ),
        ("Torque of the driver's hands, who are not there", "torque in N·m"): tuple(
            curve(name, hand_torque(done, loop)) for name, loop in loops.items()
        ),
        ("Motor, at the steering wheel axis, and steering wheel", angle): (
            degrees("motor, measured", motor),
            degrees("motor, filtered", signals["observed.motor_angle"] / ratio),
            degrees("steering wheel, filtered", signals["observed.steering_wheel_angle"]),
        ),
        ("Their rates", rate): (
            degrees("motor, from differences", differences(motor)),
            degrees("motor, estimated", signals["observed.motor_speed"] / ratio),
            degrees("steering wheel, estimated", signals["observed.steering_wheel_rate"]),
        ),
    }


def differences(values: np.ndarray) -> np.ndarray:
    """Rate of the values by differences, smoothed by the centred moving average [unit of the values/s]."""
    padded = np.pad(np.gradient(values, SAMPLE_TIME), WINDOW // 2, mode="edge")
    return np.convolve(padded, np.full(WINDOW, 1.0 / WINDOW), mode="valid")


def hand_torque(done: Run, loop: ClosedLoop) -> np.ndarray:
    """Hand torque by the observer of another loop on the measurements of a run [N m]."""
    # An observer receives the torque that acted until its sample: the command of the sample before.
    acted = np.concatenate([[0.0], done.signals["plant.motor_target_torque"][:-1]])
    measured = [
        done.signals[f"measured.{name}"] for name in ("steering_wheel_angle", "motor_angle_mechanical", "driver_torque")
    ]
    return np.asarray(scan(loop.observer, np.column_stack([acted, *measured]))["hand_torque"])
