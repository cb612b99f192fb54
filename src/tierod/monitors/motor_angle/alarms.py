"""Alarms of the motor angle monitor: the meaning of each, and the courses of their trouble codes over a drive."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.core.findings import Status
from tierod.core.graph import Result
from tierod.core.statement import STATUSES, code_of
from tierod.monitors.harness.session import StatusChange

KEPT = 0.25
"""Least duration for which an alarm counts [s]; longer than the sampling interval of a fault memory."""


class Alarm(NamedTuple):
    """An alarm with its meaning.

    Args:
        name: name of its output
        decision: decision that raises it
        code: its trouble code
        cause: its meaning
        action: the remedy
    """

    name: str
    decision: str
    code: str
    cause: str
    action: str


ALARMS = (
    Alarm(
        "electrical.supply_low",
        "supply low",
        "motor-supply-low",
        "the supply of the controller is too low",
        "check battery, wiring and generator",
    ),
    Alarm(
        "electrical.angle_timeout",
        "angle lost",
        "motor-angle-lost",
        "no readings of the motor's angle arrive",
        "check the sensor and its line",
    ),
    Alarm(
        "electrical.resolver_amplitude",
        "resolver amplitude",
        "motor-angle-amplitude",
        "the amplitude of the angle sensor's sine and cosine has changed",
        "check sensor, magnet and wiring: one of the two has lost amplitude or gained an offset",
    ),
    Alarm(
        "electrical.current_sum",
        "current sum",
        "motor-currents",
        "the phase currents do not add up to zero",
        "check the current sensors for an offset or a wrong gain, and the phases for a leak to ground",
    ),
    Alarm(
        "electrical.current_saturated",
        "current saturated",
        "motor-currents",
        "a current stays constant at its peak while the motor turns: its measurement is saturated",
        "widen the range of the current measurement",
    ),
    Alarm(
        "electrical.voltage_saturated",
        "voltage saturated",
        "motor-currents",
        "a voltage stays constant at its peak while the motor turns: its measurement is saturated",
        "widen the range of the voltage measurement",
    ),
    Alarm(
        "model",
        "model",
        "motor-currents",
        "currents and voltages contradict the model of the motor",
        "check sign and order of the phases of currents and voltages, the sampling time, and the motor's parameters",
    ),
    Alarm(
        "stuck",
        "stuck",
        "motor-angle-stuck",
        "the motor turns, but its angle sensor stands still",
        "replace the sensor",
    ),
    Alarm(
        "backwards",
        "backwards",
        "motor-angle-backwards",
        "the angle sensor turns in the direction opposite to the motor: sine and cosine, or two phases, are swapped",
        "check wiring and channel map",
    ),
    Alarm(
        "electrical.resolver_mismatch",
        "resolver mismatch",
        "motor-angle-mismatch",
        "the motor's angle differs from the angle of its sensor's sine and cosine",
        "check the zero of the angle, its calibration, and the software between sensor and control",
    ),
    Alarm(
        "angle",
        "angle",
        "motor-angle-offset",
        "the angle sensor differs from the angle that currents and voltages give",
        "check the sensor's magnet and its zero",
    ),
    Alarm(
        "speed",
        "speed",
        "motor-angle-offset",
        "the angle sensor turns at another speed than currents and voltages give",
        "check the sensor: its gain, and whether it has lost readings",
    ),
    Alarm(
        "electrical.angle_gradient",
        "angle leaps",
        "motor-angle-offset",
        "the motor's angle jumps further than the motor can turn between two readings",
        "check sensor and line",
    ),
    Alarm(
        "not_following",
        "not following",
        "motor-angle-stuck",
        "the motor's angle stays away from its target: the sensor is stuck, its zero far off or a phase wrong, the "
        "motor itself stands still, or target_motor_angle_mechanical is not the one that it follows",
        "check whether the motor turns; if it does, check the sensor, its zero, sine and cosine, and the target in the "
        "channel map with its time stamps",
    ),
    Alarm(
        "plausibility",
        "plausibility",
        "steering-angles-implausible",
        "the angles of motor, steering wheel and pinion do not fit each other",
        "check the sensors of these angles, and the gear's ratios in the vehicle file",
    ),
)
"""Alarms from root cause to consequence; the kind of a statement is the position here, counted from 1."""

BY_NAME = {each.name: each for each in ALARMS}

CODES = {code: [each.name for each in ALARMS if each.code == code] for code in {each.code: None for each in ALARMS}}
"""Alarms behind each trouble code."""


class Spell(NamedTuple):
    """Activity of an alarm over a drive: number of samples, and time of the last one [s]."""

    samples: int
    last: float


class AlarmCourses:
    """Collector of first times and activity of alarms, and of the courses of trouble codes, over all pieces.

    Args:
        rate: sampling rate [Hz]
    """

    def __init__(self, rate: float):
        self._kept = round(KEPT * rate)
        self.starts: dict[str, float] = {}
        self.spells: dict[str, Spell] = {}
        self.course: list[StatusChange] = []
        self.codes: dict[str, list[StatusChange]] = {name: [] for name in CODES}
        self._since = dict.fromkeys((*CODES, ""), self._kept + 1)

    def add(self, time: np.ndarray, result: Result) -> None:
        """Add the next piece."""
        stated = result["statement.status"]
        fault = stated == code_of(Status.FAULT)
        # While another code is in fault, a code without an alarm counts as fault-free.
        otherwise = np.where(fault, code_of(Status.HEALTHY), stated)
        self._follow(self.course, "", time, fault, otherwise)
        for code, names in CODES.items():
            flags = [result[f"alarms.{name}"] > 0.5 for name in names]
            for name, each in zip(names, flags, strict=True):
                if not each.any():
                    continue
                self.starts.setdefault(name, float(time[np.argmax(each)]))
                last = float(time[len(each) - 1 - int(np.argmax(each[::-1]))])
                before = self.spells.get(name, Spell(0, last))
                self.spells[name] = Spell(before.samples + int(np.count_nonzero(each)), last)
            self._follow(self.codes[code], code, time, np.any(flags, axis=0), otherwise)

    def of_code(self, name: str, mute: bool = False) -> tuple[StatusChange, ...]:
        """The course of one trouble code.

        Args:
            name: name of the code
            mute: whether its alarms are consequences of another fault and carry no information
        """
        if not mute:
            return tuple(self.codes[name])
        not_judged = Status.NOT_ENABLED
        course = self.codes[name]
        return tuple(each._replace(status=not_judged) if each.status is Status.FAULT else each for each in course)

    def _follow(
        self, course: list[StatusChange], name: str, time: np.ndarray, flags: np.ndarray, otherwise: np.ndarray
    ) -> None:
        """Append the changes of one course; an alarm is held for `KEPT`."""
        place = np.arange(len(flags))
        # The negative start carries the time since the last alarm over from the previous piece.
        last = np.maximum.accumulate(np.where(flags, place, -1 - self._since[name]))
        self._since[name] = min(int(place[-1] - last[-1]), self._kept + 1)
        code = np.where(place - last <= self._kept, code_of(Status.FAULT), otherwise)
        for at in np.flatnonzero(np.diff(code, prepend=np.nan) != 0.0).tolist():
            status = STATUSES[round(code[at])]
            if not course or course[-1].status is not status:
                course.append(StatusChange(float(time[at]), status))
