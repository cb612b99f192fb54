"""Identification of a motor and of its inverter: tables and charts of the results."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from tierod.core.content import Chart, Fold, Heading, Item, Lines, Panel, Table
from tierod.core.recording import Recording
from tierod.methods.identification.inverter import InverterIdentification, identified_inverter
from tierod.methods.identification.motor import MotorIdentification, identify_motor
from tierod.methods.identification.motor_mechanical import Course
from tierod.models.stator_frame_motor import MotorParameters
from tierod.report.display import number
from tierod.report.identification import Subject, before, found_table
from tierod.vehicles import Vehicle

_WINDOW = 5.0  # Length of the stretch of a recording that is drawn, the one with the most torque variation [s]

_BEYOND = (
    "Iron losses, saturation, and a load that depends on the direction or the speed of turning change them by more."
)


def as_warm(result: MotorIdentification) -> list[tuple[str, float, float]]:
    """Name, value and standard deviation of the electrical parameters at the temperature of the recording."""
    electrical = result.electrical
    found = [
        ("motor_resistance", electrical.resistance),
        ("motor_inductance", electrical.inductance),
        ("motor_flux", electrical.flux),
    ]
    if electrical.inductance_q is not None:
        found.insert(2, ("motor_inductance_across", electrical.inductance_q))
    kept = [(name, *each) for name, each in found if name not in electrical.blind]
    return [*kept, ("angle_zero_electrical", *electrical.zero)] if "motor_flux" not in electrical.blind else kept


def motor_items(result: MotorIdentification) -> Iterator[Item]:
    yield Heading("What was found")
    if result.found:
        yield found_table(result.found, _BEYOND)
    if result.unidentified:
        rows = tuple((each.name, each.why, each.cure) for each in result.unidentified)
        yield Table("Not identifiable here", ("parameter", "because", "record"), rows)
    yield Fold("As warm as the motor was", [_warm_table(result)], opened=True)
    if result.mechanical is not None:
        yield Heading("Torque")
        for place, course in enumerate(result.mechanical.courses):
            yield _chart(course, place)


def _warm_table(result: MotorIdentification) -> Table:
    rows = [(name, number(value, 6), number(deviation, 2)) for name, value, deviation in as_warm(result)]
    ratio = result.torque_ratio
    if ratio is not None:
        rows.append(
            ("measured torque over that of flux and current", number(ratio.value, 4), number(ratio.deviation, 2))
        )
    rows.append(("share of the voltage that is not explained", number(result.electrical.unexplained, 2), ""))
    if result.mechanical is not None:
        rows.append(("torque that is not explained (N·m)", number(result.mechanical.residual, 2), ""))
    note = (
        "In SI units, at the temperature of the recording; the resistance is that at 20 °C if the temperature of the "
        "winding was recorded."
    )
    return Table("", ("", "value", "σ"), tuple(rows), note)


def _chart(course: Course, place: int) -> Chart:
    width = min(int(_WINDOW / max(float(np.median(np.diff(course.time))), 1e-9)), len(course.time))
    moved = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(course.driving)))])
    start = int(np.argmax(moved[width - 1 :] - moved[: len(moved) - width + 1]))
    part = slice(start, start + width)
    marks = (
        Lines("of flux and current", course.time[part], course.driving[part]),
        Lines("of inertia, friction and load", course.time[part], course.explained[part]),
    )
    return Chart(
        f"torque-{place}",
        course.name,
        "Torque of the motor, less a load that was measured, and the part that the identified parameters explain.",
        f"Torque of {course.name} over time",
        (Panel("torque", "time (s)", "torque (N·m)", marks),),
    )


def _motor(
    car: Vehicle, recordings: dict[str, Recording], free: tuple[str, ...], advance: Callable[[float], None]
) -> MotorIdentification:
    return identify_motor(car.parameters_for(MotorParameters), recordings, free, before(car), advance)


def _motor_document(result: MotorIdentification) -> dict[str, Any]:
    ratio = result.torque_ratio
    return {
        "as_warm_as_recorded": {
            name: {"value": value, "standard_deviation": deviation} for name, value, deviation in as_warm(result)
        },
        "torque_ratio": None if ratio is None else {"value": ratio.value, "standard_deviation": ratio.deviation},
        "unexplained_voltage": result.electrical.unexplained,
        "not_identifiable": [each._asdict() for each in result.unidentified],
        "explained": not result.doubt,
    }


def _inverter(
    car: Vehicle, recordings: dict[str, Recording], free: tuple[str, ...], advance: Callable[[float], None]
) -> InverterIdentification:
    known = before(car)
    names = ("motor_resistance", "motor_inductance", "motor_flux")
    expected = (car[names[0]], car[names[1]], car[names[2]]) if all(name in known for name in names) else None
    return identified_inverter(recordings, car["motor_pole_pairs"], free, known, expected)


def _inverter_items(result: InverterIdentification) -> Iterable[Item]:
    yield found_table(
        result.found, "A dead time or a voltage drop that changes with the temperature changes them by more."
    )


def _inverter_document(result: InverterIdentification) -> dict[str, Any]:
    return {"fit": result.fit._asdict(), "explained": not result.doubt}


MOTOR = Subject(
    "Motor",
    "Resistance, inductance and flux under which the voltages are those of a motor with these currents and this "
    "angle; inertia, damping and dry friction under which its torque moves the shaft as it was moved. Both are "
    "regressions over short windows; standard deviations hold with residuals that are coloured.",
    _motor,
    motor_items,
    _motor_document,
)

INVERTER = Subject(
    "Inverter",
    "Loss of a phase and knee of it under which the commands, less what the inverter takes, are the voltages of a "
    "motor with these currents and this angle.",
    _inverter,
    _inverter_items,
    _inverter_document,
)
