"""Acceptance of a recording by a monitor: grounds of refusal, before it runs and with its first piece."""

from __future__ import annotations

from collections.abc import Mapping

from tierod.core.errors import InputError, TierodError, nearest
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
"""Seconds that a monitor without required signals judges before it is known whether it has enough of them."""

TOO_FEW = "fewer than"
"""How the cause of such a monitor begins that has not."""


def refusals(monitor: Monitor, vehicle: Vehicle | None, recording: Recording) -> Mapping[str, str]:
    """Reason why a diagnosis would refuse the recording, by variant; "" where it would run.

    Args:
        monitor: that is asked for
        vehicle: as which it would be judged; None where none is given, so that only the signals are checked
        recording: the whole
    """
    whole = complete(recording, [*monitor.required, *monitor.optional])
    return {variant.name: _refusal(monitor, variant, vehicle, whole) for variant in monitor.variants.values()}


def taken(monitor: Monitor, reasons: Mapping[str, str]) -> tuple[str, ...]:
    """The variants that would run: the default first, where the monitor has one.

    Args:
        monitor: that is asked for
        reasons: as of `refusals`
    """
    free = [name for name, reason in reasons.items() if not reason]
    return tuple(sorted(free, key=lambda name: name != monitor.default))


def _refusal(monitor: Monitor, variant: Variant, vehicle: Vehicle | None, whole: Recording) -> str:
    suited = monitor.needing(variant).suited_to(whole)
    if not any(name in whole for name in (*suited.required, *suited.optional)):
        return "the recording has none of its signals"
    try:
        refuse_unsuitable(suited, vehicle, whole)
        quality = QualityOverChunks(ingredients(suited.required))
        quality.add(whole)
        quality.refuse_slow(suited.required, suited.minimum_rate)
        quality.refuse_unusable(suited.required)
        if vehicle is not None:
            session, start = opened(suited, variant, vehicle), whole.span[0]
            age = suited.maximum_age
            session.refuse(whole.align(session.signals, suited.rate, maximum_age=age, start=start, stop=start + SEEN))
            # Whether the recording is a condition test shows only at its end; such recordings are short.
            if monitor.condition:
                session.absorb(whole.align(session.signals, suited.rate, maximum_age=age))
                session.conclude()
            elif not suited.required:
                stop = min(start + TRIED, whole.span[1])
                aligned = whole.align(session.signals, suited.rate, maximum_age=age, start=start, stop=stop)
                if not len(aligned.time):
                    return "the recording holds a single instant, or none"
                session.absorb(aligned)
                finding = session.conclude().finding
                return finding.cause if finding.cause.startswith(TOO_FEW) else ""
    except TierodError as error:
        return str(error)
    return ""
