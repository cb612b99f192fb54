"""The process behind the live view: follows buses like `tierod live`, and prints events and samples as JSON lines.

python -m tierod.web.following --vehicle car.toml --dbc car.dbc --live udp_multicast:239.74.163.2
"""

from __future__ import annotations

import argparse
import contextlib
import os
import queue
import signal
import sys
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from tierod.core.errors import InputError, ParameterError, TierodError
from tierod.core.signals import SIGNALS
from tierod.io.readers.channel_map import ChannelMap
from tierod.io.readers.mapping import Plan as Mapping_
from tierod.io.readers.mapping import plan as mapping
from tierod.io.readers.reading import Doubts, made_from
from tierod.live.clock import Frame, frames_of
from tierod.live.decoding import Decoder, bus_files
from tierod.live.drive import Drive
from tierod.live.events import Hub, line
from tierod.live.judge import Plan
from tierod.live.outputs import Outputs
from tierod.monitors.runner import usual

PERIOD = 0.05  # Time between two lines with samples [s]

MOST_SIGNALS = 64  # Largest number of signals whose samples are sent; signals of the catalogue come first


class Samples:
    """Decodes frames as they arrive into samples of all signals, for one line every `PERIOD`.

    Args:
        channel_map: channel map of the vehicle; None assigns signals by their names
    """

    def __init__(self, database: Sequence[Any], channel_map: ChannelMap | None):
        self._decoder, self._map = Decoder(database), channel_map
        self._plan: Mapping_ | None = None
        self._version = -1
        self._doubts = Doubts()
        self._waiting: list[Frame] = []

    def heard(self, frames: Sequence[Frame]) -> None:
        """Take frames with their times in the drive."""
        self._waiting += frames

    def content(self) -> dict[str, Any] | None:
        """Samples since the last call; None if there are none."""
        frames, self._waiting = self._waiting, []
        if not frames:
            return None
        whole = frames_of(frames, 0.0)
        self._decoder.hear(whole)
        known = self._decoder.known
        if known is None:
            return None
        if self._plan is None or self._version != self._decoder.version:
            self._plan = mapping(known.columns, self._map, None, known.silent)
            self._version = self._decoder.version
        channels = made_from(self._plan, self._decoder.channels(whole, self._plan.columns), self._doubts)
        channels = sorted((each for each in channels if len(each.time)), key=lambda each: each.name not in SIGNALS)
        return {
            each.name: {"unit": each.unit, "time": np.round(each.time, 4).tolist(), "values": each.values.tolist()}
            for each in channels[:MOST_SIGNALS]
        }


def follow(drive: Drive, samples: Samples) -> int:
    last, used, server = [0.0], [time.monotonic(), time.process_time()], os.getppid()

    def look(now: float) -> None:
        # In every tick, since a new drive has a new engine.
        drive.engine.heard = samples.heard
        if now - last[0] < PERIOD:
            return
        last[0] = now
        # A killed server cannot end this process, and with a silent bus no write fails.
        drive.ended |= os.getppid() != server
        try:
            content = samples.content()
        except TierodError as error:
            drive.hub.say("problem", {"text": str(error)})
            return
        if content:
            drive.hub.say("samples", {"sent": time.time(), "signals": content})

    def said(text: str) -> None:
        if '"event": "state"' in text:
            now, spent = time.monotonic(), time.process_time()
            load = (spent - used[1]) / max(now - used[0], 1e-3)
            used[:] = [now, spent]
            text = f'{text[:-1]}, "load": {load:.3f}}}'
        print(text, flush=True)

    drive.engine.heard = samples.heard
    drive.looking.append(look)
    drive.hub.add(said)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: setattr(drive, "ended", True))
    return drive.run()


def drive_of(vehicle: str, live: Sequence[str], dbc: Sequence[str], channel_map: str) -> tuple[Drive, Samples]:
    """A drive that follows buses with every monitor that can run, and the decoder of its samples."""
    from tierod.live.buses import Address, receiver
    from tierod.vehicles import load

    car = load(vehicle)
    files = bus_files(car, dbc, channel_map or None)
    names = [each.monitor for each in usual()]
    inbox: Any = queue.SimpleQueue()
    buses = [Address(interface, channel) for interface, _, channel in (each.partition(":") for each in live)]
    receivers = [receiver(number, each, inbox) for number, each in enumerate(buses, 1)]
    drive = Drive(receivers, inbox, files.database, files.channel_map, names, Plan(car), Outputs(), Hub())
    return drive, Samples(files.database, files.channel_map)


def main() -> int:
    """Follow the buses given on the command line, until SIGTERM or until its output is closed."""
    parser = argparse.ArgumentParser(prog="tierod.web.following")
    parser.add_argument("--vehicle", required=True)
    parser.add_argument("--live", action="append", default=[])
    parser.add_argument("--dbc", action="append", default=[])
    parser.add_argument("--map", default="")
    given = parser.parse_args()
    try:
        return follow(*drive_of(given.vehicle, given.live, given.dbc, given.map))
    except BrokenPipeError:
        return 0
    except (InputError, ParameterError, TierodError) as error:
        with contextlib.suppress(BrokenPipeError):
            print(line("problem", {"text": f"{error}; end the server and start it again"}), flush=True)
        return 3


if __name__ == "__main__":
    sys.exit(main())
