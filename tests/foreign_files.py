"""Recordings written by other libraries than ours: bags, MCAP, HDF5, Feather, CarMaker."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np

COUNT = 300
START = 1_700_000_000
TIME = np.arange(COUNT) / 100.0
YAW = 0.3 * np.sin(TIME)
SPEED = 15.0 + np.cos(TIME)


def mcap_file(path: Path, count: int = COUNT, finish: bool = True) -> Path:
    """Two JSON topics, and one in an encoding that is not read."""
    from mcap.writer import CompressionType, Writer

    with path.open("wb") as file:
        writer = Writer(file, chunk_size=2000, compression=CompressionType.ZSTD)
        writer.start()
        plain = writer.register_schema("state", "jsonschema", b'{"type": "object"}')
        odd = writer.register_schema("odd", "flatbuffer", b"\x00")
        one = writer.register_channel("/state", "json", plain)
        two = writer.register_channel("/odd", "flatbuffer", odd)
        for place in range(count):
            stamp = START * 10**9 + place * 10_000_000
            text = json.dumps({"yaw_rate": YAW[place], "wheel": {"speeds": [SPEED[place], place]}, "name": "x"})
            writer.add_message(one, stamp, text.encode(), stamp)
            writer.add_message(two, stamp, b"\x01", stamp)
        if finish:
            writer.finish()
    return path


def ros_bag(path: Path, first: bool) -> Path:
    """A bag of IMU messages by rosbags, of ROS 1 (a file) or ROS 2 (a folder)."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if first else Stores.ROS2_HUMBLE)
    kinds = store.types
    kind = "geometry_msgs/msg/Vector3Stamped"
    writer = _ros_writer(path, first)
    with writer:
        link = writer.add_connection("/imu/rate", kind, typestore=store)
        for place in range(COUNT):
            seconds, rest = START + place // 100, place % 100 * 10_000_000
            stamp = kinds["builtin_interfaces/msg/Time"](seconds, rest)
            fields = {"stamp": stamp, "frame_id": "base"} | ({"seq": place} if first else {})
            header = kinds["std_msgs/msg/Header"](**fields)
            message = kinds[kind](header, kinds["geometry_msgs/msg/Vector3"](0.0, float(place), YAW[place]))
            data = store.serialize_ros1(message, kind) if first else store.serialize_cdr(message, kind)
            writer.write(link, (START * 10**9) + place * 10_000_000 + 2_000_000, data)
    return path


def _ros_writer(path: Path, first: bool):
    if first:
        from rosbags.rosbag1 import Writer as First

        return First(path)
    from rosbags.rosbag2 import Writer as Second

    return Second(path, version=9)


def hdf5_file(path: Path, matlab: bool = False) -> Path:
    """Two groups with a time each; as MATLAB 7.3 writes them where asked for."""
    import h5py

    with h5py.File(path, "w", userblock_size=512 if matlab else 0) as file:
        for name, rate in (("fast", 100.0), ("slow", 10.0)):
            group = file.create_group(name)
            count = int(COUNT * rate / 100.0)
            shape = (1, count) if matlab else (count,)
            group["time"] = (np.arange(count) / rate).reshape(shape)
            group["yaw_rate" if name == "fast" else "vehicle_speed"] = (YAW if name == "fast" else SPEED)[
                :: int(100 / rate)
            ].reshape(shape)
            group["time"].attrs["units"] = "s"
        file["fast/yaw_rate"].attrs["units"] = "rad/s"
        file["slow/vehicle_speed"].attrs["units"] = "m/s"
        file["text"] = "a note"
        if matlab:
            for item in (file["fast/time"], file["fast/yaw_rate"]):
                item.attrs["MATLAB_class"] = np.bytes_("double")
    if matlab:
        with path.open("r+b") as raw:
            raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")
    return path


def feather_file(path: Path, stream: bool = False) -> Path:
    """A table with a calendar time, in batches."""
    import pyarrow as pa

    stamps = pa.array((START * 10**6 + TIME * 1e6).astype("int64"), pa.timestamp("us"))
    table = pa.table({"timestamp": stamps, "yaw_rate": YAW, "vehicle_speed": SPEED})
    kind = pa.ipc.new_stream if stream else pa.ipc.new_file
    with pa.OSFile(str(path), "wb") as file, kind(file, table.schema) as writer:
        writer.write_table(table, max_chunksize=64)
    return path


def erg_file(path: Path) -> Path:
    """A result of CarMaker: time, a float with its unit, a padding, an integer."""
    row = struct.Struct("<dfi4s")
    rows = b"".join(row.pack(TIME[place], YAW[place], place, b"") for place in range(COUNT))
    path.write_bytes(b"CM-ERG\0\0" + struct.pack("<BBHI", 1, 0, row.size, 0) + rows)
    names = (
        ("Time", "Double", "s"),
        ("Car.YawRate", "Float", "rad/s"),
        ("Car.Gear", "Int", "-"),
        ("$none$", "4 Bytes", ""),
    )
    lines = ["File.Format = erg", "File.ByteOrder = LittleEndian", f"File.DateInSeconds = {START}"]
    for number, (name, kind, unit) in enumerate(names, 1):
        lines += [f"File.At.{number}.Name = {name}", f"File.At.{number}.Type = {kind}"]
        lines += [f"Quantity.{name}.Unit = {unit}"] if unit else []
        lines.append("")
    path.with_name(path.name + ".info").write_text("\n".join(lines))
    return path
