"""Job that analyses a recording: a preview, every signal in levels of resolution, then the verdicts of all monitors."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.errors import InputError, ParameterError, TierodError
from tierod.core.files import sha256_of, write_text
from tierod.core.findings import Decided, Diagnosis
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.fleet.judging import Asked
from tierod.fleet.stamps import code, vehicle_digest
from tierod.io.derive import RECIPES, ingredients
from tierod.io.formats import plain
from tierod.io.readers import SHARE_READ, ChannelMap, open_chunks, open_source, parse_channel_map
from tierod.io.readers.opening import shipped
from tierod.io.readers.reading import completed, loaded_map, planned
from tierod.monitors.pieces import CHUNK
from tierod.monitors.run import Kept, Run
from tierod.monitors.runner import Concluded, Runner, usual
from tierod.vehicles import Vehicle, load
from tierod.vehicles.vehicle import read_by
from tierod.web.errors import in_the_page
from tierod.web.series import SeriesReader, SeriesWriter
from tierod.web.store import Store, stamp_of
from tierod.work.fingerprint import fingerprint

SCHEMA = "tierod.web-result/1"

DERIVED = "derived:"  # Prefix of the note of a signal that was derived from others

NONE = "none"  # Placeholder for the vehicle of a recording whose vehicle is unknown

FIRST_SIGNALS = 4  # Number of signals in the preview of a large file

LARGE = 30 << 20  # File size from which there is a preview; smaller files are read within a second [bytes]

HOUR = 3600.0
"""Time span of the few signals of a preview that is read at once; faster than a whole file, as memory is reused [s]."""

SLICE = 600.0  # Time span of a recording that is read at once [s]

MOST_SIGNALS = 1000  # Largest number of signals that are kept of a recording; signals of the catalogue come first

FIRST = ("steering_wheel_angle", "driver_torque", "vehicle_speed", "yaw_rate", "lateral_acceleration", "motor_torque")
"""Signals preferred in a preview."""

Say = Callable[..., None]
"""Function that receives the progress: share done, current step, and results that are available already."""


@dataclasses.dataclass(frozen=True)
class Reading:
    """Settings by which a recording is read."""

    path: Path
    dbc: tuple[str, ...] = ()  # its databases; if empty, those of the vehicle
    # path or content of its channel map; None for that of the vehicle
    channel_map: str | Mapping[str, Any] | None = None

    def files(self, car: Vehicle | None) -> tuple[tuple[str | Path, ...], ChannelMap | None]:
        given = self.channel_map
        written = parse_channel_map(given, "the channel map of the page") if isinstance(given, Mapping) else given
        databases, chosen = read_by(car, self.dbc, written)
        return databases, loaded_map(chosen)


def analyse(store: Store, reading: Reading, vehicle: str, spread: bool, say: Say) -> dict[str, Any]:
    """Read a recording, judge it with every monitor that can run, and store signals and verdicts.

    Args:
        vehicle: name or path of the vehicle; "" for the vehicle named in the recording, if any
        spread: whether parameter uncertainty is propagated into the verdicts

    Returns:
        keys of the signals and of the result, and why there is no result; the key of the result is "" if no vehicle is
        known

    Raises:
        InputError: the recording cannot be read
        ParameterError: there is no such vehicle
    """
    stamp = stamp_of(reading.path)
    if reading.path.stat().st_size > LARGE and not store.known(stamp).get("series"):
        with suppress(TierodError):  # errors are reported below, when the whole file is read
            _first_picture(store, reading, *reading.files(load(vehicle) if vehicle else None), f"p-{stamp}", say)
    car, why = _vehicle(reading, vehicle)
    dbc, used = reading.files(car)
    say(0.02, "reading the file")
    content = digest(reading.path)
    files = [digest(shipped(each, ".dbc")) for each in dbc]
    key = fingerprint(
        "tierod.web-series/2", content, files, None if used is None else (used.entries, used.time), code()
    )
    if not store.holds("series", key):
        _keep_series(store, reading, dbc, used, key, say)
    store.remember(stamp, {"series": key})
    say(0.4, "judging", series=key)
    series = SeriesReader(store.path("series", key))
    if car is None:
        store.remember(stamp, {"series": key, "vehicle": NONE, "why": why})
        return {"series": key, "result": "", "why": why}
    asked = Asked(usual(), spread=spread)
    result = fingerprint(content, vehicle_digest(car), asked, code(), None, True, key)
    if not store.holds("results", result):
        _keep_result(store, reading, series, car, asked, {"key": result, "series": key, "content": content}, say)
    store.remember(stamp, {"series": key, "result": result, "vehicle": vehicle})
    return {"series": key, "result": result, "why": ""}


def _vehicle(reading: Reading, vehicle: str) -> tuple[Vehicle | None, str]:
    """The vehicle and "", or None and the reason."""
    from tierod.monitors.acceptance import vehicle_named_in

    if vehicle:
        return load(vehicle), ""
    dbc, used = reading.files(None)
    try:
        return load(vehicle_named_in(reading.path, dbc, used)), ""
    except ParameterError as error:
        return None, in_the_page(str(error))


def digest(path: Path) -> str:
    """SHA-256 of the content of a recording, which may be a file or a folder."""
    try:
        return sha256_of(path)
    except IsADirectoryError:
        parts = sorted(each for each in path.iterdir() if each.is_file())
        return fingerprint([(each.name, digest(each)) for each in parts])
    except OSError as error:
        raise InputError(f"{path.name} cannot be read ({(error.strerror or '').lower()}); check the file") from None


def _first_picture(store: Store, reading: Reading, dbc: Any, used: ChannelMap | None, key: str, say: Say) -> None:
    """Store a few signals of a large file under a key of their own, until all signals are read."""
    say(0.0, "a first picture")
    source, _ = open_source(reading.path, dbc, used.time if used else None)
    known = [pick.name for pick in planned(reading.path, source, used, None).picks]
    chosen = sorted(known, key=lambda each: FIRST.index(each) if each in FIRST else len(FIRST))[:FIRST_SIGNALS]
    folder = store.begun("series")
    writer = SeriesWriter(folder)
    for piece in open_chunks(reading.path, seconds=HOUR, names=chosen, dbc=dbc, channel_map=used):
        writer.add([piece[name] for name in chosen if name in piece])
    writer.finish({"first": True})
    store.settled(folder, "series", key)
    say(0.01, "reading the file", series=key)


def _keep_series(store: Store, reading: Reading, dbc: Any, used: ChannelMap | None, key: str, say: Say) -> None:
    folder = store.begun("series")
    writer, derived = SeriesWriter(folder), Derived()
    metadata: Mapping[str, Any] = {}
    for piece in open_chunks(reading.path, seconds=SLICE, dbc=dbc, channel_map=used):
        known = [each for name, each in piece.channels.items() if name in SIGNALS]
        others = [each for name, each in piece.channels.items() if name not in SIGNALS]
        made, recorded = derived.of(piece)
        for name in recorded:
            del writer.signals[name]
        writer.add([*known, *others[: MOST_SIGNALS - len(known)], *made])
        metadata = piece.metadata
        say(0.02 + 0.35 * float(metadata.get(SHARE_READ, 1.0)), "reading the file")
    facts = {name: value for name, value in plain(dict(metadata)).items() if name != SHARE_READ}
    if len(writer.signals) >= MOST_SIGNALS:
        facts["left_out"] = f"more than {MOST_SIGNALS} signals; a channel map chooses those that are wanted"
    writer.finish(facts)
    store.settled(folder, "series", key)


class Derived:
    """Derives signals from others, slice by slice; a signal is no longer derived once it is found recorded."""

    def __init__(self) -> None:
        self._open = dict.fromkeys(RECIPES)
        self._made: set[str] = set()
        self._past: Recording | None = None

    def of(self, piece: Recording) -> tuple[list[Channel], list[str]]:
        """(signals derived from a slice, names of signals that were derived so far and are recorded in it)."""
        recorded = [name for name in self._open if name in piece]
        for name in recorded:
            del self._open[name]
        dropped = [name for name in recorded if name in self._made]
        needed = ingredients(self._open)
        part = Recording({name: each for name, each in piece.channels.items() if name in needed and len(each.time)})
        if not part.channels:
            return [], dropped
        past = self._past if self._past is not None and set(part.channels) <= set(self._past.channels) else None
        whole = completed(part, past, tuple(self._open))
        self._past = part
        made = [each for name, each in whole.channels.items() if name not in part]
        self._made |= {each.name for each in made}
        return made, dropped


def _keep_result(
    store: Store, reading: Reading, series: SeriesReader, car: Vehicle, asked: Asked, keys: dict[str, str], say: Say
) -> None:
    """Judge the stored signals, and store findings, estimates and reports."""
    folder = store.begun("results")
    writer = SeriesWriter(folder)
    runner = Runner(car, asked.monitors, asked.spread)
    for name, run in runner.runs.items():
        run.kept = _written(name, run, writer)
    # A signal that no monitor reads must not shift the beginning of the judged span.
    needed = {*runner.needs, *ingredients(runner.needs)}
    # A monitor derives the signals that it needs itself, and notes that they are derived.
    wanted = [name for name, each in series.signals.items() if name in needed and not each.note.startswith(DERIVED)]
    begin, end = series.span
    for piece in pieces(series, wanted, CHUNK):
        runner.add(piece)
        say(0.4 + 0.5 * (piece.span[1] - begin) / max(end - begin, 1e-9), "judging")
        if not runner.runs:
            break
    concluded = dict(runner.concluded())
    _withhold(writer, concluded)
    writer.finish({})
    for place, (name, each) in enumerate(concluded.items()):
        say(0.9 + 0.1 * place / len(concluded), f"writing the report of {name}")
        _write_report(folder / f"report-{name}.html", each.diagnosis)
    about = {
        "schema": SCHEMA,
        **keys,
        "path": str(reading.path),
        "vehicle": car.name,
        "monitors": {name: monitor_document(each) for name, each in concluded.items()},
        "not_run": dict(runner.refused),
    }
    write_text(folder / "result.json", json.dumps(about), sweeps=False)
    store.settled(folder, "results", keys["key"])


def _withhold(writer: SeriesWriter, concluded: Mapping[str, Concluded]) -> None:
    """Remove estimates that a monitor does not include in its final diagnosis."""
    for name in list(writer.signals):
        monitor, _, trace = name.partition("/")
        if monitor not in concluded or trace not in concluded[monitor].diagnosis.traces:
            del writer.signals[name]


def pieces(series: SeriesReader, names: Sequence[str], seconds: float) -> Iterator[Recording]:
    """The stored signals as consecutive slices, in the form of `open_chunks`."""
    begin, end = series.span
    count = max(int(np.ceil((end - begin + 1e-9) / seconds)), 1)
    for place in range(count):
        start, stop = begin + place * seconds, begin + (place + 1) * seconds
        piece = series.recording(names, start, np.inf if place == count - 1 else stop)
        if any(len(each.time) for each in piece.channels.values()):
            share = (place + 1) / count
            warnings = tuple(map(str, piece.metadata.get("warnings", ())))
            yield Recording(piece.channels, {**piece.metadata, "warnings": warnings, SHARE_READ: share})


def _write_report(path: Path, diagnosis: Diagnosis) -> None:
    from tierod.report import write_html

    try:
        write_html(diagnosis, path)
    except TierodError as error:
        write_text(path.with_suffix(".txt"), str(error), sweeps=False)


def monitor_document(found: Concluded) -> dict[str, Any]:
    from tierod.report.document import document
    from tierod.report.document import plain as finite

    content: dict[str, Any] = json.loads(document(found.diagnosis, False))
    content["variant"] = found.variant
    content["estimates"] = list(found.estimates)
    names = [field.name for field in dataclasses.fields(Decided) if field.name != "curve"]
    content["decisions"] = [finite({name: getattr(each, name) for name in names}) for each in found.diagnosis.decisions]
    content.pop("recording", None)
    return content


def _written(monitor: str, run: Run, writer: SeriesWriter) -> Kept:
    """Writes the estimates of a monitor piece by piece, each named "monitor/estimate"."""

    def write(time: np.ndarray, shown: Mapping[str, np.ndarray]) -> None:
        stamps = np.array(time, float)
        writer.add(
            Channel(f"{monitor}/{name}", stamps, np.asarray(shown[name], float), unit, f"monitor {monitor}")
            for name, unit in run.session.traces.items()
            if name in shown
        )

    return write
