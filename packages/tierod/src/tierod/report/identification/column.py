"""Identification of a steering column on a test bench: tables and charts of parameters and fit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from tierod.core.content import Chart, Heading, Item, Lines, Panel, Table
from tierod.core.recording import Recording
from tierod.methods.identification.bench_recording import OUTPUTS, BenchParameters
from tierod.methods.identification.column import ColumnIdentification, Shown, identify_column
from tierod.report.display import number
from tierod.report.identification import Subject, correlations, found_table
from tierod.vehicles import Vehicle

_POINTS = 4000  # Largest number of points of a curve on the page
_COLUMN = "Another law of friction, or a torsion bar stiffer than in the vehicle file, changes the values by more."
_WINDOW = 4.0  # Length of the stretch of an experiment that is drawn, the one with the most torque variation [s]
_TITLES = {
    "steering_wheel_angle": ("angle of the wheel", "°", 180.0 / np.pi),
    "motor_angle_mechanical": ("angle of the motor", "°", 180.0 / np.pi),
    "driver_torque": ("torque of the bar", "N·m", 1.0),
}


def left_out_table(result: ColumnIdentification) -> Table:
    """Table of the leave-one-out estimates, and of the prediction errors for the experiment left out."""
    left = result.left_out
    rows = [(each.name, *(number(out.values.get(each.name), 5) for out in left)) for each in result.found]
    rows += [(f"error, {_TITLES[o][0]}", *(_percent(out.errors.get(o)) for out in left)) for o in OUTPUTS]
    header = ("", *(f"without {place}" for place in range(1, len(left) + 1)))
    names = ", ".join(f"{place}: {out.name}" for place, out in enumerate(left, 1))
    return Table(
        "Leave-one-out: fitted to all other experiments, and simulated against the one left out",
        header,
        tuple(rows),
        f"{names}. The error is the root mean square of simulated less measured output, over the standard deviation "
        "of the latter. The simulation does not include unrecorded torques, by which the angle of a free wheel drifts.",
    )


def column_items(result: ColumnIdentification) -> Iterator[Item]:
    yield Heading("What was found")
    yield found_table(result.found, _COLUMN)
    estimate = result.estimate
    rows = tuple(
        (name, number(estimate[name], 5), number(estimate.deviation(name), 2))
        for name in estimate.names
        if name not in {each.name for each in result.found}
    )
    noise = zip(("motor torque that was not recorded", *OUTPUTS), _noises(result), strict=True)
    rows += tuple((f"noise: {name}", value, "") for name, value in noise)
    yield Table("What the bench adds, found beside the parameters", ("", "value", "σ"), rows)
    yield correlations("Correlation of the estimates", estimate.names, estimate.correlation)
    yield Heading(
        "Simulated against measured", ("As in Figure 4 of Raffone: the model is given the motor's torque alone.",)
    )
    for number_, each in enumerate(result.shown):
        yield _matching(each, number_)
    yield Heading("Friction of the motor", ("As in Figure 3 of Raffone: Dahl's friction over the angle of the motor.",))
    yield _friction(result.shown)
    yield Heading("What is left over")
    yield _whiteness(result)
    yield _residuals(result.shown)
    if result.left_out:
        yield Heading("Left out one by one")
        yield left_out_table(result)


def _percent(value: float | None) -> str:
    return "–" if value is None or not np.isfinite(value) else f"{100.0 * value:.2g} %"


def _noises(result: ColumnIdentification) -> list[str]:
    estimate = result.estimate
    texts = [f"{number(estimate.input_deviation[0], 3)} N·m per sample"]
    for name, value in zip(OUTPUTS, estimate.output_deviation, strict=True):
        _, unit, factor = _TITLES[name]
        texts.append(f"{number(factor * value, 3)} {unit}")
    return texts


def _busiest(each: Shown) -> slice:
    """The window in which the torsion-bar torque varies most, thinned for drawing."""
    step = each.time[1] - each.time[0]
    width = min(round(_WINDOW / step), len(each.time))
    power = np.cumsum(np.nan_to_num(each.measured[:, 2] - np.nanmean(each.measured[:, 2])) ** 2)
    first = int(np.argmax(power[width - 1 :] - np.concatenate([[0.0], power])[: len(power) - width + 1]))
    return slice(first, first + width, max(width // _POINTS, 1))


def _matching(each: Shown, place: int) -> Chart:
    part = _busiest(each)
    time = each.time[part]
    panels = []
    for k, name in enumerate(OUTPUTS):
        title, unit, factor = _TITLES[name]
        if each.locked and name == "steering_wheel_angle":
            continue
        marks = (
            Lines("measured", time, factor * each.measured[part, k]),
            Lines("simulated", time, factor * each.simulated[part, k], dashed=True),
        )
        panels.append(
            Panel(f"{title}, error {_percent(each.errors.get(name))}", "time (s)", f"{title} ({unit})", marks)
        )
    wheel = "locked" if each.locked else "free"
    return Chart(
        f"matching-{place}",
        f"{each.name}, wheel {wheel}",
        f"The {_WINDOW:g} s in which the torque of the bar moves most.",
        f"Measured and simulated outputs of {each.name} over time",
        tuple(panels),
    )


def _friction(shown: Sequence[Shown]) -> Chart:
    level = max(float(np.ptp(each.friction)) for each in shown)
    sliding = [each for each in shown if np.ptp(each.friction) >= 0.9 * level]
    best = min(sliding, key=lambda each: float(np.sum(np.abs(np.diff(each.simulated[:, 1])))))
    step = max(len(best.time) // _POINTS, 1)
    angle = np.degrees(best.simulated[::step, 1])
    marks = (Lines("friction as identified", angle, best.friction[::step]),)
    panel = Panel("friction over angle", "angle of the motor (°)", "friction (N·m)", marks)
    return Chart(
        "friction-curve",
        f"Friction in {best.name}",
        "After every reversal the friction builds up along a curve towards its level.",
        "Loops of the motor's friction over its angle",
        (panel,),
    )


def _residuals(shown: Sequence[Shown]) -> Chart:
    panels = []
    for each in shown:
        part = _busiest(each)
        outputs = [k for k, name in enumerate(OUTPUTS) if not (each.locked and name == "steering_wheel_angle")]
        marks = tuple(Lines(_TITLES[OUTPUTS[k]][0], each.time[part], each.residuals[part, k]) for k in outputs)
        panels.append(Panel(each.name, "time (s)", "standard deviations", marks))
    return Chart(
        "residuals",
        "Innovations over time",
        "Measured less predicted values, over their standard deviation; any structure shows an error of the model.",
        "Standardised innovations of every experiment over time",
        tuple(panels),
    )


def _whiteness(result: ColumnIdentification) -> Table:
    rows = tuple(
        (name, f"{each.largest:+.3f}".replace("-", "−"), f"{100.0 * each.outside:.0f} %")
        for name, each in result.whiteness.items()
    )
    return Table(
        "Autocorrelation of the innovations, lags 1 to 25",
        ("output", "largest", "lags beyond 95 %"),
        rows,
        "If the model is complete, the innovations are white: about 5 % of the lags then lie beyond the limit. With "
        "tens of thousands of samples even a correlation of 0.01 is significant, but it does not matter.",
    )


def _column(
    car: Vehicle, recordings: dict[str, Recording], free: tuple[str, ...], advance: Callable[[float], None]
) -> ColumnIdentification:

    deviations = {name: each.standard_deviation for name, each in car.parameters.items()}
    return identify_column(car.parameters_for(BenchParameters), recordings, free, deviations, advance)


def _column_document(result: ColumnIdentification) -> dict[str, Any]:
    estimate = result.estimate
    return {
        "bench": {
            name: {"value": estimate[name], "standard_deviation": estimate.deviation(name)}
            for name in estimate.names
            if name not in {each.name for each in result.found}
        },
        "unrecorded_motor_torque": estimate.input_deviation[0],
        "correlation": {"names": list(estimate.names), "matrix": estimate.correlation.tolist()},
        "leave_one_out": [
            {"left_out": each.name, "parameters": dict(each.values), "normalised_errors": dict(each.errors)}
            for each in result.left_out
        ],
        "whiteness": {name: each._asdict() for name, each in result.whiteness.items()},
        "explained": result.explained,
        "converged": estimate.converged,
    }


COLUMN = Subject(
    "Column",
    "Maximum-likelihood parameters of a model of the column. The side of the steering wheel "
    "comes from a regression with instruments; all else from the likelihood of the recordings, with a torque at "
    "the motor that was not recorded, whose standard deviation is found too.",
    _column,
    column_items,
    _column_document,
)
