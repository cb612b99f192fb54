"""What can be identified from recordings, and how each of it is told."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

if TYPE_CHECKING:
    from tierod.core.content import Item, Table
    from tierod.core.recording import Recording
    from tierod.methods.identification.column_result import ColumnIdentification, Found
    from tierod.methods.identification.inverter import InverterIdentification
    from tierod.methods.identification.motor_result import MotorIdentification
    from tierod.monitors.condition.calibration.whole import ConditionCalibration
    from tierod.vehicles import Vehicle


class Identified(Protocol):
    """Whatever an identification finds."""

    @property
    def found(self) -> tuple[Found, ...]:
        """Parameters, in the order of the vehicle file."""

    @property
    def remarks(self) -> tuple[str, ...]:
        """What was noticed."""

    @property
    def doubt(self) -> str:
        """Why the values may not be used; empty where they may."""


class Subject(NamedTuple):
    """Something that can be identified.

    Args:
        title: one word
        summary: of the page, how it is done
        identify: from vehicle, recordings, free names, and progress
        items: tables and charts of the page
        tables: for the terminal
        lines: for the terminal, below them
        document: what the JSON document holds besides the parameters
        takes_false_alarms: whether `identify` takes the wanted hours between false alarms too
        signals: that it looks at, so that hours of all others need not be read; None for all
    """

    title: str
    summary: str
    identify: Callable[..., Any]
    items: Callable[[Any], Iterable[Item]]
    tables: Callable[[Any], Sequence[Table]]
    lines: Callable[[Any], Sequence[str]]
    document: Callable[[Any], dict[str, Any]]
    takes_false_alarms: bool = False
    signals: Callable[[], tuple[str, ...] | None] = lambda: None


def _column(
    car: Vehicle, recordings: dict[str, Recording], free: tuple[str, ...], advance: Any
) -> ColumnIdentification:
    from tierod.methods.identification.column import identify_column
    from tierod.methods.identification.sampled_column import BenchParameters

    deviations = {name: each.standard_deviation for name, each in car.parameters.items()}
    return identify_column(car.parameters_for(BenchParameters), recordings, free, deviations, advance)


def _column_items(result: ColumnIdentification) -> Iterable[Item]:
    from tierod.report.identification_page import column_items

    return column_items(result)


def _column_tables(result: ColumnIdentification) -> Sequence[Table]:
    from tierod.report.identification_page import found_table, left_out_table

    return [found_table(result.found), *([left_out_table(result, short=True)] if result.left_out else [])]


def _column_lines(result: ColumnIdentification) -> Sequence[str]:
    return [f"Experiment {number}: {each.name}" for number, each in enumerate(result.left_out, 1)]


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


def _motor(car: Vehicle, recordings: dict[str, Recording], free: tuple[str, ...], advance: Any) -> MotorIdentification:
    from tierod.methods.identification.motor import identify_motor
    from tierod.models.stator_frame_motor import MotorParameters

    before = {name: (each.value, each.standard_deviation) for name, each in car.parameters.items()}
    return identify_motor(car.parameters_for(MotorParameters), recordings, free, before, advance)


def _motor_items(result: MotorIdentification) -> Iterable[Item]:
    from tierod.report.motor_page import motor_items

    return motor_items(result)


def _motor_tables(result: MotorIdentification) -> Sequence[Table]:
    from tierod.report.identification_page import found_table

    return [found_table(result.found)] if result.found else []


def _motor_lines(result: MotorIdentification) -> Sequence[str]:
    return [f"Not identifiable here: {each.name}: {each.why}; record {each.cure}" for each in result.untold]


def _motor_document(result: MotorIdentification) -> dict[str, Any]:
    from tierod.report.motor_page import as_warm

    ratio = result.torque_ratio
    return {
        "as_warm_as_recorded": {
            name: {"value": value, "standard_deviation": deviation} for name, value, deviation in as_warm(result)
        },
        "torque_ratio": None if ratio is None else {"value": ratio.value, "standard_deviation": ratio.deviation},
        "unexplained_voltage": result.electrical.unexplained,
        "not_identifiable": [each._asdict() for each in result.untold],
        "explained": not result.doubt,
    }


def _inverter(
    car: Vehicle, recordings: dict[str, Recording], free: tuple[str, ...], advance: Any
) -> InverterIdentification:
    from tierod.methods.identification.inverter import identified_inverter

    before = {name: (each.value, each.standard_deviation) for name, each in car.parameters.items()}
    names = ("motor_resistance", "motor_inductance", "motor_flux")
    expected = (car[names[0]], car[names[1]], car[names[2]]) if all(name in before for name in names) else None
    return identified_inverter(recordings, car["motor_pole_pairs"], free, before, expected)


def _inverter_tables(result: InverterIdentification) -> Sequence[Table]:
    from tierod.report.identification_page import found_table

    return [found_table(result.found)]


def _inverter_items(result: InverterIdentification) -> Iterable[Item]:
    from tierod.report.identification_page import found_table

    yield found_table(result.found, "A dead time or a drop that changes with the temperature moves them by more.")


def _inverter_document(result: InverterIdentification) -> dict[str, Any]:
    return {"fit": result.fit._asdict(), "explained": not result.doubt}


def _thresholds(
    car: Vehicle, recordings: dict[str, Recording], free: tuple[str, ...], advance: Any, hours: float = 1000.0
) -> ConditionCalibration:
    from tierod.core.errors import ParameterError
    from tierod.monitors.condition.calibration.whole import calibrate_condition

    if free:
        raise ParameterError("thresholds are found with all parameters that healthy driving tells; leave --free out")
    return calibrate_condition(recordings, car, hours, advance)


def _thresholds_signals() -> tuple[str, ...]:
    from tierod.monitors.condition.signals import ConditionSample

    return ConditionSample._fields


def _thresholds_items(result: ConditionCalibration) -> Iterable[Item]:
    return _thresholds_tables(result)


def _thresholds_tables(result: ConditionCalibration) -> Sequence[Table]:
    from tierod.core.content import Table
    from tierod.monitors.condition.hypotheses import hypotheses
    from tierod.report.display import number
    from tierod.report.identification_page import found_table

    limits = result.designed.limits
    pairs = zip(hypotheses()[1:], limits.fast, limits.slow, strict=True)
    rows = tuple(
        (each.name.replace("_", " "), number(fast, 3), number(slow, 3))
        for each, fast, slow in pairs
        if len(each.suspects) == 1
    )
    note = "Mean log-likelihood ratio per sample, over 0.05 and 0.5 s, beyond which a fault is declared."
    return [found_table(result.found), Table("Limits", ("suspect", "over 0.05 s", "over 0.5 s"), rows, note)]


def _thresholds_document(result: ConditionCalibration) -> dict[str, Any]:
    return {
        "thresholds": result.thresholds,
        "converged": result.calibration.found.converged,
        "explained": not result.doubt,
    }


SUBJECTS = {
    "column": Subject(
        "Column",
        "Parameters under which a model of the column foretells the recordings best. The side of the steering wheel "
        "comes from a regression with instruments; all else from the likelihood of the recordings, with a torque at "
        "the motor that nobody recorded, whose size is found too.",
        _column,
        _column_items,
        _column_tables,
        _column_lines,
        _column_document,
    ),
    "motor": Subject(
        "Motor",
        "Resistance, inductance and flux under which the voltages are those of a motor with these currents and this "
        "angle; inertia, damping and dry friction under which its torque moves the shaft as it was moved. Both are "
        "regressions over short windows; standard deviations hold with residuals that are coloured.",
        _motor,
        _motor_items,
        _motor_tables,
        _motor_lines,
        _motor_document,
    ),
    "inverter": Subject(
        "Inverter",
        "Loss of a phase and knee of it under which the commands, less what the inverter takes, are the voltages of a "
        "motor with these currents and this angle.",
        _inverter,
        _inverter_items,
        _inverter_tables,
        lambda result: [],
        _inverter_document,
    ),
    "thresholds": Subject(
        "Thresholds",
        "Parameters of an automated vehicle under which the filter of all its sensors foretells healthy driving best, "
        "from the first five minutes; limits of the condition monitor from all driving after them, for a wanted mean "
        "time between false alarms.",
        _thresholds,
        _thresholds_items,
        _thresholds_tables,
        lambda result: [],
        _thresholds_document,
        takes_false_alarms=True,
        signals=_thresholds_signals,
    ),
}
"""By the name that the command line takes."""
