"""Messages of the library reworded for the page: actions in the page in place of command-line options."""

from __future__ import annotations

import re

_WORDS = (
    (r"give it with dbc= \(--dbc\)", "choose or upload it as CAN database under 'New recording'"),
    (
        r"give --vehicle \(in Python: vehicle=\.\.\.\) with a name of 'tierod vehicles' or the path of a TOML file",
        "choose one under 'judged as'",
    ),
    (
        r"or give --vehicle \(in Python: vehicle=\.\.\.\), whose file may name databases and channel map",
        "or choose a vehicle under 'judged as' whose file names database and channel map",
    ),
    (r"; check --vehicle\b", "; check 'judged as'"),
    (r"judge it with --vehicle (\S+)", r"choose \1 under 'judged as'"),
    (r"into a channel map \(--map\)", "into the channel map (time unit, under 'New recording')"),
    (r"and give --vehicle car\.toml", "put it into a folder that is served, and start 'tierod serve' with --vehicle"),
    (r"a channel map \(--map\) gives", "the channel map under 'New recording' gives"),
    (r" \((?:--variant [\w-]+|--baseline|--residual)\)", ""),
)
_PATTERNS = tuple((re.compile(pattern), said) for pattern, said in _WORDS)

_UNREAD = re.compile(
    r"no vehicle is given, and none can be read from the recording: (.*); or choose a vehicle under .*"
)


def in_the_page(text: str) -> str:
    """A message with the action to take in the page."""
    for pattern, said in _PATTERNS:
        text = pattern.sub(said, text)
    unread = _UNREAD.fullmatch(text)
    # That a vehicle may name the database only matters for a bus log.
    return unread[1] if unread and "CAN database" not in text else text
