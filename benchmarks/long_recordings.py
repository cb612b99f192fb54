"""Peak memory of `diagnose` on ten hours of driving at 100 Hz, in every format: `python -m benchmarks.long_recordings`.

Memory is the sum of the peak resident sets of the process and its children, which is an upper bound.
"""

from __future__ import annotations

import argparse
import contextlib
import gzip
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

RATE = 100.0
HOURS = 10.0
TARGET_MB = 350.0

SIGNALS = {
    "steering_wheel_angle": "rad",
    "steering_wheel_rate": "rad/s",
    "driver_torque": "N*m",
    "motor_torque": "N*m",
    "yaw_rate": "rad/s",
    "vehicle_speed": "m/s",
    "lateral_acceleration": "m/s**2",
}

FORMATS = ("parquet", "csv", "csv.gz", "mf4", "log", "log.gz", "mat")

_STEP = 36_000  # Samples generated at a time

_SCALE = 1e-3  # Physical value of one bit in a CAN signal

_MESSAGES = (tuple(SIGNALS)[:4], tuple(SIGNALS)[4:])


def main() -> int:
    """Generate missing recordings, diagnose each, and print the table; returns 1 if the memory target is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("formats", nargs="*", default=FORMATS)
    parser.add_argument("--hours", type=float, default=HOURS)
    parser.add_argument("--folder", type=Path, help="where the recordings lie and are kept; a temporary one if absent")
    arguments = parser.parse_args()
    most = 0.0
    with contextlib.ExitStack() as stack:
        folder = arguments.folder or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        (folder / "bus.dbc").write_text(database())
        print(f"{'format':10} {'file [MB]':>10} {'time [s]':>9} {'peak memory [MB]':>17} {'exit':>5}")
        for ending in arguments.formats:
            path = folder / f"ten-hours.{ending}"
            if not path.exists():
                # In a separate process, because the peak memory of a child process starts from that of its parent.
                made = subprocess.run([sys.executable, "-c", _MAKE, str(path), str(arguments.hours)], check=False)
                if made.returncode:
                    raise RuntimeError(f"{path} could not be made")
            seconds, memory, code = measured(path, folder / "bus.dbc")
            print(f"{ending:10} {path.stat().st_size / 1e6:10.1f} {seconds:9.1f} {memory:17.0f} {code:5}", flush=True)
            most = max(most, memory)
    return int(most > TARGET_MB)


_MAKE = """
import sys
from pathlib import Path
from benchmarks.long_recordings import make
make(Path(sys.argv[1]), float(sys.argv[2]))
"""


def measured(path: Path, dbc: Path) -> tuple[float, float, int]:
    """Elapsed time [s], peak memory of the process and its children [MB], and exit code for one file."""
    command = [sys.executable, "-m", "tierod", "diagnose", str(path), "--vehicle", "midsize-eps", "--no-report"]
    command += ["--dbc", str(dbc)] if path.name.split(".")[1] == "log" else []
    begin = time.perf_counter()
    peaks: dict[int, float] = {}
    with subprocess.Popen(command, cwd=path.parent, stdout=subprocess.DEVNULL) as process:
        while process.poll() is None:
            for each in _family(process.pid):
                peaks[each] = max(peaks.get(each, 0.0), _largest(each))
            time.sleep(0.02)
    return time.perf_counter() - begin, sum(peaks.values()), process.returncode


def _family(pid: int) -> list[int]:
    """Process numbers of a process and all its descendants."""
    with contextlib.suppress(OSError):
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        return [pid, *(each for child in children for each in _family(int(child)))]
    return [pid]


def _largest(pid: int) -> float:
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{pid}/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return float(line.split()[1]) / 1024.0
    return 0.0


def signals(hours: float) -> Iterator[tuple[np.ndarray, dict[str, np.ndarray]]]:
    """Time [s] and signals of a synthetic drive, piece by piece: sines and noise without vehicle dynamics."""
    chance = np.random.default_rng(1)
    count = round(hours * 3600.0 * RATE)
    for begin in range(0, count, _STEP):
        time_ = np.arange(begin, min(begin + _STEP, count)) / RATE
        angle = 0.6 * np.sin(0.7 * time_) + 0.3 * np.sin(0.13 * time_)
        rate = 0.42 * np.cos(0.7 * time_) + 0.039 * np.cos(0.13 * time_)
        speed = 20.0 + 4.0 * np.sin(0.01 * time_)
        yaw = angle / 16.0 * speed / 3.0
        torque = 2.0 * angle + np.sign(rate)
        columns = (angle, rate, 0.3 * torque, 0.7 * torque, yaw, speed, yaw * speed)
        noise = 0.01 * chance.normal(size=(len(columns), len(time_)))
        quantised = (np.round((column + each) / _SCALE) * _SCALE for column, each in zip(columns, noise, strict=True))
        yield time_, dict(zip(SIGNALS, quantised, strict=True))


def make(path: Path, hours: float = HOURS) -> None:
    """Write the drive in the format of the file's suffix, in pieces where the format permits."""
    ending = path.name.split(".", 1)[1]
    maker = _text if ending.startswith(("csv", "log")) else _whole
    temporary = path.with_name(f"part-{path.name}")
    maker(temporary, ending, hours)
    os.replace(temporary, path)


