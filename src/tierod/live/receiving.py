"""Receiving in a process of its own, which judging cannot hold up; frames come in batches through a pipe."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import Any

from tierod.core.errors import InputError, ParameterError, TierodError
from tierod.live.buses import Address, Inbox, Receiver
from tierod.live.frame import Frame, Notice

MOST, SECONDS = 25_000, 0.005
"""Frames of a batch at the most, and time after which one is sent [s]."""

PATIENCE = 20.0
"""Time that the bus may take to open [s]."""


class ProcessReceiver:
    """Receives one bus in a process that ends with this one.

    Args:
        number: of the bus, from 1
        address: where it is
        inbox: takes frames and notices

    Raises:
        InputError: the bus cannot be opened
        ParameterError: there is no such interface
    """

    def __init__(self, number: int, address: Address, inbox: Inbox):
        self._inbox = inbox
        reading, writing = os.pipe()
        said = {"number": number, **vars(address), "options": dict(address.options)}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tierod.live.receiving", str(writing), json.dumps(said)],
            pass_fds=(writing,),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(writing)
        self._pipe: Connection[Any, Any] = Connection(reading, writable=False)
        self._thread = threading.Thread(target=self._pump, daemon=True)
        try:
            opened = self._pipe.recv() if self._pipe.poll(PATIENCE) else ("InputError", "it gives no answer")
        except (EOFError, OSError):
            opened = ("InputError", f"the receiver of bus {number} ended at once; check the driver of the interface")
        if opened is not None:
            self.end()
            kind, text = opened
            raise (ParameterError if kind == "ParameterError" else InputError)(text)

    def start(self) -> None:
        """Begin to fill the inbox."""
        self._thread.start()

    def _pump(self) -> None:
        with contextlib.suppress(EOFError, OSError):
            while True:
                for each in self._pipe.recv():
                    self._inbox.put(each)

    def end(self) -> None:
        """End the process."""
        self._process.terminate()
        try:
            self._process.wait(2.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._thread.is_alive():
            self._thread.join(2.0)


def receiver(number: int, address: Address, inbox: Inbox) -> Receiver | ProcessReceiver:
    """Receiver of a bus: a process, or a thread where the bus lives in this process alone, or pipes cannot be passed.

    Args:
        number, address, inbox: as of `Receiver`
    """
    alone = address.interface == "virtual" or os.name != "posix"
    return Receiver(number, address, inbox) if alone else ProcessReceiver(number, address, inbox)


def main() -> None:
    """Receive until the other end of the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    pipe: Connection[Any, Any] = Connection(int(sys.argv[1]), readable=False)
    said = json.loads(sys.argv[2])
    number = said.pop("number")
    inbox: Inbox = SimpleQueue()
    try:
        thread = Receiver(number, Address(**said), inbox)
    except TierodError as error:
        pipe.send((type(error).__name__, str(error)))
        return
    pipe.send(None)
    thread.start()
    with contextlib.suppress(BrokenPipeError):
        while True:
            time.sleep(SECONDS)
            pipe.send(_batch(inbox))


def _batch(inbox: Inbox) -> list[Frame | Notice]:
    found: list[Frame | Notice] = []
    while not inbox.empty() and len(found) < MOST:
        found.append(inbox.get())
    return found


if __name__ == "__main__":
    main()
