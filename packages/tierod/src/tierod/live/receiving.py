"""Receiving in a separate process, which judging cannot delay; frames arrive in batches through a pipe."""

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
from tierod.core.processes import interpreter
from tierod.live.buses import Address, Inbox, Receiver
from tierod.live.frame import Frame, Notice

MOST, SECONDS = 25_000, 0.005
"""Largest number of frames in a batch, and period of the batches [s]."""

PATIENCE = 20.0
"""Time allowed for the bus to open [s]."""


class ProcessReceiver:
    """Receives one bus in a child process, which ends with this one.

    Args:
        number: number of the bus, from 1

    Raises:
        InputError: the bus cannot be opened
        ParameterError: there is no such interface
    """

    def __init__(self, number: int, address: Address, inbox: Inbox):
        self._inbox = inbox
        reading, writing = os.pipe()
        said = {"number": number, **vars(address), "options": dict(address.options)}
        self._process = subprocess.Popen(
            interpreter("-m", "tierod.live.receiving", str(writing), json.dumps(said)),
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
        """Start to fill the inbox."""
        self._thread.start()

    def _pump(self) -> None:
        with contextlib.suppress(EOFError, OSError):
            while True:
                for each in self._pipe.recv():
                    self._inbox.put(each)

    def end(self) -> None:
        """End the process, by force if it does not end within two seconds."""
        self._process.terminate()
        try:
            self._process.wait(2.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._thread.is_alive():
            self._thread.join(2.0)


def receiver(number: int, address: Address, inbox: Inbox) -> Receiver | ProcessReceiver:
    """Receiver of a bus: a process, or a thread where the bus is in this process or pipes cannot be inherited."""
    alone = address.interface == "virtual" or os.name != "posix"
    return Receiver(number, address, inbox) if alone else ProcessReceiver(number, address, inbox)


def main() -> None:
    """Entry point of the process: receive until the other end of the pipe is closed."""
    # Ctrl-C reaches the whole process group; the parent alone decides when receiving ends.
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
