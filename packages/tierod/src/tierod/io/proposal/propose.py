"""Proposal of a channel map for a recording: signal, unit and sign of every column that can be recognised."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.core.shown import printable
from tierod.core.signals import SIGNALS
from tierod.core.toml import quoted
from tierod.core.units import Scale, split_suffix
from tierod.io.proposal.motion import LONGEST, Motion
from tierod.io.proposal.signs import Sign, chosen_signs
from tierod.io.proposal.units import Chosen, Unit, candidates, chosen_units
from tierod.io.proposal.words import Meant, counts_turns, demand_of, meant_by, sign_of, state_of
from tierod.io.readers.channel_map import Entry
from tierod.io.readers.mapping import Pick, Plan
from tierod.io.readers.opening import Paths, open_source
from tierod.io.readers.reading import SHARE_READ, Reading, with_sign
from tierod.io.readers.source import Column

AT_FLIP = 0.2  # Largest share of the usual magnitude at which its sign changes [-]: it passes through zero there
SLICE = 600.0  # Length of a recording that is read at once [s]


@dataclass(frozen=True)
class Proposed:
    signal: str  # canonical name
    column: Column  # column of the file
    meant: Meant  # reason why the title stands for the signal
    unit: Chosen  # unit with its reason
    sign: Sign  # sign with its reason
    factor: float = 1.0  # factor of the entry beside the unit; 1 where the unit suffices
    others: tuple[str, ...] = ()  # other columns that could be the signal
    sign_from: str = ""  # column of the sign, where that of the signal is a magnitude

    @property
    def doubtful(self) -> bool:
        return not self.unit.decided or "check" in self.sign.reason


# Largest relative difference of the tyre radii of an axle by wear and pressure [-]: a wheel that deviates more has a
# fault, which a factor of its own would hide
LIKE_OTHERS = 0.03


@dataclass(frozen=True)
class Proposal:
    path: Path  # path of the recording
    entries: tuple[Proposed, ...]  # entries in the order of the file
    unmatched: tuple[Column, ...]  # columns that match no known signal
    texts: tuple[str, ...] = ()  # names of columns that hold text, which is not read


def propose(path: str | Path, dbc: Paths = None, progress: Callable[[float], None] = lambda share: None) -> Proposal:
    """The channel map that names, values and redundant signals of a recording suggest.

    Args:
        path: path of a recording, of which the first hour is evaluated
        dbc: database of a CAN log, or several
        progress: called with the share read, 0 to 1

    Raises:
        InputError: the file cannot be read, or no column matches a known signal
    """
    source, kind = open_source(path, dbc)
    columns = [column for column in source.columns if column.name not in source.silent]
    meant = {column.name: found for column in columns if (found := meant_by(column)) is not None}
    if not meant:
        has = ", ".join(f"'{column.name}'" for column in columns[:12])
        raise InputError(
            f"{path}: no column has a name that is known (it holds {has}); write the map by hand: [signals.NAME] with "
            'source = "COLUMN" for each; docs/reference/signals.md lists the names'
        )
    bits = [column.name for column in columns if any(sign_of(_title(column), name) for name in map(_title, columns))]
    picks = tuple(Pick(name, (name,), "", Entry((name,)), Scale(1.0)) for name in (*meant, *bits))
    loaded = _loaded(Reading(path, source, kind, Plan(picks)), progress)
    best, others = _one_each(columns, meant, loaded)
    sign_bits = {s: _sign_bit(c, [loaded[bit] for bit in bits if bit in loaded], loaded) for s, c in best.items()}
    raw = Recording(
        {
            s: replace(with_sign(loaded[c.name], bit) if (bit := sign_bits[s]) else loaded[c.name], name=s)
            for s, c in best.items()
            if c.name in loaded
        }
    )
    motion = Motion.of(raw)
    possible = {name: _candidates(name, column, raw) for name, column in best.items()}
    units = chosen_units(motion, possible)
    signs = chosen_signs(Motion.forward(raw, {name: unit.unit.factor for name, unit in units.items()}))
    radii = _radii(motion, units)
    entries = tuple(
        replace(
            _entry(name, column, meant[column.name], units[name], signs.get(name, Sign(1)), radii, others[name]),
            sign_from=bit.name if (bit := sign_bits[name]) else "",
        )
        for name, column in best.items()
    )
    taken = {column.name for column in best.values()} | set(itertools.chain(*others.values()))
    taken |= {bit.name for bit in sign_bits.values() if bit}
    unmatched = tuple(column for column in columns if column.name not in taken)
    return Proposal(Path(path), entries, unmatched, source.texts)


def _title(column: Column) -> str:
    return column.title or column.name


def _sign_bit(column: Column, bits: Sequence[Channel], loaded: Recording) -> Channel | None:
    """The bit that holds the sign of a column without negative values: of its message, of most words in common.

    It is none where it changes while the column is far from zero.
    """
    values = loaded[column.name].values if column.name in loaded else np.empty(0)
    usual = float(np.nanquantile(values, 0.95)) if np.isfinite(values).any() else 0.0
    if usual <= 0.0 or np.nanmin(values) < 0.0:
        return None
    message = column.name.rpartition(".")[0]
    near = [bit for bit in bits if bit.name.rpartition(".")[0] == message and sign_of(bit.name, column.name)]
    if not near:
        return None
    bit = max(near, key=lambda each: sign_of(each.name, column.name))
    if (bit.values < 0.0).any():  # 1 may stand for plus
        return None
    signed = with_sign(loaded[column.name], bit).values
    flips = np.flatnonzero(np.sign(signed[1:]) * np.sign(signed[:-1]) < 0.0)
    return bit if not len(flips) or float(np.median(np.abs(signed[flips]))) < AT_FLIP * usual else None


def _one_each(
    columns: list[Column], meant: dict[str, Meant], loaded: Recording
) -> tuple[dict[str, Column], dict[str, tuple[str, ...]]]:
    """Best column of every signal, one that moves first, then a known name, and the other candidates."""
    found: dict[str, list[Column]] = {}
    for column in columns:
        if column.name in meant:
            found.setdefault(meant[column.name].signal, []).append(column)
    best, others = {}, {}
    for signal, alike in found.items():
        ordered = sorted(
            alike, key=lambda each: (_constant(each, loaded), each.name != signal, not meant[each.name].exact)
        )
        best[signal], others[signal] = ordered[0], tuple(column.name for column in ordered[1:])
    return best, others


def _constant(column: Column, loaded: Recording) -> bool:
    values = loaded[column.name].values if column.name in loaded else np.empty(0)
    return not np.nanmax(values, initial=-math.inf) > np.nanmin(values, initial=math.inf)


def _loaded(reading: Reading, progress: Callable[[float], None]) -> Recording:
    parts: dict[str, list[Channel]] = {}
    begin = None
    for piece in reading.slices(SLICE):
        begin = piece.span[0] if begin is None else begin
        for name, channel in piece.channels.items():
            parts.setdefault(name, []).append(channel)
        progress(max(float(piece.metadata.get(SHARE_READ, 0.0)), min((piece.span[1] - begin) / LONGEST, 1.0)))
        if piece.span[1] - begin > LONGEST:
            break
    joined = {}
    for name, channels in parts.items():
        time, values = (np.concatenate([getattr(each, key) for each in channels]) for key in ("time", "values"))
        joined[name] = Channel(name, time, values, "", channels[0].source)
    return Recording(joined)


def _candidates(name: str, column: Column, raw: Recording) -> tuple[Unit, ...]:
    stated = column.unit or split_suffix(column.name)[1]
    values = raw[name].values if name in raw else np.empty(0)
    return candidates(name, stated, values, counts_turns(column.name))


def _entry(
    signal: str,
    column: Column,
    meant: Meant,
    unit: Chosen,
    sign: Sign,
    radii: dict[str, float],
    others: tuple[str, ...],
) -> Proposed:
    if not unit.unit.turns:
        return Proposed(signal, column, meant, unit, sign, 1.0, others)
    factor, decided = unit.unit.factor, unit.decided
    if signal in radii:
        usual = _beside_its_axle(signal, radii)
        odd = radii[signal] / usual - 1.0
        factor, decided = factor * usual, decided and not odd
        reason = f"turns of the wheel, {unit.unit.name}; factor from the vehicle speed"
        if odd:
            differs = f"{abs(odd):.0%} {'less' if odd > 0.0 else 'more'}"
            reason = f"{reason} and the other wheel of the axle; this wheel turns {differs}: check"
    else:
        reason = f"{unit.reason}; give that of your wheels"
    speed_unit = Unit("m/s", factor, stated=unit.unit.stated)
    return Proposed(signal, column, meant, Chosen(speed_unit, reason, decided), sign, factor, others)


def _beside_its_axle(signal: str, radii: dict[str, float]) -> float:
    """Radius of a wheel; where it is the deviating one of its axle, the radius of the other one."""
    sides = ("left", "right") if signal.endswith("left") else ("right", "left")
    partner = signal.removesuffix(sides[0]) + sides[1]
    own, other = radii[signal], radii.get(partner)
    if other is None or abs(own / other - 1.0) <= LIKE_OTHERS:
        return own
    rest = [radius for name, radius in radii.items() if name not in (signal, partner)] or [1.0]
    middle = float(np.median(rest))
    return other if abs(own / middle - 1.0) > abs(other / middle - 1.0) else own


def _radii(motion: Motion, units: dict[str, Chosen]) -> dict[str, float]:
    """Radius relative to the usual one, of each wheel whose turns are recorded, by a speed whose unit is decided."""
    by, speed = units.get("vehicle_speed"), motion.columns.get("vehicle_speed")
    found: dict[str, float] = {}
    if by is None or not by.decided or speed is None:
        return found
    for signal, unit in units.items():
        values = motion.columns.get(signal)
        if not unit.unit.turns or values is None:
            continue
        good = np.isfinite(speed) & np.isfinite(values)
        turns = float(np.mean(values[good])) if np.any(good) else 0.0
        radius = by.unit.factor * float(np.mean(speed[good])) / turns / unit.unit.factor if turns else math.nan
        if 0.7 < radius < 1.4:  # 0.22 to 0.43 m, else it is no wheel of a car
            found[signal] = radius
    return found


def text_of(proposal: Proposal) -> str:
    doubtful = [entry.signal for entry in proposal.entries if entry.doubtful]
    head = [
        f"# Channel map proposed from {printable(proposal.path.name)}: edit it, and keep what is right.",
        "# SI units and ISO 8855 hold behind it: forward and left are positive.",
    ]
    if doubtful:
        head.append(f"# To check: {', '.join(doubtful)}.")
    parts = ["\n".join([*head, f"title = {quoted(f'proposed from {proposal.path.name}')}"])]
    parts += [_table(entry) for entry in proposal.entries]
    if proposal.unmatched:
        lines = ["# Columns that were not matched; write a table for each that you need:"]
        lines += [
            f"#   {quoted(c.name)}{f'  [{printable(c.unit)}]' if c.unit else ''}{_why_not(c)}"
            for c in proposal.unmatched
        ]
        lines += ["# [signals.NAME]  # a name of 'docs/reference/signals.md'", '# source = "COLUMN"', '# unit = "..."']
        parts.append("\n".join(lines))
    if proposal.texts:
        names = ", ".join(map(quoted, proposal.texts))
        parts.append(
            f"# Not read, since they hold text: {names}. Values that such a flag marks as invalid are read as valid."
        )
    return "\n\n".join(parts) + "\n"


def _why_not(column: Column) -> str:
    title = column.title or column.name
    for kind, word in (("a demand", demand_of(title)), ("a state or quality", state_of(title))):
        if word:
            return f"  holds '{word}': {kind}"
    return ""


def _table(entry: Proposed) -> str:
    signal = SIGNALS[entry.signal]
    lines = [f"[signals.{entry.signal}]  # {signal.meaning}", f"source = {quoted(entry.column.name)}"]
    reason = f"name: {entry.meant.reason}"
    if entry.others:
        reason += f"; other candidates: {', '.join(map(repr, entry.others))}"
    lines[-1] += f"  # {printable(reason)}"
    lines.append(f"unit = {quoted(entry.unit.unit.name)}  # {entry.unit.reason}")
    if entry.factor != 1.0:
        lines.append(f"factor = {entry.factor:.5g}  # m/s of one unit of the column")
    if entry.sign_from:
        lines.append(f"sign_from = {quoted(entry.sign_from)}  # the column is a magnitude; this bit is its sign")
    if entry.sign.sign < 0 or entry.sign.reason:
        lines.append(f"sign = {entry.sign.sign}  # {entry.sign.reason}; positive: {signal.positive or '-'}")
    return "\n".join(lines)
