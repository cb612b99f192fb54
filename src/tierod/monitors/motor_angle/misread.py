"""Errors of the recording by name: signs, phases and scales, found with the voltage balance."""

from __future__ import annotations

import math

from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.voltage_balance import AXES_SWAPPED, Balance, VoltageBalance

LEAST_WINDOWS = 100
"""Least number of windows, half a second of driving."""

CLEAN = 0.1
"""Largest unexplained share of the voltage for a valid reading; fault-free recordings leave 0.01 to 0.05, and one that
changed during the drive, as with a fault, 0.2 and more."""

WARMTH = 1.5
"""Factor of a resistance's change with temperature; a winding from -40 to 120 degrees has 0.76 to 1.4 of its resistance
at 20."""

ALIKE = 1.15
"""Factor within which two scales count as equal; magnets from -40 to 120 degrees and a data sheet's inductance stay
within it."""


LEAST_TURN = 0.05
"""Least electrical turn over a window for the flux, root mean square [rad]; 25 times the noise of a sensor."""

SAME_DIRECTION = 0.1
"""Largest difference between the flux directions of a half and of the whole, electrical [rad]; an inductance that is
wrong by half turns it by some 0.05, and a sensor whose angle leaps by more is itself faulty."""

LEAST_CHANGE = 5.0
"""Least change of the current over a window for the inductance, over the noise of the current; noise of both ends makes
the inductance too small by 2 / 5^2 = 8 %, less than `ALIKE` allows."""


def misread(collected: VoltageBalance, p: SampledMotorParameters, current_noise: float) -> tuple[str, str] | None:
    """Cause and action of an error of the whole recording; None where there is none, or no reading explains it.

    Args:
        collected: balance over the whole recording
        p: parameters of the motor, from the vehicle file
        current_noise: standard deviation [A]
    """
    balance = collected.best()
    if balance is None or balance.windows < LEAST_WINDOWS:
        return None
    if balance.unexplained > CLEAN or balance.turn < LEAST_TURN:
        return None
    if not all(_agrees(half, balance) for half in collected.halves(balance.reading)):
        return None
    return cause_of(balance, p, current_noise)


def _agrees(half: Balance | None, whole: Balance) -> bool:
    """Whether a half agrees with the whole; a change during the drive is a fault, not an error of the recording."""
    if half is None or abs(math.remainder(half.flux_direction - whole.flux_direction, math.tau)) > SAME_DIRECTION:
        return False
    return all(_near(getattr(half, name) / getattr(whole, name), 1.0) for name in ("resistance", "inductance", "flux"))


def cause_of(balance: Balance, p: SampledMotorParameters, current_noise: float) -> tuple[str, str] | None:
    """Cause and action from a balance; None where it is that of the motor in the vehicle file.

    Args:
        balance: balance over the whole recording
        p: parameters of the motor
        current_noise: standard deviation [A]
    """
    named = _phases(balance) or _sign(balance)
    return named if named or balance.change < LEAST_CHANGE * current_noise else _scale(balance, p)


def _phases(balance: Balance) -> tuple[str, str] | None:
    mirrored, shifted, backwards = balance.reading
    if not mirrored and not shifted:
        return None
    turned = abs(balance.flux_direction) > 0.25 * math.pi
    whose = "voltages" if (backwards if mirrored else turned) else "currents"
    if mirrored:
        if shifted == AXES_SWAPPED:
            return f"the {whose} are swapped: alpha and beta", "exchange alpha and beta in the channel map"
        two = "b and c" if not shifted else "a and b" if shifted > 0.0 else "a and c"
        if whose == "voltages":
            two = "two of them"
        return f"the phases of the {whose} are swapped: {two}", f"exchange {two} in the channel map"
    return (
        f"the phases of the {whose} are in the wrong order: shifted by one",
        f"name the phases of the {whose} in the order of the motor's phases",
    )


def _sign(balance: Balance) -> tuple[str, str] | None:
    if not (balance.resistance < 0.0 and balance.inductance < 0.0):
        return None
    whose = "voltages" if abs(balance.flux_direction) > 0.5 * math.pi else "currents"
    return (
        f"the {whose} have the wrong sign: they fit a resistance of {balance.resistance:.3g} ohm",
        f"give the {whose} a factor of -1 in the channel map",
    )


def _scale(balance: Balance, p: SampledMotorParameters) -> tuple[str, str] | None:
    if min(balance.resistance, balance.inductance, balance.flux) <= 0.0:
        return None
    resistance = balance.resistance / p.motor_resistance
    inductance = balance.inductance / (0.5 * (p.motor_inductance + p.inductance_across))
    flux = balance.flux / p.motor_flux
    if not _near(flux, 1.0) and _near(inductance, flux):
        if _near(resistance, 1.0, WARMTH) and not _near(resistance, flux, ALIKE):
            true = p.sample_time / flux
            return (
                f"inductance and flux are both {flux:.2g} times those of the vehicle file, the resistance is not: the "
                f"samples come every {1e3 * true:.2g} ms, but by their time stamps every {1e3 * p.sample_time:.3g} ms",
                "correct the time of the recording: its unit or its sampling interval",
            )
        if _near(resistance, flux, WARMTH):
            return (
                f"resistance, inductance and flux are all {flux:.2g} times those of the vehicle file: so are the "
                "recorded voltages",
                "correct factor and unit of the voltages in the channel map",
            )
    # A wrong scale of the currents changes resistance and inductance by the same factor.
    alone = _near(resistance, 1.0, WARMTH) and abs(math.log(resistance)) < abs(math.log(resistance / inductance))
    if p.motor_saliency is None and alone and _near(flux, 1.0) and not _near(inductance, 1.0):
        return _other_inductance(inductance)
    if _near(flux, 1.0) and not _near(inductance, 1.0) and _near(resistance, inductance, WARMTH):
        return (
            f"resistance and inductance are both {inductance:.2g} times those of the vehicle file, the flux is not: "
            f"the recorded currents are {1.0 / inductance:.2g} times the true ones",
            "correct factor and unit of the currents in the channel map; amplitude-invariant vectors are expected",
        )
    return None


def _other_inductance(ratio: float) -> tuple[str, str]:
    """Cause and action where only the inductance differs; currents across the flux show only the one across it."""
    return (
        f"the inductance is {ratio:.2f} times that of the vehicle file, resistance and flux are those of the file: it "
        "gives one inductance, but those along and across the flux may differ",
        f"with interior magnets give motor_saliency = {ratio:.2f} (L_q over L_d) beside the motor_inductance along the "
        f"flux; with surface magnets multiply motor_inductance by {ratio:.2f}",
    )


def _near(value: float, other: float, factor: float = ALIKE) -> bool:
    return other / factor < value < other * factor
