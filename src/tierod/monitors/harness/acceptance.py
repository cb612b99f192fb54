"""Acceptance of a recording by a monitor: grounds of refusal, before it runs and with its first piece."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tierod.core.errors import InputError, TierodError, nearest
from tierod.core.findings import Finding, Status
from tierod.core.recording import Recording
from tierod.core.shown import written
from tierod.core.signals import SIGNALS
from tierod.core.units import COUNT
from tierod.io.derive import RECIPES, complete, ingredients
from tierod.io.readers import LACKING
from tierod.monitors.harness.named_vehicle import made_with
from tierod.monitors.harness.quality_over_chunks import QualityOverChunks
from tierod.monitors.harness.session import Monitor, Variant, opened
from tierod.vehicles import Vehicle


def refuse_unsuitable(monitor: Monitor, vehicle: Vehicle | None, piece: Recording) -> None:
    """Refuse a recording without a signal that the monitor needs, or with one in counts where a torque is needed.

    Args:
        monitor: the judging monitor
        vehicle: whose torques may be counts; None where none is given
        piece: the first one of the recording, with all derived signals

    Raises:
        InputError: the signal is named, and what to do
    """
    missing = [name for name in monitor.required if name not in piece]
    if missing:
        strangers = [name for name in piece.names if name not in SIGNALS]
        near = nearest(missing[0], strangers) if strangers else "."
        other = None if vehicle is None else made_with(piece.metadata, vehicle.name)
        if vehicle is not None and other is not None:
            raise InputError(
                f"the monitor '{monitor.name}' needs {', '.join(missing)}, which the recording does not have; it was "
                f"made with the vehicle '{other}', not with '{vehicle.name}': judge it with --vehicle {other}"
            )
        needed = f"the monitor '{monitor.name}' needs {', '.join(map(_with_ingredients, missing))}, which the recording"
        instead = _in_their_place(monitor, missing)
        if absent := _named_in_vain(missing, piece):
            raise InputError(f"{needed} does not have: {absent} {instead}Correct the channel map, or record it")
        raise InputError(
            f"{needed} does not have{near} {instead}Give a channel map that names it; 'tierod inspect' shows what the "
            "recording has"
        )
    if vehicle is not None:
        _refuse_counts(monitor, vehicle, piece)


def _refuse_counts(monitor: Monitor, vehicle: Vehicle, piece: Recording) -> None:
    """Raw counts are judged only as torques of a vehicle whose file allows it: taken as N*m, any verdict is wrong."""
    for name in monitor.required:
        torque = SIGNALS[name].unit == "N*m"
        if piece[name].unit == COUNT and (vehicle.calibrated or not torque):
            other = ', or torque_unit = "count" in the vehicle file' if torque else ""
            raise InputError(
                f"{name} is in raw counts, but the vehicle '{vehicle.name}' needs {written(SIGNALS[name].unit)}; "
                f"give unit and factor (the {written(SIGNALS[name].unit)} of one count) in the channel map{other}"
            )


def _named_in_vain(missing: list[str], piece: Recording) -> str:
    """Which columns the channel map names for the missing signals that the file lacks, as sentences."""
    absent = piece.metadata.get(LACKING, {})
    return " ".join(absent[name] for name in ingredients(missing) if name in absent)


def _in_their_place(monitor: Monitor, missing: list[str]) -> str:
    """Signals that other variants take in place of the missing ones, as sentences."""
    sentences = ""
    for variant in monitor.variants.values():
        needed = monitor.needing(variant).required
        others = [name for name in needed if name not in monitor.required]
        if others and not any(name in needed for name in missing):
            sentences += f"The variant '{variant.name}' takes {', '.join(others)} in its place. "
    return sentences


def _with_ingredients(name: str) -> str:
    """The signal, and those that it could be made from."""
    made_from = RECIPES[name].needs if name in RECIPES else ()
    return f"{name} (or {' and '.join(made_from)})" if made_from else name


SEEN = 1.0
"""Seconds of a recording that a session sees before it refuses it."""

TRIED = 30.0
"""Seconds that a monitor judges before it is known whether it has enough of the signals that it can do without."""

TOO_FEW = "fewer than"
"""How the cause of a monitor without required signals begins that has too few."""


@dataclass(frozen=True)
class Readiness:
    """Whether a monitor could judge a recording.

    Args:
        monitor: that is asked for
        reasons: by the name of every variant, why it would refuse the recording; "" where it would run
    """

    monitor: Monitor
    reasons: Mapping[str, str]

    @property
    def variants(self) -> tuple[str, ...]:
        """The variants that would run: the default first, where the monitor has one."""
        return taken(self.monitor, self.reasons)

    @property
    def obstacles(self) -> tuple[str, ...]:
        """Why no variant runs, the default's reason first and each reason once; empty where one would."""
        if self.variants:
            return ()
        ordered = sorted(self.reasons, key=lambda name: name != self.monitor.default)
        return tuple(dict.fromkeys(self.reasons[name] for name in ordered))

    @property
    def reason(self) -> str:
        """Why no variant runs; "" where one would. Other variants than the first lack as much, or they would run."""
        return next(iter(self.obstacles), "")

    @property
    def choice(self) -> str:
        """On what condition it can run, and what must be chosen, as a half-sentence behind "can run"."""
        monitor = self.monitor
        condition = f" if {monitor.condition}" if monitor.condition else ""
        return condition if monitor.default else f"{condition}; choose --variant {' or '.join(self.variants)}"


