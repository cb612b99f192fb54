"""Errors of the recording by name: signs, phases and scales, from the voltage balance, and the inverter's knee."""

from __future__ import annotations

import math
from math import nan
from typing import NamedTuple

from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.voltage_balance import AS_RECORDED, AXES_SWAPPED, AxisBalance, Balance, VoltageBalance

LEAST_WINDOWS = 100
"""Least number of windows, half a second of driving."""

CLEAN = 0.1
"""Largest unexplained share of the voltage for a valid reading; fault-free recordings leave 0.01 to 0.05, and one that
changed during the drive, as with a fault, 0.2 and more."""

EXPLAINS = 0.8
"""Residual over that with the inductances of the vehicle file from which other ones explain a contradiction; a
saliency of 1.5 that the file lacks leaves 0.1 to 0.7, a fault of the sensor 0.94 and more."""

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
the inductance too small by 2 / 5^2 = 8 %, less than `ALIKE` allows. Those of each axis are freed from this error."""


def misread(collected: VoltageBalance, p: SampledMotorParameters, current_noise: float) -> tuple[str, str] | None:
    """Cause and action of an error of the whole recording; None where there is none, or no reading explains it.

    Args:
        collected: balance over the whole recording
        p: parameters of the motor, from the vehicle file
        current_noise: standard deviation [A]
    """
    balance = collected.best()
    if balance is None or balance.windows < LEAST_WINDOWS or balance.turn < LEAST_TURN:
        return None
    axes = balance.reading == AS_RECORDED and other_inductances(collected, p, current_noise)
    if axes:
        return axes
    if balance.unexplained > CLEAN:
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
    alone = abs(math.log(resistance)) < abs(math.log(resistance / inductance))
    if _near(flux, 1.0) and not _near(inductance, 1.0) and _near(resistance, inductance, WARMTH) and not alone:
        return (
            f"resistance and inductance are both {inductance:.2g} times those of the vehicle file, the flux is not: "
            f"the recorded currents are {1.0 / inductance:.2g} times the true ones",
            "correct factor and unit of the currents in the channel map; amplitude-invariant vectors are expected",
        )
    return None


class Departure(NamedTuple):
    """Parameters of a motor over those of the vehicle file; NaN where the recording does not determine them."""

    resistance: float
    flux: float
    along: float
    across: float

    @classmethod
    def of(cls, axes: AxisBalance, p: SampledMotorParameters, current_noise: float) -> Departure:
        """The departure of a balance from the parameters of the vehicle file; noise of the current in [A]."""
        pairs = ((axes.along, axes.change_along), (axes.across, axes.change_across))
        nominal = (p.motor_inductance, p.inductance_across)
        along, across = (
            # Noise at both ends of a window adds to the change, and is no change of the flux.
            value / of / (1.0 - 2.0 * (current_noise / change) ** 2) if change > LEAST_CHANGE * current_noise else nan
            for (value, change), of in zip(pairs, nominal, strict=True)
        )
        return cls(axes.resistance / p.motor_resistance, axes.flux / p.motor_flux, along, across)

    def in_words(self) -> str:
        """The parameters that differ from the vehicle file by more than temperature explains; "" without any."""
        limits = {"resistance": WARMTH, "flux": ALIKE, "along": ALIKE, "across": ALIKE}
        named = {"along": "inductance along the flux", "across": "inductance across the flux"}
        apart = [
            f"{value:.2f} times the {named.get(name, name)}"
            for name, value in self._asdict().items()
            if not math.isnan(value) and not _near(value, 1.0, limits[name])
        ]
        return " and ".join(apart) and f"{' and '.join(apart)} of the vehicle file{self._scaled()}"

    def _scaled(self) -> str:
        """The wrong scale of the currents that explains the departure, in words; "" without one."""
        if not _near(self.flux, 1.0) or _near(self.across, 1.0) or not _near(self.resistance, self.across, WARMTH):
            return ""
        return f", as with currents {1.0 / self.across:.1f} times the true ones"


def other_inductances(
    collected: VoltageBalance, p: SampledMotorParameters, current_noise: float
) -> tuple[str, str] | None:
    """Cause and action where only inductances differ from the vehicle file; None otherwise. Arguments as of `misread`.

    A wrong scale of the currents changes the resistance by the same factor, and is no other inductance.
    """
    shares = ((0.0, 1.0), (0.0, 0.5), (0.5, 1.0))
    found = [axes for share in shares if (axes := collected.axes(share)) is not None]
    if len(found) < len(shares) or found[0].unexplained > CLEAN or min(found[0].along, found[0].across) <= 0.0:
        return None
    assumed = collected.axes(known=(p.motor_inductance, p.inductance_across))
    if assumed is None or found[0].unexplained > EXPLAINS * assumed.unexplained:
        return None
    whole, *halves = (Departure.of(axes, p, current_noise) for axes in found)
    if not _near(whole.resistance, 1.0, WARMTH) or not _near(whole.flux, 1.0):
        return None
    wrong = {
        name: value
        for name, value in (("along", whole.along), ("across", whole.across))
        if not math.isnan(value) and not _near(value, 1.0) and not _near(value, whole.resistance)
    }
    both = [(getattr(half, name), value) for half in halves for name, value in wrong.items()]
    if not wrong or not all(math.isnan(one) or _near(one, all_) for one, all_ in both):
        return None
    return _other_inductance(wrong, whole, p)


def _other_inductance(wrong: dict[str, float], whole: Departure, p: SampledMotorParameters) -> tuple[str, str]:
    """Cause and action for wrong inductances over those of the vehicle file, by axis."""
    are = "inductances {} the flux are" if len(wrong) > 1 else "inductance {} the flux is"
    factors = " and ".join(f"{value:.2f}" for value in wrong.values())
    cause = (
        f"the {are.format(' and '.join(wrong))} {factors} times that of the vehicle file, resistance and flux are "
        "those of the file"
    )
    if p.motor_saliency is None:
        cause += ": it gives one inductance, but those along and across the flux may differ"
    if not math.isnan(whole.along) and not math.isnan(whole.across):
        along, across = whole.along * p.motor_inductance, whole.across * p.inductance_across
        return (
            cause,
            f"give motor_inductance = {along:.3g} H (along the flux) and motor_saliency = {across / along:.2f} (L_q "
            "over L_d) in the vehicle file",
        )
    if "across" in wrong and p.motor_saliency is None:
        ratio = wrong["across"]
        return (
            cause,
            f"with interior magnets give motor_saliency = {ratio:.2f} (L_q over L_d) beside the motor_inductance along "
            f"the flux; with surface magnets multiply motor_inductance by {ratio:.2f}",
        )
    return cause, "correct motor_inductance and motor_saliency in the vehicle file: 'tierod identify motor' finds both"


def _near(value: float, other: float, factor: float = ALIKE) -> bool:
    return other / factor < value < other * factor
