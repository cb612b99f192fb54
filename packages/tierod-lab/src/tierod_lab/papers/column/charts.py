"""Charts of the study of the column: the paper's Figures 4, 5, 7 and 10, and a pull during the sweep."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from tierod.core.content import Band, Chart, Lines, Panel
from tierod.core.graph import scan
from tierod.methods.identification.column import identify_column
from tierod.models.column_observation import linear_column
from tierod.models.linear import LinearSystem
from tierod.models.steering_column import SteeringColumn
from tierod_lab.papers.column.closed_loop import BEGIN, SAMPLE_TIME, ClosedLoop, Run, sweep
from tierod_lab.papers.column.columns import SETS, reduced_columns
from tierod_lab.papers.column.frequency_response import MeasuredResponse, decibels, frequency_response, phase
from tierod_lab.papers.column.hand_datasets import loops, observers
from tierod_lab.papers.column.identified_bench import bench, recorded
from tierod_lab.papers.column.model_datasets import (
    HIGHEST,
    LOWEST,
    MOTOR_SIDE,
    SHORT,
    WHEEL_SIDE,
    Excitation,
    model_gain,
    response,
    start,
)
from tierod_lab.papers.column.model_reduction import Reduction
from tierod_lab.papers.column.reported import SEEDS
from tierod_lab.papers.column.swept_bench import samples, swept
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.metrics import Frame

FREQUENCY = np.geomspace(0.5, 300.0, 400)  # Frequencies of the curves [Hz]
DRAWN = ("mechanical, series", "mechanical, printed", "balanced", "balanced, without D")
"""Reductions that are drawn; the curves of the others coincide with one of these."""
EVERY = 10  # Decimation of the drawn curves [samples]
WINDOW = 21  # Width of the centred, and thus delay-free, moving average of differentiated angles [samples]


def charts(frames: Mapping[str, Frame], effort: Effort) -> Iterator[Chart]:
    """All charts, from drives that are simulated once more."""
    yield _reduced_chart()
    first, second = SEEDS.of("frequency response", 2)
    seconds = 60.0 if effort.quick else 240.0
    measured = {"noise, no friction": response(Excitation(0.0, seconds, first))}
    for amplitude in (0.12, 0.4, 1.0):
        measured[f"sweep of {amplitude:g} N·m"] = response(Excitation(amplitude, seconds, second))
    yield _measured_chart(measured)
    if not effort.quick:
        yield _matching()
    yield _pull()
    chosen = loops()["printed, mechanical"]
    shown = {name: loops()[name] for name in ("printed, mechanical", "printed, balanced")}
    yield _figure_10(sweep(chosen, 1, effort.quick)[0], shown)


def _matching() -> Chart:
    records = recorded(bench(), SEEDS.of("identified under other conditions", 2)[1], seconds=SHORT)
    result = identify_column(start(), records, (*WHEEL_SIDE, *MOTOR_SIDE))
    locked = next(each for each in result.shown if each.name == "sweep, wheel locked")
    marks = (
        Lines("measured", locked.time, locked.measured[:, 2]),
        Lines("simulated", locked.time, locked.simulated[:, 2], dashed=True),
    )
    return Chart(
        "column-figure-4",
        "Torque of the bar in a sweep with the wheel locked (Figure 4)",
        "The model is given the torque of the motor alone.",
        "Measured and simulated torque of the bar over time, one on the other",
        (Panel("", "time (s)", "torque of the bar (N·m)", marks),),
    )


def _pull() -> Chart:
    drive = swept("steps", 40.0, SEEDS.of("observers on the bench", 1)[0])
    time = drive["time"]
    thin = np.flatnonzero((time > 21.0) & (time < 29.0))[::5]
    marks = []
    for name in ("paper: series spring", "paper: balanced", "default", "20 ms later"):
        block, delay = observers()[name]
        marks.append(Lines(name, time[thin] - 1e-3 * delay, scan(block, samples(drive))["hand_torque"][thin]))
    marks.append(Lines("true", time[thin], drive["hand_torque"][thin], dashed=True))
    return Chart(
        "column-hand-torque",
        "A pull of 2 N·m during the sweep",
        "The estimate with a lag is drawn where it belongs, 20 ms before it is known.",
        "The torque of the hands rising to 2 N·m and back, with noise of 0.1 N·m for the paper's observers and next to "
        "none for tierod's.",
        (Panel("Torque of the hands", "time (s)", "torque (N·m)", tuple(marks)),),
    )


def _reduced_chart() -> Chart:
    """Gain, phase and error of a column and its reductions, from the motor's torque to that of the bar."""
    systems = {"whole column": linear_column(SteeringColumn, SETS["S1"])}
    for name, way in reduced_columns(SETS["S1"]).items():
        if name in DRAWN:
            systems[name] = way.system if isinstance(way, Reduction) else way
    words, unit = "torque of the bar", "N·m/N·m"
    gains = {key: gain_of_bar(each, FREQUENCY) for key, each in systems.items()}
    whole, *reduced = gains
    sizes = [Lines(key, FREQUENCY, decibels(gain), dashed=key != whole) for key, gain in gains.items()]
    phases = [Lines(key, FREQUENCY, phase(gain), dashed=key != whole) for key, gain in gains.items()]
    size = np.abs(gains[whole])
    errors = [Lines(key, FREQUENCY, 100.0 * np.abs(gains[key] - gains[whole]) / size, dashed=True) for key in reduced]
    return Chart(
        "column-figure-7",
        "Reduced columns compared (Figure 7)",
        f"From the motor's torque to the {words}. Dashed: with four states, which follow the column up to its first "
        "resonance, but not to that of the gear. Without its feedthrough (D) the balanced one is wrong by as much as "
        "D at all frequencies.",
        f"Bode plot from the motor's torque to the {words}, and the error of the reduced columns.",
        (
            Panel("Gain", "", f"dB of {unit}", tuple(sizes), logarithmic_along=True),
            Panel("Phase", "", "degrees", tuple(phases), logarithmic_along=True),
            Panel("Error", "frequency (Hz)", "% of the gain", tuple(errors), logarithmic=True, logarithmic_along=True),
        ),
    )