def refusals(monitor: Monitor, vehicle: Vehicle | None, recording: Recording, whole: bool = True) -> Mapping[str, str]:
    """Reason why a diagnosis would refuse the recording, by variant; "" where it would run.

    Args:
        monitor: that is asked for
        vehicle: as which it would be judged; None where none is given, so that only the signals are checked
        recording: the whole, or its beginning
        whole: whether it is the whole; what shows only over the whole is not asked of a beginning
    """
    complete_one = complete(recording, [*monitor.required, *monitor.optional])
    return {
        variant.name: _refusal(monitor, variant, vehicle, complete_one, whole) for variant in monitor.variants.values()
    }


def taken(monitor: Monitor, reasons: Mapping[str, str]) -> tuple[str, ...]:
    """The variants that would run: the default first, where the monitor has one.

    Args:
        monitor: that is asked for
        reasons: as of `refusals`
    """
    free = [name for name, reason in reasons.items() if not reason]
    return tuple(sorted(free, key=lambda name: name != monitor.default))


def unable(monitor: Monitor, finding: Finding, recording: Recording) -> str:
    """Why a monitor could state nothing on a recording for the signals that this does not have; "" else.

    Args:
        monitor: that judged
        finding: of the whole, or of a stretch
        recording: the whole, or its beginning
    """
    too_few = not monitor.required and finding.cause.startswith(TOO_FEW)
    without = finding.status is Status.NOT_AVAILABLE and finding.since is None and _may_lack(monitor, recording)
    return finding.cause if too_few or without else ""


def _may_lack(monitor: Monitor, recording: Recording) -> bool:
    """Whether more than one of the signals is absent on which the result rests: for one alone another may stand."""
    return sum(name not in recording for name in monitor.rests_on) > 1


def _refusal(monitor: Monitor, variant: Variant, vehicle: Vehicle | None, recording: Recording, whole: bool) -> str:
    suited = monitor.needing(variant).suited_to(recording)
    if not suited.required and not any(name in recording for name in suited.optional):
        return "the recording has none of its signals"
    try:
        refuse_unsuitable(suited, vehicle, recording)
        quality = QualityOverChunks(ingredients(suited.required))
        quality.add(recording)
        quality.refuse_slow(suited.required, suited.minimum_rate)
        if whole:
            quality.refuse_unusable(suited.required)
        return "" if vehicle is None else _refusal_of_session(suited, variant, vehicle, recording, whole)
    except TierodError as error:
        return str(error)


def _refusal_of_session(suited: Monitor, variant: Variant, vehicle: Vehicle, recording: Recording, whole: bool) -> str:
    """Why its session refuses, or would state nothing.

    Raises:
        InputError: it refuses
        ParameterError: it cannot run with this vehicle
    """
    session, (start, end), age = opened(suited, variant, vehicle), recording.span, suited.maximum_age
    session.refuse(recording.align(session.signals, suited.rate, maximum_age=age, start=start, stop=start + SEEN))
    if not whole:
        return ""
    # Whether the recording is a condition test shows only at its end; such recordings are short.
    if suited.condition:
        session.absorb(recording.align(session.signals, suited.rate, maximum_age=age))
        session.conclude()
    elif not suited.required or _may_lack(suited, recording):
        begun = max((recording[name].time[0] for name in session.signals if _is_there(name, recording)), default=start)
        start = max(start, min(float(begun), end - TRIED))
        stop = min(start + TRIED, end)
        aligned = recording.align(session.signals, suited.rate, maximum_age=age, start=start, stop=stop)
        if not len(aligned.time):
            return "the recording holds a single instant, or none"
        session.absorb(aligned)
        return unable(suited, session.conclude().finding, recording)
    return ""


def _is_there(name: str, recording: Recording) -> bool:
    return name in recording and len(recording[name].time) > 0
