"""Identification of a permanent-magnet motor from recordings of a drive."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.recording import Recording
from tierod.methods.identification.experiment import UNKNOWN, UNKNOWN_BEFORE, Found
from tierod.methods.identification.motor_electrical import (
    Electrical,
    MotorRecording,
    Value,
    identify_electrical,
    motor_recording,
)
from tierod.methods.identification.motor_mechanical import (
    Mechanical,
    identify_mechanical,
    in_time,
    refuse_slips,
    torque_ratio,
)
from tierod.models.stator_frame_motor import MotorParameters
from tierod.physics.motor import COPPER, NEODYMIUM, REFERENCE_TEMPERATURE, flux_at

# Unexplained share of the voltage above which the motor model is wrong [-]: a fault-free bench has below 0.03
UNEXPLAINED = 0.25


class Unidentified(NamedTuple):
    """A parameter that the recordings do not identify."""

    name: str
    why: str
    cure: str


@dataclass(frozen=True, eq=False)
class MotorIdentification:
    found: tuple[Found, ...]  # identified parameters, resistance and flux at 20 degrees Celsius
    unidentified: tuple[Unidentified, ...]  # parameters that the recordings do not identify
    electrical: Electrical  # parameters from currents and voltages, at the temperature of the motor
    # parameters from torque and angle; None if the shaft did not turn, or the flux is unknown
    mechanical: Mechanical | None
    torque_ratio: Value | None  # measured torque over that of flux and current; None if no torque was recorded
    remarks: tuple[str, ...]  # sentences on defects of recordings and fit

    @property
    def doubt(self) -> str:
        """Reason why the values should not be used; empty if they may be used."""
        if not self.found:
            return "these recordings identify no parameter of the motor"
        if self.electrical.unexplained > UNEXPLAINED:
            return (
                f"the model of a motor leaves {100.0 * self.electrical.unexplained:.0f} % of these voltages unexplained"
            )
        return ""


ROOM = 15.0  # Standard deviation of an unrecorded temperature about 20 degrees Celsius [K]
SENSOR = 1.0  # Standard deviation of a recorded temperature of the winding [K]
# Standard deviation of the magnets' temperature about that of the winding at the start of a recording [K]
MAGNETS = 5.0
_TURNED = 1.0  # Smallest total rotation of the shaft for an identification of its mechanics [rad]
_ZERO = 0.02  # Electrical angle of the sensor's zero above which there is a remark [rad]
_TORQUE = 0.03  # Relative difference of measured torque and that of flux and current above which there is a remark [-]
# RMS of the sum of the phase currents over that of a phase, above which there is a remark [-]; sensor noise: 0.1
_PHASE_SUM = 0.2
# Unexplained share of the voltage above which there is a remark [-]: fault-free recordings have 0.01 to 0.03
_CLEAN = 0.05
# Factor within which two ratios count as equal; factor of a winding's resistance from -40 to 120 degrees to that at 20
# degrees Celsius
_ALIKE, _WARMTH = 1.15, 1.5

# Test that excites each parameter
CURES = {
    "motor_resistance": "currents that change while the motor stands or turns slowly",
    "motor_inductance": "currents that change fast, or turning under a load that changes",
    "motor_saliency": "turning with a current along the flux that changes",
    "motor_flux": "turning at two speeds or more",
    "motor_inertia": "faster reversals",
    "motor_damping": "turning at several speeds, slow and fast, in both directions",
    "motor_friction": "turning to and fro over the same angles",
    "motor_friction_stiffness": "reversals of the direction, many of them slow",
}

Progress = Callable[[float], None]


class _Estimate(NamedTuple):
    name: str
    value: float
    deviation: float
    method: str


def identify_motor(
    parameters: MotorParameters,
    recordings: Mapping[str, Recording],
    free: Sequence[str] = (),
    before: Mapping[str, tuple[float, float | None]] | None = None,
    progress: Progress = lambda share: None,
) -> MotorIdentification:
    """Parameters of a permanent-magnet motor from recordings of a drive or a bench.

    Args: parameters: of the motor, as the scale on which a parameter counts as identified; the pole pairs are fixed;
    free: wanted parameters; by default all that the recordings identify.
    """
    for name in free:
        if name not in CURES:
            raise ParameterError(f"'{name}' cannot be identified{nearest(name, CURES)}")
    before = before or {}
    pole_pairs = parameters.motor_pole_pairs
    expected = (parameters.motor_resistance, parameters.motor_inductance, parameters.motor_flux)
    seen, moved = _in_time(recordings, pole_pairs, expected)
    progress(0.3)
    electrical = identify_electrical(seen, pole_pairs, expected)
    progress(0.6)
    mechanical = _mechanical(seen, electrical, pole_pairs)
    estimates = [*_electrical_values(electrical, seen), *(_mechanical_values(mechanical) if mechanical else ())]
    good = [each for each in estimates if _is_identified(each, electrical, parameters, before)]
    lacking = [name for name in _expected_names(estimates) if name not in {each.name for each in good}]
    unidentified = tuple(_unidentified(name, electrical, mechanical) for name in lacking)
    _require_wanted(unidentified, free)
    ratio = torque_ratio(seen, electrical, pole_pairs)
    progress(1.0)
    wanted = [each for each in good if not free or each.name in free]
    return MotorIdentification(
        tuple(Found.normal(each.name, before.get(each.name, UNKNOWN_BEFORE), *each[1:]) for each in wanted),
        unidentified,
        electrical,
        mechanical,
        ratio,
        (*moved, *_doubts(seen, electrical, parameters), *_remarks(seen, electrical, mechanical, ratio)),
    )


def _require_wanted(unidentified: Sequence[Unidentified], free: Sequence[str]) -> None:
    for each in unidentified:
        if each.name in free:
            raise InputError(
                f"not identifiable here: {each.name} ({each.why}); record {each.cure}, or leave it out of --free"
            )


def _in_time(
    recordings: Mapping[str, Recording], pole_pairs: float, expected: tuple[float, float, float]
) -> tuple[list[MotorRecording], list[str]]:
    seen = [motor_recording(name, each, pole_pairs) for name, each in recordings.items()]
    for each in seen:
        refuse_slips(each, pole_pairs, expected)
    timed = [in_time(each, pole_pairs, expected) for each in seen]
    return [each for each, _ in timed], [words for _, words in timed if words]


def _mechanical(seen: Sequence[MotorRecording], electrical: Electrical, pole_pairs: float) -> Mechanical | None:
    turned = sum(float(np.nansum(np.abs(np.diff(each.angle[:: max(round(0.04 / each.step), 1)])))) for each in seen)
    if turned < _TURNED or "motor_flux" in electrical.blind:
        return None
    return identify_mechanical(seen, electrical, pole_pairs)


def _electrical_values(electrical: Electrical, seen: Sequence[MotorRecording]) -> Iterator[_Estimate]:
    """Values at 20 degrees Celsius, with the uncertainty of the temperature in their standard deviations."""
    method = "currents and voltages"
    winding = SENSOR if electrical.warm else ROOM
    value, deviation = electrical.resistance
    yield _Estimate("motor_resistance", value, float(np.hypot(deviation, COPPER * winding * value)), method)
    yield _Estimate("motor_inductance", *electrical.inductance, method)
    if electrical.inductance_q is not None:
        along, across = electrical.inductance, electrical.inductance_q
        ratio = across.value / along.value
        spread = abs(ratio) * float(np.hypot(across.deviation / across.value, along.deviation / along.value))
        yield _Estimate("motor_saliency", ratio, spread, method)
    value, deviation = electrical.flux
    magnets, unsure = REFERENCE_TEMPERATURE, ROOM
    if electrical.warm:
        courses = [each.temperature for each in seen if each.temperature is not None]
        magnets = float(np.mean([each[0] for each in courses]))
        unsure = float(np.hypot(MAGNETS, max(np.ptp(each) for each in courses)))
    factor = 1.0 / float(flux_at(magnets, 1.0))
    spread = float(np.hypot(deviation, NEODYMIUM * unsure * value)) * factor
    yield _Estimate("motor_flux", value * factor, spread, method)


def _mechanical_values(mechanical: Mechanical) -> Iterator[_Estimate]:
    method = "torque and angle"
    yield _Estimate("motor_inertia", *mechanical.inertia, method)
    yield _Estimate("motor_damping", *mechanical.damping, method)
    yield _Estimate("motor_friction", *mechanical.friction, method)
    yield _Estimate("motor_friction_stiffness", *mechanical.stiffness, method)


def _is_identified(
    each: _Estimate,
    electrical: Electrical,
    parameters: MotorParameters,
    before: Mapping[str, tuple[float, float | None]],
) -> bool:
    if each.name in electrical.blind:
        return False
    size = abs(each.value)
    if each.name in before or hasattr(parameters, each.name):
        size = max(size, before.get(each.name, (getattr(parameters, each.name, None) or 0.0, None))[0])
    return bool(each.value > 0.0 and each.deviation < UNKNOWN * size)


def _expected_names(estimates: Sequence[_Estimate]) -> list[str]:
    """Names of all parameters; saliency, which most motors lack, only if it was found."""
    return [name for name in CURES if name != "motor_saliency" or name in {each.name for each in estimates}]


def _unidentified(name: str, electrical: Electrical, mechanical: Mechanical | None) -> Unidentified:
    if name in _LACKING and mechanical is None:
        return Unidentified(name, "the shaft did not turn, or the flux is not known", "the motor turning to and fro")
    why = _LACKING.get(name, "currents, or the speed, change too little")
    others = [each for each in electrical.blind if each != name]
    if name in electrical.blind and others and mechanical is None:
        why = f"it cannot be separated from {' and '.join(others)} at one speed and one current, or at rest"
    return Unidentified(name, why, CURES[name])


# Reasons why a parameter of the shaft is not identified
_LACKING = {
    "motor_inertia": "the shaft hardly accelerates, or a load acts like the inertia",
    "motor_damping": "the speeds are too similar, or there is hardly any damping",
    "motor_friction": "the shaft does not go to and fro over the same angles, so that a load may hide it",
    "motor_friction_stiffness": "there are too few reversals",
}


def _doubts(seen: Sequence[MotorRecording], electrical: Electrical, parameters: MotorParameters) -> Iterator[str]:
    for each in seen:
        if each.phase_sum > _PHASE_SUM:
            yield (
                f"{each.name}: the phase currents do not add up to zero: the sum has {100.0 * each.phase_sum:.0f} % of "
                "their root mean square; check the current sensors for an offset or a wrong gain"
            )
    if electrical.unexplained > _CLEAN:
        yield (
            f"{100.0 * electrical.unexplained:.0f} % of the voltage remains unexplained, in good recordings 1 to 3 %: "
            "a saturated or wrong measurement moves the values by more than their standard deviations"
        )
    if {"motor_resistance", "motor_inductance", "motor_flux"} & set(electrical.blind):
        return
    resistance = electrical.resistance.value / parameters.motor_resistance
    inductance = electrical.inductance.value / parameters.motor_inductance
    flux = electrical.flux.value / parameters.motor_flux
    stays = 1.0 / _WARMTH < resistance < _WARMTH and not 1.0 / _ALIKE < resistance / flux < _ALIKE
    if stays and 1.0 / _ALIKE < inductance / flux < _ALIKE and not 1.0 / _ALIKE < flux < _ALIKE:
        step = 1e3 * seen[0].step
        yield (
            f"inductance and flux are both {flux:.2g} times those of the vehicle file, the resistance is not: another "
            f"motor, or samples that come every {step / flux:.2g} ms, but by their time stamps every {step:.3g} ms"
        )


def _remarks(
    seen: Sequence[MotorRecording], electrical: Electrical, mechanical: Mechanical | None, ratio: Value | None
) -> Iterator[str]:
    if not electrical.warm:
        yield (
            "no motor_temperature was recorded: resistance and flux are those at the motor's unknown temperature, "
            f"assumed as 20 ± {ROOM:g} degrees, which causes nearly all of their standard deviation"
        )
    zero = electrical.zero
    if abs(zero.value) > max(_ZERO, 4.0 * zero.deviation):
        yield (
            f"the angle sensor's zero is {np.degrees(zero.value):+.1f} ± {np.degrees(zero.deviation):.1f} degrees "
            "electrical away from the flux; the values are corrected for it"
        )
    if not electrical.along and "motor_inductance" not in electrical.blind:
        yield (
            "hardly any current along the flux was driven: the inductance is that across the flux, and assumed to be "
            "the same along it"
        )
    if mechanical is not None and any(each.load is None for each in seen):
        yield (
            "no load_torque was recorded: a load that depends on the angle, as a spring, is separated, but one that "
            "depends on the direction or the speed of turning counts as friction or damping of the motor"
        )
    if ratio is not None and abs(ratio.value - 1.0) > max(_TORQUE, 3.0 * ratio.deviation):
        yield (
            f"the measured torque is {ratio.value:.3f} ± {ratio.deviation:.3f} times that of flux and current: 2/3 and "
            "3/2 come from vectors that are not amplitude-invariant, 0.82 and 1.22 where the currents alone are not, "
            "another factor from a torque at another shaft"
        )
