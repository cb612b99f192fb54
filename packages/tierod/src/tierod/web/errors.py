"""Errors by which the server refuses a request, and their HTTP status."""

from __future__ import annotations

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
