"""Recordings of a real drive: plausibility of the observed motor angle, its parameters and its friction."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.claims import Claim, at_least, at_most, between
from tierod.core.content import Heading, Item, Table
from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.io.readers import read
from tierod.methods.identification.modulation import Modulation
from tierod.methods.identification.motor import identify_motor
from tierod.methods.identification.regression import Fit, Rows, regress
from tierod.models.stator_frame_motor import MotorParameters, SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver, MotorAngleTuning
from tierod_lab.papers.motor_angle.feedforward import FeedforwardAngle
from tierod_lab.papers.motor_angle.flux_observer import FluxObserver
from tierod_lab.papers.real_data import NO_DATA, path_of
from tierod_lab.studies.effort import Effort

_STANDS = 0.05
"""Speed scale of the smoothed sign in the dry friction [1/s]."""


def column(recording: Recording, name: str) -> np.ndarray:
    """Values of a channel by the last part of its name."""
    return recording[next(each for each in recording.names if each.rpartition(".")[2] == name)].values


def friction(speed: Recording, position: Recording) -> Iterator[Item]:
    """Items on friction and inertia in amperes, from the q-axis current over speed and position."""
    fit, step = motion(position)
    there, needed = float(np.mean(column(speed, "UserSpeed"))), float(np.mean(column(speed, "motor_current_q")))
    predicted = fit.values[1] * there + fit.values[2]
    names = ("acceleration (A per 1/s²)", "speed (A per 1/s)", "dry friction (A)", "constant (A)")
    rows = tuple((n, f"{v:.3g}", f"{d:.2g}") for n, v, d in zip(names, fit.values, fit.deviations, strict=True))
    yield Heading(
        "Friction in amperes",
        (
            f"One file holds current and position of a motion to and fro, every {1e3 * step:.3g} ms. "
            "The unit of its position is the recorder's, and no torque constant is known: inertia and friction come in "
            "amperes.",
        ),
    )
    yield Table("Current across the flux explained by the motion", ("by", "value", "σ"), rows)
    yield Claim(
        "real.friction",
        "Current that this friction needs at the speed of the other file, over what was recorded there.",
        "another recording of the same drive",
        None,
        float(predicted / needed),
        between(0.9, 1.1),
    )


def motion(recording: Recording) -> tuple[Fit, float]:
    """Regression of the q-axis current on acceleration, speed and direction of motion; and sampling interval [s]."""
    name = next(each for each in recording.names if each.rpartition(".")[2] == "PosFeedBack")
    step = float(np.median(np.diff(recording[name].time)))
    window, place = Modulation(16, 2, step), recording[name].values
    direction = np.tanh(column(recording, "UserSpeed") / _STANDS)
    columns = [window.acceleration(place), window.rate(place), window.mean(direction)]
    regressors = np.column_stack([*columns, np.ones_like(columns[0])])
    return regress([Rows(window.mean(column(recording, "motor_current_q")), regressors, regressors)]), step


FOLDER = "pmsm_drive"
"""Folder of the recordings below that of all real recordings."""
DRAGGED, TURNING, BESIDE = "SigRecSaveE.mat", "SigRecSave_20250918_da89e76.mat", "SigRecSave1.mat"
SPEED, POSITION = "RecordSpeedRslt.mat", "RecordPosRslt.mat"
"""Files: rotor dragged by a current vector, turning without current signals, estimate with an encoder; then motions at
constant speed and in both directions, with current."""
ASSUMED = MotorParameters(0.2, 5e-4, 0.132, 1.0, 1e-3, 1e-3)
"""Assumed parameters of the drive, from its maker's program where it states them.

