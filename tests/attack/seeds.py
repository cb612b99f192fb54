"""A small valid example of each format that tierod reads, and of each file that a user writes: what is mutated.

Made by code with the writers and the vendors' own libraries; the same bytes on every day, so that a case can be
replayed.
"""

from __future__ import annotations

import gzip
import io
import re
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from foreign_files import feather_file, hdf5_file, mcap_file, ros_bag
from tierod.core.recording import Channel, Recording

ROWS = 120
START = 1_700_000_000.0

SIGNALS = {
    "driver_torque": ("N*m", 3.0),
    "motor_torque": ("N*m", 2.0),
    "steering_wheel_angle": ("rad", 0.6),
    "steering_wheel_rate": ("rad/s", 1.1),
    "yaw_rate": ("rad/s", 0.1),
    "lateral_acceleration": ("m/s**2", 2.0),
    "vehicle_speed": ("m/s", 4.0),
}

DRIVE_MAP = """\
title = "The drive beside which maps are tried"

[signals.driver_torque]
source = "driver_torque"
unit = "N*m"
sign = -1
note = "positive to the right"

[signals.steering_wheel_angle]
source = ["steering_wheel_angle", "yaw_rate"]
factor = 2.0
offset = 1
unit = "deg"

[signals.vehicle_speed]
source = "vehicle_speed"
unit = "km/h"
optional = true
"""


def drive(rows: int = ROWS, rate: float = 50.0) -> Recording:
    """A few seconds of a weave at 15 m/s."""
    time = np.arange(rows) / rate
    channels = {}
    for number, (name, (unit, size)) in enumerate(SIGNALS.items()):
        values = np.round(size * np.sin(2.0 * time - 0.2 * number), 4) + (15.0 if name == "vehicle_speed" else 0.0)
        channels[name] = Channel(name, time, values, unit, "weave", "made for the attack")
    return Recording(channels, {"origin": START, "title": "seed"})