def database() -> str:
    """DBC of the synthetic bus."""
    text = 'VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: A\n\n'
    for number, names in enumerate(_MESSAGES):
        text += f"BO_ {256 + number} M{number}: 8 A\n"
        for place, name in enumerate(names):
            text += f' SG_ {name} : {16 * place}|16@1- ({_SCALE},0) [0|0] "{SIGNALS[name].replace("**", "^")}" A\n'
    return text


def _frames(columns: dict[str, np.ndarray]) -> list[np.ndarray]:
    """Payloads of the messages, (n, 8) each."""
    payloads = []
    for names in _MESSAGES:
        words = np.zeros((len(columns[names[0]]), 4), dtype="<i2")
        for place, name in enumerate(names):
            words[:, place] = np.round(columns[name] / _SCALE)
        payloads.append(words.view(np.uint8))
    return payloads


def _text(path: Path, ending: str, hours: float) -> None:
    with gzip.open(path, "wt", compresslevel=1) if ending.endswith("gz") else path.open("w") as file:
        if ending.startswith("csv"):
            file.write(",".join(["time [s]", *(f"{name} [{unit}]" for name, unit in SIGNALS.items())]) + "\n")
        for time_, columns in signals(hours):
            if ending.startswith("csv"):
                rows = zip(time_.tolist(), *(column.tolist() for column in columns.values()), strict=True)
                file.write("".join(f"{row[0]:.2f},{','.join(f'{value:.3f}' for value in row[1:])}\n" for row in rows))
                continue
            texts = [[bytes(row).hex().upper() for row in part] for part in _frames(columns)]
            for stamp, *payloads in zip(time_.tolist(), *texts, strict=True):
                for number, payload in enumerate(payloads):
                    file.write(f"({1.7e9 + stamp + 1e-4 * number:.6f}) can0 {0x100 + number:03X}#{payload}\n")


def _whole(path: Path, ending: str, hours: float) -> None:
    from tierod.core.recording import Channel, Recording
    from tierod.io.writers import write

    pieces = list(signals(hours))
    time_ = np.concatenate([stamps for stamps, _ in pieces])
    columns = {name: np.concatenate([part[name] for _, part in pieces]) for name in SIGNALS}
    if ending == "mat":
        from scipy.io import savemat

        savemat(path, {"t": time_, **columns}, appendmat=False, do_compression=True)
        return
    channels = {name: Channel(name, time_, values, SIGNALS[name]) for name, values in columns.items()}
    temporary = path.with_suffix(f".made.{ending}")
    write(Recording(channels), temporary)
    os.replace(temporary, path)


if __name__ == "__main__":
    sys.exit(main())
