"""Options of a python-can interface as a user writes them: `data_bitrate=2000000`, or `2:app_name=CANalyzer`."""

from __future__ import annotations

import re
from collections.abc import Sequence

from tierod.core.errors import ParameterError

_WRITTEN = re.compile(r"(?:(?P<bus>\d+):)?(?P<name>[A-Za-z_]\w*)=(?P<value>.*)", re.DOTALL)

OWN = {"interface": "--interface", "channel": "--channel", "bitrate": "--bitrate", "fd": "--fd"}
"""Settings with a command-line option of their own, and that option."""

Option = bool | int | float | str


def interface_options(given: Sequence[str], buses: int) -> list[dict[str, Option]]:
    """Interface options of every bus.

    Args:
        given: options, each as NAME=VALUE for all buses, or as N:NAME=VALUE for the N-th
        buses: number of buses

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
