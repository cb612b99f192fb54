"""What is collected over a drive of the driver's hands and of the column."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.monitors.driver_torque.contradicting import Contradiction
from tierod.monitors.driver_torque.geometry import ColumnGeometry
from tierod.monitors.driver_torque.stretches import Stretch


class Drive(NamedTuple):
    """What was collected over a drive.

    Args:
        ready, off, on, uncertain: time for which the torque was known, and of these of each state
        hand_rms, hand_deviation: of the hands' torque, and what the observer says of its own error
        peak, peak_deviation: greatest torque of the hands
        error: of the torque against the truth of a simulation; NaN where there is none
        torque_span, angle_span: least to greatest of bar and wheel
        nis: mean per measurement; NaN where the observer gives none
        sample_time: between two samples
        inertia_error, torque_offset: as learnt without hands
        geometry: what angles and torque say of the column
        motor_inertia: with the gear's at the motor's shaft, as torques and acceleration show it; None where they do not
        turned: a sentence for every signal whose sign is wrong
        stretches: without hands
        contradiction: what of the bar's three signals contradicts the others; None where they do not say
        motor: signal that the motor's torque was taken from; empty where there was none
    """

    ready: Annotated[float, "s"]
    off: Annotated[float, "s"]
    on: Annotated[float, "s"]
    uncertain: Annotated[float, "s"]
    hand_rms: Annotated[float, "N*m"]
    hand_deviation: Annotated[float, "N*m"]
    peak: Annotated[float, "N*m"]
    peak_deviation: Annotated[float, "N*m"]
    error: Annotated[float, "N*m"]
    torque_span: Annotated[float, "N*m"]
    angle_span: Annotated[float, "rad"]
    nis: Annotated[float, ""]
    sample_time: Annotated[float, "s"]
    inertia_error: Annotated[float, "kg*m**2"]
    torque_offset: Annotated[float, "N*m"]
    geometry: ColumnGeometry | None
    motor_inertia: Annotated[float | None, "kg*m**2"]
    turned: tuple[str, ...]
    stretches: tuple[Stretch, ...]
    contradiction: Contradiction | None = None
    motor: str = ""
