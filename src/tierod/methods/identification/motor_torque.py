"""Whether a measured torque is that which flux and currents make."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tierod.methods.identification.motor_electrical import Electrical, Value
from tierod.methods.identification.motor_recording import MotorRecording
from tierod.methods.identification.motor_regression import Rows, regress
from tierod.physics.pm_motor import torque_constant


def torque_ratio(seen: Sequence[MotorRecording], electrical: Electrical, pole_pairs: float) -> Value | None:
    """Measured torque of the motor over that of flux and current, at the instants of the former; None without either.

    Args:
        seen: recordings of one motor
        electrical: as its currents and voltages tell
        pole_pairs: electrical turns per turn of the shaft
    """
    if "motor_flux" in electrical.blind:
        return None
    rows = []
    for each in seen:
        if each.torque is None:
            continue
        time, measured = each.torque
        across = (each.current * np.exp(-1j * (pole_pairs * each.angle + electrical.zero.value))).imag
        told = np.interp(time, each.time, torque_constant(pole_pairs, electrical.flux.value) * across)
        known = np.isfinite(told + measured)
        columns = np.column_stack([told, np.ones_like(told)])[known]
        if np.ptp(columns[:, 0]) > 0.0:
            rows.append(Rows(measured[known], columns, columns))
    if not rows:
        return None
    fit = regress(rows)
    unsure = electrical.flux.deviation / electrical.flux.value
    return Value(float(fit.values[0]), float(np.hypot(fit.deviations[0], unsure * fit.values[0])))
