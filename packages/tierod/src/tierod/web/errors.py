"""Errors by which the server refuses a request, and their HTTP status."""

from __future__ import annotations

import re

from tierod.core.errors import InputError, TierodError


class Absent(InputError):
    """Nothing of this name exists in the served folders."""


class Forbidden(TierodError):
    """A request from an origin, or with a name, that is not trusted."""


class TooLarge(InputError):
    """A request for more data than the server accepts or returns."""


class Busy(TierodError):
    """Too many jobs are waiting."""


def status_of(error: TierodError) -> int:
    kinds = ((Absent, 404), (Forbidden, 403), (TooLarge, 413), (Busy, 429))
    return next((status for kind, status in kinds if isinstance(error, kind)), 400)


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