One pole pair makes all angles electrical ones. Inertia and damping are placeholders without effect at constant speed.
"""

_FINE = 2e-4
"""Sampling interval of the interpolated recording for the observers [s]; its own is too long for their integration."""
_SETTLED = 1.0 / 3.0
"""Share of the recording that is warm-up of the observers."""
_EARLIER = "earlier trial"


def recorded(name: str) -> Recording | None:
    """A recording of the drive; None where it is not available."""
    path = path_of(FOLDER, name)
    return read(path) if path.exists() else None


def items(effort: Effort) -> Iterator[Item]:
    del effort
    yield Heading(
        "A real drive",
        (
            "Recordings of a small drive by its own recorder. None holds currents, voltages and an independent angle "
            "together, so none shows how right an angle is; each shows one thing.",
        ),
    )
    for name, part in ((DRAGGED, dragged), (TURNING, turning), (BESIDE, beside)):
        found = recorded(name)
        yield from part(found) if found is not None else _absent(part.__name__)
    speed, position = recorded(SPEED), recorded(POSITION)
    yield from (friction(speed, position) if speed is not None and position is not None else _absent("friction"))


class Agreement(NamedTuple):
    """Electrical angle less the drive's own estimate: mean and standard deviation [rad]."""

    mean: float
    deviation: float


def agreement(angle: np.ndarray, other: np.ndarray) -> Agreement:
    """Agreement of two angles modulo whole turns."""
    away = np.exp(1j * (angle - other))
    mean = float(np.angle(away.mean()))
    return Agreement(mean, float(np.std(np.angle(away * np.exp(-1j * mean)))))


def with_sign(recording: Recording, sign: float) -> Recording:
    """The recording `DRAGGED` with its currents times a sign, and the drive's own estimate as angle."""
    current = recording["motor_current_alpha"]
    angle = Channel("motor_angle_electrical", current.time, 2.0 * np.pi * column(recording, "SlessThetaHat"), "rad")
    turned = [replace(recording[name], values=sign * recording[name].values) for name in _CURRENTS]
    return recording.with_channels([*turned, angle])


def refused(recording: Recording) -> str:
    """Error message of the identification on a recording; empty where it accepts the recording."""
    try:
        identify_motor(ASSUMED, {"drive": recording})
    except InputError as error:
        return str(error)
    return ""


def dragged(recording: Recording) -> Iterator[Item]:
    """Items on `DRAGGED`: currents, voltages and the drive's estimate, as a current vector drags the rotor at 6 Hz."""
    said = refused(with_sign(recording, 1.0))
    right = identify_motor(ASSUMED, {"drive": with_sign(recording, -1.0)})
    rows = []
    agreed: dict[tuple[str, float], Agreement] = {}
    for sign in (-1.0, 1.0):
        samples, own = _samples(recording, sign)
        for name, observer in _observers().items():
            angle = scan(observer, samples)["motor_angle"]
            settled = slice(int(_SETTLED * len(own)), None)
            agreed[name, sign] = agreement(angle[settled], own[settled])
            counted = "turned round" if sign < 0.0 else "as recorded"
            rows.append((name, counted, *(f"{each:.2g}" for each in agreed[name, sign])))
    yield Heading(
        "A current that is counted the other way",
        (
            f'`tierod identify motor` says to {DRAGGED} as recorded: "{said}".',
            "With the currents turned round it identifies "
            f"{_listed([each.name for each in right.found]) or 'no parameter'}, and not "
            f"{_listed([each.name for each in right.unidentified])}: "
            "at one speed and one current they do not separate.",
        ),
    )
    yield Table(
        "Electrical angle less the drive's own estimate (rad), resistance of 0.2 ohm",
        ("observer", "currents", "mean", "standard deviation"),
        tuple(rows),
        "Not an error: the drive's estimate is no truth. A tenth of an ohm more turns the first two by 0.13 rad.",
    )
    yield Claim(
        "real.current-sign",
        "Whether the identification of a motor recognises the current that is counted out of the motor.",
        _EARLIER,
        None,
        float("sign = -1" in said),
        at_least(1.0),
    )
    flux = agreed["flux observer", -1.0]
    yield _claim(
        "mean", "Mean difference of the flux observer's angle from the drive's estimate.", abs(flux.mean), 0.065
    )
    yield _claim("deviation", "Its standard deviation.", flux.deviation, 0.05)


