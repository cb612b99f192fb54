"""Refusals of the server, each with the status of HTTP that stands for it."""

from __future__ import annotations

from tierod.core.errors import InputError, TierodError


class Absent(InputError):
    """Nothing of this name is in the folders that are served."""


class Forbidden(TierodError):
    """A request from a place, or with a name, that is not trusted."""


class TooLarge(InputError):
    """More than the server takes."""


class Busy(TierodError):
    """Too much waits already."""


def status_of(error: TierodError) -> int:
    """The status of HTTP for an error that tierod raises on purpose.

    Args:
        error: as raised
    """
    kinds = ((Absent, 404), (Forbidden, 403), (TooLarge, 413), (Busy, 429))
    return next((status for kind, status in kinds if isinstance(error, kind)), 400)