def _written(name: str, write: Callable[[Path], object]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        write(path)
        return path.read_bytes()


def csv_files() -> dict[str, bytes]:
    """tierod's own layout, and layouts of vendors: units in a row of their own, decimal commas, dates, milliseconds."""
    from tierod.io.writers import write

    whole = drive()
    names, time = list(whole.names), whole["yaw_rate"].time
    rows = [[f"{whole[name].values[k]:.4f}" for name in names] for k in range(0, len(time), 2)]
    clock = [f"{each:.3f}" for each in time[::2]]
    units = [SIGNALS[name][0] for name in names]
    semicolon = [";".join(["Zeit", *names]), ";".join(["s", *units])]
    semicolon += [";".join([stamp, *row]).replace(".", ",") for stamp, row in zip(clock, rows, strict=True)]
    dated = [",".join(["date", *(f"{name} [{unit}]" for name, unit in zip(names, units, strict=True))])]
    dated += [",".join([f"2026-11-21T09:00:{float(t):06.3f}", *row]) for t, row in zip(clock, rows, strict=True)]
    tabs = [
        "#exported",
        "\t".join(["timestamp_ms", *(f"{name} ({unit})" for name, unit in zip(names, units, strict=True))]),
    ]
    tabs += ["\t".join([f"{1000 * float(t):.0f}", *row]) for t, row in zip(clock, rows, strict=True)]
    texts = {"vendor.csv": semicolon, "dated.csv": dated, "tabs.txt": tabs}
    found = {name: ("\n".join(lines) + "\n").encode("latin-1") for name, lines in texts.items()}
    return {"own.csv": _written("own.csv", lambda path: write(whole, path)), **found}


def packed_files() -> dict[str, bytes]:
    """The text tables and a CAN log, as gzip."""
    texts = {**csv_files(), **candump_files()}
    return {f"{name}.gz": gzip.compress(content, mtime=0) for name, content in texts.items()}


def parquet_files() -> dict[str, bytes]:
    """tierod's own layout, and a table of pandas' kind."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    from tierod.io.writers import write

    whole = drive()
    columns = {"time": whole["yaw_rate"].time, **{name: whole[name].values for name in whole.names}}
    table = pa.table(columns)
    return {
        "own.parquet": _written("own.parquet", lambda path: write(whole, path)),
        "table.parquet": _written("table.parquet", lambda path: pq.write_table(table, path, compression="snappy")),
        "plain.parquet": _written(
            "plain.parquet", lambda path: pq.write_table(table, path, compression="none", use_dictionary=False)
        ),
    }


def mf4_files() -> dict[str, bytes]:
    """tierod's own MF4, one whose data are packed, and an old MDF 3."""
    import asammdf

    from tierod.io.writers import write

    whole = drive()

    def save(path: Path, version: str, compression: int) -> None:
        file = asammdf.MDF(version=version)
        time = whole["yaw_rate"].time
        signals = [asammdf.Signal(whole[n].values, time, name=n, unit=whole[n].unit) for n in whole.names]
        file.append(signals[:4], common_timebase=True)
        file.append(signals[4:], common_timebase=True)
        file.header.start_time = _start()
        saved = Path(file.save(path, compression=compression, overwrite=True))
        file.close()
        if saved != path:
            saved.replace(path)

    return {
        "own.mf4": _undated(_written("own.mf4", lambda path: write(whole, path))),
        "packed.mf4": _undated(_written("packed.mf4", lambda path: save(path, "4.10", 2))),
        "old.mdf": _undated(_written("old.mdf", lambda path: save(path, "3.30", 0))),
    }


def bus_files() -> dict[str, bytes]:
    """An MF4 bus log of four messages."""
    import asammdf

    frames = list(_frames())
    kind = np.dtype(
        [
            ("CAN_DataFrame.BusChannel", "u1"),
            ("CAN_DataFrame.ID", "<u4"),
            ("CAN_DataFrame.IDE", "u1"),
            ("CAN_DataFrame.DLC", "u1"),
            ("CAN_DataFrame.DataLength", "u1"),
            ("CAN_DataFrame.DataBytes", "(8,)u1"),
        ]
    )
    values = np.zeros(len(frames), dtype=kind)
    for place, (_, identifier, data) in enumerate(frames):
        values[place] = (1, identifier, 0, len(data), len(data), np.frombuffer(data.ljust(8, b"\0"), dtype="u1"))
    time = np.array([frame[0] for frame in frames])

    def save(path: Path) -> None:
        source = asammdf.Source("CAN", "CAN", "bus", 2, 2)
        signal = asammdf.Signal(values, time, name="CAN_DataFrame", source=source)
        file = asammdf.MDF(version="4.10")
        file.append(signal, acq_source=source)
        file.groups[-1].channel_group.flags = 6
        file.header.start_time = _start()
        saved = Path(file.save(path, overwrite=True))
        file.close()
        if saved != path:
            saved.replace(path)

    return {"bus.mf4": _undated(_written("bus.mf4", save))}


def _start() -> object:
    import datetime

    return datetime.datetime.fromtimestamp(START, datetime.UTC)


def _undated(content: bytes) -> bytes:
    """An MDF file whose history does not say when it was written."""
    found = bytearray(re.sub(rb"\w{3} \w{3} .. [\d:]{8} \d{4}: updated", b"Thu Jan 01 00:00:00 2026: updated", content))
    place = found.find(b"##FH")
    while place >= 0:
        found[place + 40 : place + 48] = bytes(8)
        place = found.find(b"##FH", place + 4)
    return bytes(found)


def mat_files() -> dict[str, bytes]:
    """Vectors beside a time, plain and packed, and a structure with its period."""
    import scipy.io

    whole = drive()
    vectors = {"t": whole["yaw_rate"].time, **{name: whole[name].values for name in whole.names}}

    def made(content: dict, packed: bool) -> bytes:
        stream = io.BytesIO()
        scipy.io.savemat(stream, content, do_compression=packed)
        return b"MATLAB 5.0 MAT-file, made for the attack".ljust(116) + stream.getvalue()[116:]

    log = {"Ts": 0.02, **{name: whole[name].values for name in whole.names}}
    return {
        "vectors.mat": made(vectors, False),
        "packed.mat": made(vectors, True),
        "log.mat": made({"log": log}, False),
    }


def hdf5_files() -> dict[str, bytes]:
    """As MATLAB 7.3 writes it, and plain."""
    return {
        "plain.h5": _written("plain.h5", hdf5_file),
        "new.mat": _written("new.mat", lambda path: hdf5_file(path, True)),
    }


def arrow_files() -> dict[str, bytes]:
    """A file and a stream."""
    return {
        "drive.feather": _written("drive.feather", feather_file),
        "drive.arrows": _written("drive.arrows", lambda path: feather_file(path, True)),
    }


def mcap_files() -> dict[str, bytes]:
    """Of another program, and tierod's own."""
    from tierod.io.writers import write

    return {
        "state.mcap": _written("state.mcap", mcap_file),
        "own.mcap": _written("own.mcap", lambda path: write(drive(), path)),
    }


def _database() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        return next(ros_bag(Path(folder) / "bag", False).glob("*.db3")).read_bytes()


def _frames() -> list[tuple[float, int, bytes]]:
    """(time [s], identifier, payload) of four messages of the database that is shipped for one car."""
    found = []
    for number in range(ROWS // 2):
        for place, identifier in enumerate((36, 37, 170, 608)):
            data = bytes((7 * number + 31 * place + 3 * byte) % 256 for byte in range(8))
            found.append((START + 0.02 * number + 0.001 * place, identifier, data))
    return found


def candump_files() -> dict[str, bytes]:
    """The text of `candump -L`."""
    lines = [f"({time:.6f}) can0 {identifier:03X}#{data.hex().upper()}" for time, identifier, data in _frames()]
    return {"bus.log": ("\n".join(lines) + "\n").encode()}


def vendor_files(kind: str) -> dict[str, bytes]:
    """A log of python-can: "asc", "blf" or "trc"."""
    import can

    writers = {"asc": can.ASCWriter, "blf": can.BLFWriter, "trc": can.TRCWriter}

    def save(path: Path) -> None:
        with writers[kind](path) as log:
            for time, identifier, data in _frames():
                log.on_message_received(
                    can.Message(timestamp=time, arbitration_id=identifier, data=data, channel=1, is_extended_id=False)
                )

    content = _written(f"bus.{kind}", save)
    if kind == "asc":
        content = re.sub(rb"^date [^\n]*", b"date Tue Nov 14 22:13:20.0 2023", content)
    if kind == "trc":
        content = re.sub(rb";   /[^\n]*", b";   bus.trc", content)
    return {f"bus.{kind}": content}


def user_files() -> dict[str, dict[str, bytes]]:
    """Of each kind of file that a user writes or keeps, by name of the target."""
    from tierod.monitors.baseline import Baseline, store_baseline

    package, lab = (Path(__import__(each).__file__).parent for each in ("tierod", "tierod_lab"))
    shipped = {
        "vehicle": ("vehicles", ("midsize-eps.toml", "smartload.toml")),
        "channel-map": ("vehicles", ("rav4.channels.toml",)),
        "scenario": ("ground/scenarios", ("step-steer.toml", "slalom-winter-tyres.toml", "hands-off.toml")),
        "campaign": ("campaign", ("friction-steps.toml", "friction-baseline.toml")),
        "fault": ("ground/faults/shipped", ("friction-step.toml", "yaw-rate-delay.toml", "motor-hot.toml")),
        "dbc": ("vehicles", ("rav4.dbc",)),
    }
    found = {
        target: {name: ((package if folder == "vehicles" else lab) / folder / name).read_bytes() for name in names}
        for target, (folder, names) in shipped.items()
    }
    found["channel-map"]["drive.channels.toml"] = DRIVE_MAP.encode()
    level = Baseline("midsize-eps", "friction, pre-sliding", 4.05, 0.15, "N*m", 1310.0, "2026-11-21T10:00:00+00:00")
    found["baseline"] = {"level.json": _written("level.json", lambda path: store_baseline(level, path))}
    found["fault-memory"] = {"memory.json": _written("memory.json", _memory)}
    return found


def _memory(path: Path) -> None:
    """A memory of two drives: three codes failed in the first, one of them in the second."""
    from tierod.diagnosis.fault_memory import FaultMemory

    memory = FaultMemory.opened(path, "midsize-eps")
    names, time = list(memory.entries)[:3], np.arange(0.0, 20.0, 0.5)
    signals = {"vehicle_speed": np.full(len(time), 15.0), "driver_torque": np.sin(time)}
    for day, failing in (("2026-11-20", names), ("2026-11-21", names[:1])):
        memory.begin_cycle(f"{day}T10:00:00+00:00")
        memory.absorb(time, {name: np.where(time > 5.0, 1.0, -1.0) for name in failing}, signals)
        memory.end_cycle()


@cache
def seeds() -> dict[str, dict[str, bytes]]:
    """Every example, by target and file name."""
    found = {
        "csv": csv_files(),
        "packed-csv": packed_files(),
        "parquet": parquet_files(),
        "mf4": mf4_files(),
        "mf4-bus": bus_files(),
        "mat": mat_files(),
        "candump": candump_files(),
        "hdf5": hdf5_files(),
        "arrow": arrow_files(),
        "mcap": mcap_files(),
        "ros1": {"drive.bag": _written("drive.bag", lambda path: ros_bag(path, True))},
        "ros2": {"drive.db3": _database()},
        "asc": vendor_files("asc"),
        "blf": vendor_files("blf"),
        "trc": vendor_files("trc"),
    }
    return {**found, **user_files()}


def drive_file() -> bytes:
    """The recording beside which user files are judged."""
    return seeds()["csv"]["own.csv"]
