"""The page of an identified motor: what was found, what was not told, and its torque over time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tierod.core.content import Chart, Heading, Item, Lines, Panel, Table
from tierod.methods.identification.motor import MotorIdentification
from tierod.methods.identification.motor_mechanical import Course
from tierod.report.display import number
from tierod.report.identification_page import found_table

_WINDOW = 5.0
"""Part of a recording that is drawn [s], the one in which the torque changes most."""

_BEYOND = "Iron losses, saturation, and a load that depends on the direction or the speed of turning move them by more."


def as_warm(result: MotorIdentification) -> list[tuple[str, float, float]]:
    """Name, value and standard deviation of what currents, voltages and angle tell, as warm as the motor was."""
    electrical = result.electrical
    told = [
        ("motor_resistance", electrical.resistance),
        ("motor_inductance", electrical.inductance),
        ("motor_flux", electrical.flux),
    ]
    if electrical.inductance_q is not None:
        told.insert(2, ("motor_inductance_across", electrical.inductance_q))
    kept = [(name, *each) for name, each in told if name not in electrical.blind]
    return [*kept, ("angle_zero_electrical", *electrical.zero)] if "motor_flux" not in electrical.blind else kept


def motor_items(result: MotorIdentification) -> Iterator[Item]:
    """Tables and charts of an identified motor."""
    yield Heading("What was found")
    if result.found:
        yield found_table(result.found, _BEYOND)
    if result.untold:
        rows = tuple((each.name, each.why, each.cure) for each in result.untold)
        yield Table("Not identifiable here", ("parameter", "because", "record"), rows)
    yield _warm_table(result)
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
    rows.append(("share of the voltage that is left over", number(result.electrical.unexplained, 2), ""))
    if result.mechanical is not None:
        rows.append(("torque that is left over (N·m)", number(result.mechanical.residual, 2), ""))
    note = (
        "In SI units, without what the temperature adds; the resistance is that at 20 degrees where the winding's "
        "temperature was recorded."
    )
    return Table("As warm as the motor was", ("", "value", "σ"), tuple(rows), note)


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
        "Torque of the motor, less a load that was measured, and what the parameters found explain of it.",
        f"Torque of {course.name} over time",
        (Panel("torque", "time (s)", "torque (N·m)", marks),),
    )