def turning(recording: Recording) -> Iterator[Item]:
    """Items on `TURNING`: the integral of the voltage against the drive's estimate at a constant speed."""
    flux, agreed = integrated(recording)
    yield Heading(
        "The integral of the voltage alone",
        (
            f"In {TURNING} there are no currents. The integral of the recorded voltage, with no resistance and its "
            f"mean taken out, has a length of {flux:.3g} V·s and is {agreed.mean:.2g} ± "
            f"{agreed.deviation:.2g} rad from the drive's angle, which the recorder writes with the other sign.",
        ),
    )
    yield _claim(
        "integral",
        "Standard deviation of the direction of the voltage's integral from the drive's estimate.",
        agreed.deviation,
        0.03,
    )
    yield Claim("real.flux", "Length of the voltage's integral.", _EARLIER, None, flux, between(0.128, 0.138), "V·s")


def integrated(recording: Recording) -> tuple[float, Agreement]:
    """Magnitude of the integral of the voltage [V s], and agreement of its direction with the drive's estimate."""
    channel = recording["motor_voltage_alpha"]
    voltage = channel.values + 1j * recording["motor_voltage_beta"].values
    step = float(np.median(np.diff(channel.time)))
    flux = np.concatenate([[0.0], np.cumsum(0.5 * (voltage[1:] + voltage[:-1]))]) * step
    flux -= flux.mean()
    return float(np.abs(flux).mean()), agreement(np.angle(flux), -2.0 * np.pi * column(recording, "SlessThetaHat"))


def beside(recording: Recording) -> Iterator[Item]:
    """Items on `BESIDE`: the drive's estimate against an encoder at 0.6 Hz, without voltages."""
    agreed = agreement(*(2.0 * np.pi * column(recording, each) for each in ("SlessThetaHat", "ThetaElect")))
    yield Heading(
        "The drive's own estimate beside an encoder",
        (
            f"In {BESIDE} the drive turns at 0.6 Hz electrical. Its estimate stands {agreed.mean:.3g} rad "
            f"beside the encoder, half a turn, by {agreed.deviation:.2g} rad standard deviation: with that much "
            "the estimate of the other recordings has to be reckoned.",
        ),
    )
    yield _claim("encoder", "Standard deviation of the drive's estimate from an encoder.", agreed.deviation, 0.075)


_CURRENTS = ("motor_current_alpha", "motor_current_beta")


def _observers() -> dict[str, Block]:
    """Observers with fixed resistance and flux, which are not identifiable with the angle at one speed and current."""
    fixed = SampledMotorParameters(**vars(ASSUMED), sample_time=_FINE)
    held = replace(MotorAngleTuning(), resistance_wander=0.0, first_resistance=1e-3, flux_wander=0.0, first_flux=0.02)
    return {
        "default, resistance and flux held": MotorAngleObserver(fixed, held),
        "feedforward (46)": FeedforwardAngle(fixed),
        "flux observer": FluxObserver(fixed),
    }


def _samples(recording: Recording, sign: float) -> tuple[np.ndarray, np.ndarray]:
    """Samples of an observer, interpolated by splines, and the drive's own estimate [rad]."""
    from scipy.interpolate import CubicSpline

    time = recording[_CURRENTS[0]].time
    fine = np.arange(time[0] + _FINE, time[-1], _FINE)
    own = CubicSpline(time, np.unwrap(2.0 * math.pi * column(recording, "SlessThetaHat")))(fine)
    currents = [sign * CubicSpline(time, recording[name].values)(fine) for name in _CURRENTS]
    # The observers take a voltage as mean over the sample, which the antiderivative of the spline gives exactly.
    sums = [CubicSpline(time, recording[name].values).antiderivative() for name in _VOLTAGES]
    voltages = [(each(fine) - each(fine - _FINE)) / _FINE for each in sums]
    return np.column_stack([*currents, *voltages, own]), own


_VOLTAGES = ("motor_voltage_alpha", "motor_voltage_beta")


def _listed(names: list[str]) -> str:
    return ", ".join(names)


def _claim(key: str, what: str, value: float, most: float) -> Claim:
    return Claim(f"real.{key}", what, _EARLIER, None, value, at_most(most), "rad electrical")


def _absent(part: str) -> Iterator[Item]:
    for key in _KEYS[part]:
        yield Claim(f"real.{key}", "A recording of a real drive.", _EARLIER, None, None, None, "", NO_DATA)


_KEYS = {
    "dragged": ("current-sign", "mean", "deviation"),
    "turning": ("integral", "flux"),
    "beside": ("encoder",),
    "friction": ("friction",),
}
