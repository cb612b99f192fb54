"""Which alarm stood when, as courses that a fault memory takes."""

from __future__ import annotations

import numpy as np

from tierod.core.findings import Status
from tierod.core.graph import Result
from tierod.monitors.harness.session import StatusChange
from tierod.monitors.motor_angle.detector import FAULT

KEPT = 0.25
"""An alarm counts for so long at least [s]: longer than a fault memory's sample of a recording."""

STATUSES = (Status.NOT_READY, Status.NOT_ENABLED, Status.HEALTHY, Status.FAULT)
"""Of the codes of the running verdict."""

CODES = {
    "motor-supply-low": ("electrical.supply_low",),
    "motor-angle-lost": ("electrical.angle_timeout",),
    "motor-angle-amplitude": ("electrical.resolver_amplitude",),
    "motor-angle-mismatch": ("electrical.resolver_mismatch",),
    "motor-currents": (
        "electrical.current_sum",
        "electrical.current_saturated",
        "electrical.voltage_saturated",
        "model",
    ),
    "motor-angle-stuck": ("stuck", "not_following"),
    "motor-angle-backwards": ("backwards",),
    "motor-angle-offset": ("angle", "speed", "electrical.angle_gradient"),
    "steering-angles-implausible": ("plausibility",),
}
"""Alarms behind every trouble code."""


class AlarmCourses:
    """Collects first instants of alarms and courses of trouble codes over the pieces of a recording.

    Args:
        rate: of the samples [Hz]
    """

    def __init__(self, rate: float):
        self._kept = round(KEPT * rate)
        self.starts: dict[str, float] = {}
        self.course: list[StatusChange] = []
        self.codes: dict[str, list[StatusChange]] = {name: [] for name in CODES}
        self._since = dict.fromkeys((*CODES, ""), self._kept + 1)

    def add(self, time: np.ndarray, result: Result) -> None:
        """The next piece."""
        for name in (alarm for alarms in CODES.values() for alarm in alarms):
            flags = result[f"alarms.{name}"] > 0.5
            if name not in self.starts and flags.any():
                self.starts[name] = float(time[np.argmax(flags)])
        verdict = result["verdict"]
        sound = np.minimum(verdict, FAULT - 1.0)
        self._follow(self.course, "", time, verdict > FAULT - 0.5, sound)
        for code, alarms in CODES.items():
            flags = np.any([result[f"alarms.{name}"] > 0.5 for name in alarms], axis=0)
            self._follow(self.codes[code], code, time, flags, sound)

    def of_code(self, name: str, mute: bool = False) -> tuple[StatusChange, ...]:
        """The course of one trouble code.

        Args:
            name: of the code
            mute: whether its alarms are consequences of another fault, and tell nothing
        """
        if not mute:
            return tuple(self.codes[name])
        untold = Status.NOT_ENABLED
        return tuple(each._replace(status=untold) if each.status is Status.FAULT else each for each in self.codes[name])

    def _follow(
        self, course: list[StatusChange], name: str, time: np.ndarray, flags: np.ndarray, sound: np.ndarray
    ) -> None:
        """Changes of one course; an alarm stays for `KEPT`."""
        place = np.arange(len(flags))
        last = np.maximum.accumulate(np.where(flags, place, -1 - self._since[name]))
        self._since[name] = min(int(place[-1] - last[-1]), self._kept + 1)
        code = np.where(place - last <= self._kept, FAULT, sound)
        for at in np.flatnonzero(np.diff(code, prepend=np.nan) != 0.0).tolist():
            status = STATUSES[round(code[at])]
            if not course or course[-1].status is not status:
                course.append(StatusChange(float(time[at]), status))
