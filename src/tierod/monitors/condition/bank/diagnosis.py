"""What the judge over the bank says of one sample."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.monitors.condition.bank.readings import Readings


class Elements(NamedTuple):
    """One number per sensor and actuator; mostly whether (1) or not (0)."""

    wheel_speed_rear_left: Annotated[float, ""]
    wheel_speed_rear_right: Annotated[float, ""]
    yaw_rate: Annotated[float, ""]
    steering_wheel_angle: Annotated[float, ""]
    steering_shaft_torque: Annotated[float, ""]
    tie_rod_force: Annotated[float, ""]
    steering_motor_1: Annotated[float, ""]
    steering_motor_2: Annotated[float, ""]
    drive_left: Annotated[float, ""]
    drive_right: Annotated[float, ""]


class Diagnosis(NamedTuple):
    """What is decided at one sample.

    Args:
        hypothesis: the number of the active hypothesis, 0 for healthy
        faulty: what is declared
        candidates: what might be at fault, where several hypotheses explain the samples about as well
        testable: whether a total loss would show now
        recovering: declared, but as it should be for the last samples
        gated: readings that are far off in this sample alone, or not declared yet
        value: of every sensor, its own where it is trusted, otherwise what the other sensors say
        prediction, deviation: of the reading of every sensor from all before and its standard deviation; of those at
            fault without their own readings
        torque_loss, loss_deviation: lost share of the torque of the actuators that are declared, the same of two
        speed, lateral_speed: of the centre of gravity
        best: the number of the hypothesis that explains the last samples best, the active one included
        lead: its mean log-likelihood ratio per sample less that of its best rival
        low_grip: whether tyres slide, so that nothing can be told
    """

    hypothesis: Annotated[float, ""]
    faulty: Elements
    candidates: Elements
    testable: Elements
    recovering: Elements
    gated: Readings
    value: Readings
    prediction: Readings
    deviation: Readings
    torque_loss: Annotated[float, ""]
    loss_deviation: Annotated[float, ""]
    speed: Annotated[float, "m/s"]
    lateral_speed: Annotated[float, "m/s"]
    best: Annotated[float, ""]
    lead: Annotated[float, ""]
    low_grip: Annotated[float, ""]
