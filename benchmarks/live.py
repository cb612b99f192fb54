"""Live monitoring: processor share, and memory over a long drive.

python -m benchmarks.live                 processor share of the monitors
python -m benchmarks.live --soak 20       twenty minutes of driving at 5 000 frames/s with 1 000 disturbances, seed 5

Frames are fed to the engine as fast as it accepts them; processor time counts.
"""

from __future__ import annotations

import argparse
import random
import resource
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from live_drives import START, frames_of_drive, messages
from tierod.live.clock import Frame
from tierod.live.engine import PACE, Engine, Pace
from tierod.live.judge import Plan
from tierod.live.log import FrameLog
from tierod.vehicles import load

MONITORS = ("friction", "sideslip", "driver-torque", "condition")
"""Monitors; the last one runs only on a vehicle with the parameters that it needs, such as `smartload`."""
VEHICLE = "midsize-eps"


def padded(drive: list[Frame], rate: float) -> list[Frame]:
    """A drive padded with frames of unknown messages up to a given frame rate [1/s]."""
    seconds = drive[-1].time - drive[0].time
    more = max(int(rate * seconds) - len(drive), 0)
    others = [Frame(drive[0].time + seconds * n / more, 0x600 + n % 40, 1, bytes(8)) for n in range(more)]
    return sorted([*drive, *others], key=lambda frame: frame.time)


def repeated(drive: list[Frame], seconds: float) -> Iterator[Frame]:
    """The drive repeated with continuous time stamps."""
    length, begun = drive[-1].time - drive[0].time + 0.005, 0.0
    while begun < seconds:
        for frame in drive:
            yield frame._replace(time=frame.time + begun)
        begun += length


def disturbed(frames: Iterator[Frame], seed: int, count: int, seconds: float) -> Iterator[Frame]:
    """Frames with about `count` disturbances: lost, duplicated and delayed frames, pauses, and jumps of the clock."""
    chance, added, hold = random.Random(seed), 0.0, None
    due = [START + chance.uniform(5.0, seconds) for _ in range(count)]
    due.sort(reverse=True)
    skip_until = 0.0
    for frame in frames:
        while due and frame.time >= due[-1]:
            due.pop()
            kind = chance.choice(("lost", "doubled", "held", "pause", "jump"))
            if kind == "doubled":
                yield frame._replace(time=frame.time + added)
            elif kind == "held":
                hold = frame
            elif kind == "jump":
                added += chance.choice((-40.0, 3600.0))
            else:
                skip_until = frame.time + (0.05 if kind == "lost" else 2.0)
        if frame.time < skip_until:
            continue
        yield frame._replace(time=frame.time + added)
        if hold is not None and frame.time > hold.time + 0.05:
            yield hold._replace(time=hold.time + added)
            hold = None


def fed(engine: Engine, frames: Iterator[Frame]) -> None:
    """Feed frames to an engine in groups of forty, with the arrival times of the undisturbed drive."""
    part: list[Frame] = []
    came = START
    for frame in frames:
        part.append(frame)
        if len(part) == 40:
            came += 40 / 5000.0
            engine.take(part, came, came)
            part = []
            if engine.due:
                engine.judge()
    if part:
        engine.take(part, came, came)


def used() -> float:
    return time.process_time()


LONG = 2.0  # Judging period of a computer with little to spare [s]

BEGUN = 75.0  # Time of a drive after which all monitors are active; the driver torque monitor waits for a minute [s]


def share(folder: Path, rate: float = 2000.0, seconds: float = 150.0) -> None:
    """Print the processor time of the monitors per second of driving, including decoding and log."""
    drive = padded(frames_of_drive(folder, 30.0), rate)
    making = generated(drive, seconds)
    cases = [(VEHICLE, names, PACE) for names in ((), *((name,) for name in MONITORS[:3]), MONITORS[:3])]
    judged = [("smartload", ("condition",), PACE), ("smartload", ("condition",), Pace(period=LONG))]
    for vehicle, names, pace in [*cases, *judged, (VEHICLE, MONITORS[:3], Pace(period=LONG))]:
        log = FrameLog(folder / "log.mf4", START)
        engine = Engine(messages(folder), None, names, Plan(load(vehicle)), pace=pace, log=log)
        spent = cost(engine, repeated(drive, seconds), 40) - making
        ran = [each.monitor for each in engine.shown() if not each.reason]
        every = f"judged every {pace.period:g} s"
        print(f"{rate:.0f} frames/s, monitors {', '.join(ran) or 'none'}, {every}: {100 * spent:.2f} % of a core")


def cost(engine: Engine, frames: Iterable[Frame], together: int) -> float:
    """Processor time per second of driving, from the time at which all monitors are active.

    Args:
        engine: a new one
        frames: frames of the drive
        together: number of frames fed at a time
    """
    begun, first, last = None, 0.0, 0.0
    part: list[Frame] = []
    for frame in frames:
        part.append(frame)
        last = frame.time
        if len(part) == together:
            engine.take(part, last, last)
            part = []
            if engine.due:
                engine.judge()
            if begun is None and last > START + BEGUN:
                begun, first = used(), last
    return (used() - (begun or 0.0)) / (last - first)


def generated(drive: list[Frame], seconds: float) -> float:
    """Processor time of generating the frames per second of driving, which is not part of the engine."""
    begun = used()
    for _ in repeated(drive, seconds):
        pass
    return (used() - begun) / seconds


def resident() -> int:
    """Resident memory of this process [kB]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() // 1024


def soak(folder: Path, minutes: float, rate: float = 5000.0, seed: int = 5) -> None:
    """Print counts of a long drive with disturbances, and the growth of memory."""
    drive = padded(frames_of_drive(folder, 30.0), rate)
    seconds = 60.0 * minutes
    engine = Engine(messages(folder), None, ("friction", "sideslip"), Plan(load(VEHICLE)))
    sizes: list[int] = []
    count = 0

    def counted() -> Iterator[Frame]:
        nonlocal count
        for frame in disturbed(repeated(drive, seconds), seed, int(50 * minutes), seconds):
            count += 1
            if count % 100_000 == 0:
                sizes.append(resident())
            yield frame

    fed(engine, counted())
    found = engine.finish()
    print(f"{minutes:g} min, seed {seed}: {engine.tally.frames} frames of {count}, jumps {engine.clock.jumps}, "
          f"late {engine.clock.late}, too late {engine.tally.too_late}, doubled {engine.clock.doubled}, "
          f"lost {engine.gaps.lost}")  # fmt: skip
    print("verdicts: " + ", ".join(f"{judge.name} {each.findings[0].status}" for judge, each, _ in found))
    # Before that the spread of parameters is computed and buffers for the first minutes fill.
    settled = sizes[int(0.35 * len(sizes)) :] or [resident()]
    change = 100.0 * (max(settled) - settled[0]) / settled[0]
    print(f"memory: {settled[0] / 1024:.0f} MB after 35 % of the time, {max(settled) / 1024:.0f} MB at the most then "
          f"({change:+.1f} %), {resident() / 1024:.0f} MB with the conclusion at the end")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--soak", type=float, default=0.0, help="minutes of a drive with disturbances")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        if chosen.soak:
            soak(Path(name), chosen.soak)
        else:
            share(Path(name))


if __name__ == "__main__":
    main()
