"""Acceptance of a recording by a monitor: its vehicle, and reasons for refusal before the run and at its begin."""

from __future__ import annotations

import os
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, ParameterError, TierodError, nearest
from tierod.core.facts import Verdict
from tierod.core.findings import Finding, Status
from tierod.core.recording import Channel, Recording
from tierod.core.shown import written
from tierod.core.signals import SIGNALS
from tierod.core.units import COUNT, dimensions, known, scale
from tierod.io.derive import RECIPES, complete, ingredients
from tierod.io.readers import LACKING, SHARE_READ
from tierod.monitors.pieces import QualityOverChunks
from tierod.monitors.session import Monitor, Variant, opened
from tierod.vehicles import Vehicle, shipped

KEYS = ("vehicle_file", "virtual_car", "vehicle")
"""Entries of a recording's metadata that may name a vehicle; many virtual cars have the name of their vehicle file."""

SHORT = 1.0  # Duration of a recording that is read to obtain its metadata [s]


def vehicle_named_in(source: Recording | str | Path, dbc: Any = None, channel_map: Any = None) -> str:
    """Name of the shipped vehicle that the metadata of a recording name."""
    metadata = source.metadata if isinstance(source, Recording) else _metadata(source, dbc, channel_map)
    named = [metadata[key] for key in KEYS if isinstance(metadata.get(key), str)]
    for name in named:
        if name in shipped():
            return str(name)
    shown = f"names '{named[0]}', which tierod does not ship" if named else "names none"
    raise ParameterError(
        f"no vehicle is given, and the recording {shown}; give --vehicle (in Python: vehicle=...) with a name of "
        "'tierod vehicles' or the path of a TOML file"
    )


def other_vehicle(metadata: Mapping[str, Any], judged_as: str) -> str | None:
    """Warning if a recording names another shipped vehicle than the one whose parameters are used; None if not."""
    named = made_with(metadata, judged_as)
    if named is None:
        return None
    return (
        f"the recording was made with the vehicle '{named}', but is judged as '{judged_as}': where these differ, the "
        "verdict is not valid; check --vehicle"
    )


def made_with(metadata: Mapping[str, Any], judged_as: str) -> str | None:
    """Name of another shipped vehicle that the recording names; None if there is none. Arguments: `other_vehicle`."""
    named = [metadata[key] for key in KEYS if isinstance(metadata.get(key), str)]
    return None if judged_as in named else next((name for name in named if name in shipped()), None)


def _metadata(path: str | Path, dbc: Any, channel_map: Any) -> Mapping[str, Any]:
    from tierod.io.readers import open_chunks

    if os.path.exists(path) and Path(path).is_fifo():
        raise InputError(
            f"no vehicle is given, and {path} is a pipe, which can be read once only; give --vehicle (in Python: "
            "vehicle=...)"
        )
    try:
        return next(iter(open_chunks(path, seconds=SHORT, dbc=dbc, channel_map=channel_map))).metadata
    except InputError as error:
        if not Path(path).is_file():
            raise
        raise InputError(
            f"no vehicle is given, and none can be read from the recording: {error}; or give --vehicle (in Python: "
            "vehicle=...), whose file may name databases and channel map"
        ) from None