def _measured_chart(responses: Mapping[str, MeasuredResponse]) -> Chart:
    """Measured responses from the motor's torque to that of the bar, with that of the linear column and coherence."""
    frequency = np.geomspace(LOWEST, HIGHEST, 400)
    model, words, unit = model_gain(frequency), "torque of the bar", "N·m/N·m"
    computed = phase(model)
    sizes: list[Lines | Band] = [Lines("linear column", frequency, decibels(model))]
    angles = [Lines("linear column", frequency, computed)]
    for name, found in responses.items():
        sizes += _measured_gain(found, name)
        near = np.interp(found.frequency, frequency, computed)
        angles.append(Lines(name, found.frequency, _turned(phase(_usable(found)), near)))
    shares = [Lines(name, each.frequency, each.coherence) for name, each in responses.items()]
    return Chart(
        "column-figure-5",
        f"Measured: from the motor's torque to the {words}",
        "Measured by spectra averaged over pieces of the record (Welch), with the 95 % confidence band of the gain, "
        "where the coherence is 0.5 or more. Friction makes gain and coherence fall where the motor hardly overcomes "
        "it.",
        f"Measured and computed frequency response from the motor's torque to the {words}, with coherence.",
        (
            Panel("Gain", "", f"dB of {unit}", tuple(sizes), logarithmic_along=True),
            Panel("Phase", "", "degrees", tuple(angles), logarithmic_along=True),
            Panel(
                "Coherence",
                "frequency (Hz)",
                "share",
                tuple(shares),
                levels=(("shown above", 0.5),),
                logarithmic_along=True,
            ),
        ),
    )


def gain_of_bar(system: LinearSystem, frequency: np.ndarray) -> np.ndarray:
    """Complex gain from the motor's torque to that of the bar, at frequencies [Hz]."""
    return frequency_response(system, frequency).of("driver_torque", "motor_torque")


def _turned(angle: np.ndarray, near: np.ndarray) -> np.ndarray:
    """A phase shifted by the whole turns that bring it closest to another one [deg]."""
    known = np.isfinite(angle)
    return angle + 360.0 * np.round(np.median((near - angle)[known]) / 360.0) if known.any() else angle


def _usable(response: MeasuredResponse) -> np.ndarray:
    return np.where(response.usable(), response.gain, np.nan)


def _measured_gain(response: MeasuredResponse, name: str) -> Iterator[Lines | Band]:
    low, high = (np.where(response.usable(), end, np.nan) for end in response.band())
    yield Lines(name, response.frequency, decibels(_usable(response)))
    yield Band(name, response.frequency, decibels(low), decibels(high))


def _figure_10(done: Run, loops: Mapping[str, ClosedLoop]) -> Chart:
    """The six graphs of Figure 10; the observers of the loops are fed with the measurements of the sweep."""
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
