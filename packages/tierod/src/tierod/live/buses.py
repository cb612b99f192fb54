"""Buses opened through python-can by the name of their interface: options, receiving, reopening after a loss."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import TYPE_CHECKING, Annotated, Any

from tierod.core.errors import InputError, MissingExtra, ParameterError, TierodError, nearest
from tierod.core.processes import interpreter
from tierod.io.readers.frames import EXTENDED
from tierod.live.clock import Frame, Notice

if TYPE_CHECKING:
    import can

FIRST, LONGEST = 0.2, 5.0
"""Initial and longest pause before a lost bus is opened again; it doubles from one attempt to the next [s]."""

WAIT = 0.2  # Longest time that one receive call waits for a frame [s]

BUFFER: Annotated[int, "byte"] = 1 << 23
"""Size of the receive buffer requested from the operating system: some seconds of a busy bus."""

_FORCED = 33  # SO_RCVBUFFORCE of Linux: a receive buffer beyond the usual limit, for privileged processes

_MULTICAST_ALL = 49  # IP_MULTICAST_ALL of Linux, for which Python has no name

MOST_DROPPED = 10_000
"""Largest number of datagrams dropped that arrived before IP_MULTICAST_ALL was set; bounds the loop on a busy bus."""

Inbox = SimpleQueue[Frame | Notice]

_WRITTEN = re.compile(r"(?:(?P<bus>\d+):)?(?P<name>[A-Za-z_]\w*)=(?P<value>.*)", re.DOTALL)

OWN = {"interface": "--interface", "channel": "--channel", "bitrate": "--bitrate", "fd": "--fd"}
"""Settings with a command-line option of their own, and that option."""

Option = bool | int | float | str


@dataclass(frozen=True)
class Address:
    """Address of a bus."""

    interface: str
    channel: str
    bitrate: Annotated[int, "bit/s"] | None = None  # bit rate of a classic bus; None keeps the setting of the driver
    fd: bool = False
    options: Mapping[str, Any] = field(default_factory=dict)


def interface_options(given: Sequence[str], buses: int) -> list[dict[str, Option]]:
    """Interface options of every bus.

    Args:
        given: options, each as NAME=VALUE for all buses, or as N:NAME=VALUE for the N-th

    Raises:
        ParameterError: an option is malformed, has an option of the command, or is for a bus that does not exist
    """
    found: list[dict[str, Option]] = [{} for _ in range(buses)]
    for each in given:
        match = _WRITTEN.fullmatch(each)
        if match is None:
            raise ParameterError(
                f"--interface-option is '{each}'; expected NAME=VALUE as python-can names it, such as "
                "data_bitrate=2000000, or 2:app_name=CANalyzer for the second bus alone"
            )
        name, bus = match["name"], int(match["bus"] or 0)
        if name in OWN:
            raise ParameterError(f"--interface-option is '{each}'; {name} is given by {OWN[name]}")
        if bus > buses or match["bus"] == "0":
            raise ParameterError(
                f"--interface-option is '{each}'; there are buses 1 to {buses}, one for every --channel"
            )
        for options in found if not bus else found[bus - 1 : bus]:
            options[name] = _value(match["value"])
    return found


def _value(text: str) -> Option:
    """A truth value or number where the text is one, else the text."""
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (lambda: int(text, 0), lambda: float(text)):
        try:
            return kind()
        except ValueError:
            continue
    return text


def open_bus(address: Address) -> can.BusABC:
    """Open a bus.

    Raises:
        MissingExtra: python-can is not installed
        ParameterError: there is no such interface
        InputError: driver, device or permission are missing
    """
    try:
        import can
    except ImportError:
        raise MissingExtra("python-can", "live", "listening to a bus") from None
    known = sorted(map(str, can.VALID_INTERFACES))
    if address.interface not in known:
        raise ParameterError(f"python-can has no interface '{address.interface}'{nearest(address.interface, known)}")
    options = dict(address.options) | ({"bitrate": address.bitrate} if address.bitrate else {})
    options |= {"fd": True} if address.fd else {}
    place = f"the bus {address.interface} {address.channel}"
    try:
        bus = can.Bus(interface=address.interface, channel=address.channel, **options)
    except PermissionError:
        raise InputError(
            f"{place} cannot be opened: permission denied; run as a user with the right to use it"
        ) from None
    except (can.CanInterfaceNotImplementedError, ImportError, NameError, AttributeError) as error:
        raise InputError(
            f"{place} cannot be opened: its driver is not installed ({_reason(error)}); install that of the vendor"
        ) from None
    except (can.CanError, OSError, ValueError, TypeError, NotImplementedError) as error:
        raise InputError(f"{place} cannot be opened ({_reason(error)}); {_remedy(error)}") from None
    _enlarge(bus)
    if address.interface == "udp_multicast" and sys.platform == "linux":
        _own_group_alone(bus)
    return bus


def _remedy(error: Exception) -> str:
    """Remedy for a bus that cannot be opened."""
    text = str(error).lower()
    if getattr(error, "errno", None) == errno.EAFNOSUPPORT:
        return (
            "the system of this computer has no CAN sockets: load them (sudo modprobe can_raw), or use another "
            "interface"
        )
    if re.search(r"(library|driver|dll|module).*not.*(found|load|install)|could not.*(find|load)", text):
        return "its driver is not installed: install that of the vendor"
    if isinstance(error, TypeError) or "argument" in text:
        return "give what the interface needs with --interface-option NAME=VALUE"
    return "check that the device is plugged in, is up, and has this name"


def _own_group_alone(bus: can.BusABC) -> None:
    """Restrict a multicast socket on Linux to its own group; else it gets the frames of every group joined here.

    Two channels would then act as one bus, with every frame twice. Datagrams that arrived since the socket was bound
    may belong to any group, and are dropped.
    """
    with contextlib.suppress(OSError), socket.socket(fileno=os.dup(bus.fileno())) as twin:
        if twin.family != socket.AF_INET:
            return
        twin.setsockopt(socket.IPPROTO_IP, _MULTICAST_ALL, 0)
        for _ in range(MOST_DROPPED):
            twin.recv(1, socket.MSG_DONTWAIT)


def _enlarge(bus: can.BusABC) -> None:
    """Enlarge the receive buffer of the bus as far as the system allows; without a socket do nothing."""
    # Drivers without a socket raise arbitrary errors when asked for its descriptor.
    with contextlib.suppress(Exception), socket.socket(fileno=os.dup(bus.fileno())) as twin:
        for option in (_FORCED, socket.SO_RCVBUF):
            with contextlib.suppress(OSError):
                twin.setsockopt(socket.SOL_SOCKET, option, BUFFER)
                return


def _reason(error: BaseException) -> str:
    return " ".join(str(error).split())[:160] or type(error).__name__


class Receiver(threading.Thread):
    """Thread that receives from one bus, and reopens the bus after each failure.

    Args:
        number: number of the bus, from 1

    Raises:
        InputError: the bus cannot be opened now; further errors as in `open_bus`
    """

    def __init__(self, number: int, address: Address, inbox: Inbox):
        super().__init__(name=f"bus {number}", daemon=True)
        self.number, self.address, self._inbox = number, address, inbox
        self._bus: can.BusABC | None = open_bus(address)
        self._ended = threading.Event()

    def run(self) -> None:
        """Receive until `end` is called."""
        while not self._ended.is_set():
            try:
                self._receive()
            except Exception as error:  # drivers raise arbitrary errors; the bus is opened again
                self._inbox.put(Notice(self.number, "lost", f"bus {self.number} was lost: {_reason(error)}"))
                self._close()
                self._reopen()
        self._close()

    def _receive(self) -> None:
        bus, number, put = self._bus, self.number, self._inbox.put
        assert bus is not None
        while not self._ended.is_set():
            message = bus.recv(WAIT)
            if message is None or message.is_remote_frame:
                continue
            if message.is_error_frame:
                put(Notice(number, "error frame", f"bus {number} reports an error frame"))
                continue
            identifier = message.arbitration_id | (EXTENDED if message.is_extended_id else 0)
            put(Frame(message.timestamp, identifier, number, bytes(message.data)))

    def _reopen(self) -> None:
        pause = FIRST
        while not self._ended.wait(pause):
            pause = min(2.0 * pause, LONGEST)
            try:
                self._bus = open_bus(self.address)
            except (InputError, ParameterError):
                continue
            self._inbox.put(Notice(self.number, "back", f"bus {self.number} is back"))
            return

    def _close(self) -> None:
        bus, self._bus = self._bus, None
        if bus is not None:
            with contextlib.suppress(Exception):  # the driver of a lost bus may raise any error
                bus.shutdown()

    def end(self) -> None:
        """Stop receiving and close the bus."""
        self._ended.set()
        if self.is_alive():
            self.join(2.0)
        else:
            self._close()


MOST, SECONDS = 25_000, 0.005  # Largest number of frames in a batch, and period of the batches [s]

PATIENCE = 20.0  # Time allowed for the bus to open [s]


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
            interpreter("-m", "tierod.live.buses", str(writing), json.dumps(said)),
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