def refuse_unsuitable(monitor: Monitor, vehicle: Vehicle | None, piece: Recording) -> None:
    """Refuse a recording that lacks a required signal, or has one in raw counts instead of its unit.

    Args:
        vehicle: vehicle whose file may allow torques in counts; None if none is given
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
            f"{needed} does not have{near} {instead}{_cure(missing, piece)}; 'tierod "
            "inspect' shows what the recording has"
        )
    if vehicle is not None:
        _refuse_counts(monitor, vehicle, piece)


def _refuse_counts(monitor: Monitor, vehicle: Vehicle, piece: Recording) -> None:
    """Refuse raw counts, which would give a wrong verdict, except as torques of a vehicle whose file allows them."""
    for name in monitor.required:
        torque = SIGNALS[name].unit == "N*m"
        if piece[name].unit == COUNT and (vehicle.calibrated or not torque):
            other = ', or torque_unit = "count" in the vehicle file' if torque else ""
            raise InputError(
                f"{name} is in raw counts, but the vehicle '{vehicle.name}' needs {written(SIGNALS[name].unit)}; "
                f"give unit and factor (the {written(SIGNALS[name].unit)} of one count) in the channel map{other}"
            )


def _named_in_vain(missing: list[str], piece: Recording) -> str:
    """Sentences on missing signals for which the channel map names a column that the file does not have."""
    absent = piece.metadata.get(LACKING, {})
    return " ".join(absent[name] for name in ingredients(missing) if name in absent)


def _cure(missing: Sequence[str], piece: Recording) -> str:
    """What to do about missing signals: a channel map helps only where the recording has them under another name."""
    if SHARE_READ in piece.metadata:
        # Only the signals of the monitor were read from the file, which may have others.
        return "Record what is missing, or give a channel map if the file has it under another name"
    strangers = [piece[name] for name in piece.names if name not in SIGNALS]
    gone = [name for name in missing if not any(_could_be(e, other) for e in _made_from(name) for other in strangers)]
    here = ", ".join(name for name in missing if name not in gone)
    named = f"Give a channel map that names {here if gone else 'it'}" if here else ""
    if not gone:
        return named
    it, them = ("one of them", "them") if len(gone) > 1 else ("it", "it")
    return f"{named}{'. ' if here else ''}No other channel could be {' or '.join(gone) if here else it}: record {them}"


def _could_be(name: str, channel: Channel) -> bool:
    """Whether a channel that no map names may be a signal: one without unit, or in counts, may be any."""
    if channel.unit in ("", COUNT) or not known(channel.unit):
        return True
    try:
        return bool(scale(channel.unit, SIGNALS[name].unit))
    except InputError:
        # Wheels may be given in revolutions.
        return name.startswith("wheel_speed_") and dimensions(channel.unit) == dimensions("rad/s")


def _in_their_place(monitor: Monitor, missing: list[str]) -> str:
    """Sentences on the signals that other variants use in place of the missing ones."""
    sentences = ""
    for variant in monitor.variants.values():
        needed = monitor.needing(variant).required
        others = [name for name in needed if name not in monitor.required]
        if others and not any(name in needed for name in missing):
            sentences += f"The variant '{variant.name}' takes {', '.join(others)} in its place. "
    return sentences


def _with_ingredients(name: str) -> str:
    """Name of a signal, with the signals that it could be derived from."""
    _, *made_from = _made_from(name)
    return f"{name} (or {' and '.join(made_from)})" if made_from else name


def _made_from(name: str) -> tuple[str, ...]:
    """A signal, and those that it could be derived from."""
    return (name, *RECIPES[name].needs) if name in RECIPES else (name,)


SEEN = 1.0  # Duration of the beginning of a recording that a session receives to decide on its refusal [s]

TRIED = 30.0  # Duration of a trial run that determines whether a monitor has enough of its optional signals [s]

NO_SIGNAL = "the recording has none of its signals"  # Reason why a monitor without required signals cannot run

TOO_FEW = "fewer than"
"""Beginning of the cause that a monitor without required signals states when it has too few signals."""


@dataclass(frozen=True)
class Readiness:
    """Whether a monitor could judge a recording."""

    monitor: Monitor  # monitor in question
    reasons: Mapping[str, str]  # reason for refusal by name of the variant; "" if the variant would run

    @property
    def variants(self) -> tuple[str, ...]:
        """Names of the variants that would run, the default first."""
        return taken(self.monitor, self.reasons)

    @property
    def obstacles(self) -> tuple[str, ...]:
        """Reasons why no variant runs, each once, that of the default first; empty if a variant would run."""
        if self.variants:
            return ()
        ordered = sorted(self.reasons, key=lambda name: name != self.monitor.default)
        return tuple(dict.fromkeys(self.reasons[name] for name in ordered))

    @property
    def reason(self) -> str:
        """First reason why no variant runs; "" if a variant would run."""
        return next(iter(self.obstacles), "")

    @property
    def choice(self) -> str:
        """Condition under which it can run, and the variants to choose from, as a half-sentence after "can run"."""
        monitor = self.monitor
        condition = f" if {monitor.condition}" if monitor.condition else ""
        return condition if monitor.default else f"{condition}; choose --variant {' or '.join(self.variants)}"


def refusals(monitor: Monitor, vehicle: Vehicle | None, recording: Recording, whole: bool = True) -> Mapping[str, str]:
    """Reason why a diagnosis would refuse the recording, by variant; "" if the variant would run.

    Without a vehicle only the signals are checked; with `whole`, also what only a whole recording can show.
    """
    complete_one = complete(recording, [*monitor.required, *monitor.optional])
    return {
        variant.name: _refusal(monitor, variant, vehicle, complete_one, whole) for variant in monitor.variants.values()
    }


def taken(monitor: Monitor, reasons: Mapping[str, str]) -> tuple[str, ...]:
    """Names of the variants that would run, the default first."""
    free = [name for name, reason in reasons.items() if not reason]
    return tuple(sorted(free, key=lambda name: name != monitor.default))


def unable(monitor: Monitor, finding: Finding | Verdict, names: Container[str]) -> str:
    """Cause of a finding that states nothing because the recording lacks signals; "" for any other finding."""
    if not any(name in names for name in (*monitor.required, *monitor.optional)):
        return NO_SIGNAL
    too_few = not monitor.required and finding.cause.startswith(TOO_FEW)
    without = finding.status is Status.NOT_AVAILABLE and finding.since is None and _may_lack(monitor, names)
    return finding.cause if too_few or without else ""


def _may_lack(monitor: Monitor, names: Container[str]) -> bool:
    """Whether two or more signals that the result rests on are absent; a single one may have a substitute."""
    return sum(name not in names for name in monitor.rests_on) > 1


def _refusal(monitor: Monitor, variant: Variant, vehicle: Vehicle | None, recording: Recording, whole: bool) -> str:
    suited = monitor.needing(variant).suited_to(recording)
    if not suited.required and not any(name in recording for name in suited.optional):
        return NO_SIGNAL
    try:
        refuse_unsuitable(suited, vehicle, recording)
        quality = QualityOverChunks(ingredients(suited.required))
        quality.add(recording)
        quality.refuse_slow(suited.required, suited.minimum_rate)
        if whole:
            quality.refuse_unusable(suited.required, suited.minimum_rate)
        return "" if vehicle is None else _refusal_of_session(suited, variant, vehicle, recording, whole)
    except TierodError as error:
        return str(error)


def _refusal_of_session(suited: Monitor, variant: Variant, vehicle: Vehicle, recording: Recording, whole: bool) -> str:
    """Reason why the session of a variant would state nothing; "" if it states a result."""
    session, (start, end), age = opened(suited, variant, vehicle), recording.span, suited.maximum_age
    session.refuse(recording.align(session.signals, suited.rate, maximum_age=age, start=start, stop=start + SEEN))
    if not whole:
        return ""
    # Whether the recording is a condition test shows only at its end; such recordings are short.
    if suited.condition:
        session.absorb(recording.align(session.signals, suited.rate, maximum_age=age))
        session.conclude()
    elif not suited.required or _may_lack(suited, recording):
        # Channels may start late: the trial begins when all are there, unless too little would be left.
        begun = max((recording[name].time[0] for name in session.signals if _is_there(name, recording)), default=start)
        start = max(start, min(float(begun), end - TRIED))
        stop = min(start + TRIED, end)
        aligned = recording.align(session.signals, suited.rate, maximum_age=age, start=start, stop=stop)
        if not len(aligned.time):
            return "the recording holds a single instant, or none"
        session.absorb(aligned)
        return unable(suited, session.conclude().verdict, recording)
    return ""


def _is_there(name: str, recording: Recording) -> bool:
    return name in recording and len(recording[name].time) > 0
