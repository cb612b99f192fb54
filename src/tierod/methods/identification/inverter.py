"""Identification of an inverter's loss and knee from recordings of its commands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.core.recording import Recording
from tierod.methods.identification.column_result import Found
from tierod.methods.identification.experiment import INTERVAL
from tierod.methods.identification.inverter_knee import InverterFit, identify_inverter
from tierod.methods.identification.motor_recording import motor_recording
from tierod.methods.identification.motor_slips import refuse_slips

NAMES = ("inverter_voltage_loss", "inverter_knee_current")
"""Parameters of a vehicle file."""

SEEN = 4.0
"""Standard deviations from which a loss is told from none."""
WORTH = 0.95
"""Share of what is left without a loss, above which none is seen: a knee above all currents is a resistance."""
VAGUE = 0.3
"""Standard deviation of the knee's logarithm from which it is not told."""
UNEXPLAINED = 0.1
"""Share of the command that a motor and such an inverter may leave: a sound bench leaves 0.01 to 0.02."""


@dataclass(frozen=True)
class InverterIdentification:
    """What was found of an inverter.

    Args:
        found: its parameters
        fit: the whole fit
        remarks: what was noticed
    """

    found: tuple[Found, ...]
    fit: InverterFit
    remarks: tuple[str, ...]

    @property
    def doubt(self) -> str:
        """Why the values may not be used; empty where they may."""
        fit = self.fit
        if fit.loss < SEEN * fit.loss_deviation or fit.unexplained > WORTH * fit.without:
            return "the commands show no loss of an inverter; they may be measured voltages"
        if fit.unexplained > UNEXPLAINED:
            return f"motor and inverter leave {100.0 * fit.unexplained:.0f} % of the commands unexplained"
        if fit.knee_deviation > VAGUE:
            return "the currents do not tell the knee; record small currents of all phases while the motor turns"
        return ""


def identified_inverter(
    recordings: Mapping[str, Recording],
    pole_pairs: float,
    free: Sequence[str] = (),
    before: Mapping[str, tuple[float, float | None]] | None = None,
    expected: tuple[float, float, float] | None = None,
) -> InverterIdentification:
    """Loss and knee of an inverter from recordings of its commands.

    Args:
        recordings: by name, with currents, commanded voltages and the motor's angle
        pole_pairs: electrical turns per turn of the shaft
        free: those of `NAMES` that are wanted; both where none is named
        before: value and standard deviation in the vehicle file, by name
        expected: resistance [ohm], inductance [H] and flux [V s] of the motor, with which wrong signs, phases and pole
            pairs are named; not looked for where None

    Raises:
        ParameterError: a parameter that there is not
        InputError: recordings that cannot be used, or whose signals do not belong together
    """
    for name in free:
        if name not in NAMES:
            raise ParameterError(f"'{name}' is no parameter of an inverter{nearest(name, NAMES)}")
    seen = [motor_recording(name, each, pole_pairs, commanded=True) for name, each in recordings.items()]
    if expected is not None:
        for each in seen:
            refuse_slips(each, pole_pairs, expected)
    fit = identify_inverter(seen, pole_pairs)
    deviations = (fit.loss_deviation, fit.knee * fit.knee_deviation)
    spread = INTERVAL * fit.knee_deviation
    ends = (
        (fit.loss - INTERVAL * fit.loss_deviation, fit.loss + INTERVAL * fit.loss_deviation),
        (fit.knee * float(np.exp(-spread)), fit.knee * float(np.exp(spread))),
    )
    told = zip(NAMES, (fit.loss, fit.knee), deviations, ends, strict=True)
    found = tuple(
        Found(name, *(before or {}).get(name, (float("nan"), None)), value, deviation, *interval, "least squares")
        for name, value, deviation, interval in told
        if not free or name in free
    )
    remark = (
        f"with the loss {100.0 * fit.unexplained:.2g} % of the commands are left over, without it "
        f"{100.0 * fit.without:.2g} %"
    )
    return InverterIdentification(found, fit, (remark,))
