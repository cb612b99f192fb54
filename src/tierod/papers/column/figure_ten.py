"""Figure 10 of the paper anew: its six graphs over the sweep."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tierod.core.content import Chart, Lines, Panel
from tierod.core.graph import scan
from tierod.papers.column.closed_loop import BEGIN, SAMPLE_TIME, ClosedLoop, Run

EVERY = 10
"""Samples of which one is drawn."""

WINDOW = 21
"""Samples over which differences of measured angles are averaged, ahead and back alike: late by nothing."""


def chart(done: Run, loops: Mapping[str, ClosedLoop]) -> Chart:
    """The six graphs.

    Args:
        done: the sweep under control
        loops: those whose observers are shown in the fourth graph, by name; they see what was measured
    """
    return Chart(
        "figure-10",
        "Figure 10 anew",
        "The sweep of the output shaft, 30° from 0.1 to 3 Hz, on the simulated bench. Differences are averaged over "
        f"{WINDOW} ms without delay, afterwards; the filtered and estimated curves are what the controller had.",
        "Six graphs of the sweep. Reference and shaft lie on each other; estimated curves lie on those from "
        "differences; the observers see torques of hands of some tenths of a newton metre where there are none.",
        tuple(Panel(title, "time in s", unit, marks) for (title, unit), marks in _marks(done, loops).items()),
    )


def _marks(done: Run, loops: Mapping[str, ClosedLoop]) -> dict[tuple[str, str], tuple[Lines, ...]]:
    """Curves by title and unit of their graph."""
    signals, ratio = done.signals, next(iter(loops.values())).controller.position.column.motor_ratio
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
    """Rate from differences, averaged without delay."""
    padded = np.pad(np.gradient(values, SAMPLE_TIME), WINDOW // 2, mode="edge")
    return np.convolve(padded, np.full(WINDOW, 1.0 / WINDOW), mode="valid")


def hand_torque(done: Run, loop: ClosedLoop) -> np.ndarray:
    """What another loop's observer makes of a run."""
    acted = np.concatenate([[0.0], done.signals["plant.motor_target_torque"][:-1]])
    measured = [
        done.signals[f"measured.{name}"] for name in ("steering_wheel_angle", "motor_angle_mechanical", "driver_torque")
    ]
    return np.asarray(scan(loop.observer, np.column_stack([acted, *measured]))["hand_torque"])
