"""Errors that tierod raises on purpose.

    TierodError
    ├── InputError        a file, recording or signal cannot be used as given
    ├── ParameterError    a vehicle file, parameter or option is wrong
    ├── TraceError        a block or model cannot be traced into a graph
    ├── CompileError      no compiler, or generated code did not compile
    ├── OutputError       a result cannot be written
    ├── MissingExtra      an optional library is not installed
    └── MissingPackage    the package tierod-lab is not installed, or of another version

Each message states the given value, the expected one, and the remedy.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class TierodError(Exception):
    """Base of all errors that tierod raises on purpose."""


class InputError(TierodError):
    """A file, recording or signal cannot be used as given."""


class DamagedFile(InputError):
    """A file cannot be read to its end; opening it again would take as long and fail in the same way."""


class ParameterError(TierodError):
    """A vehicle file, a parameter or an option is wrong."""


class TraceError(TierodError):
    """A block or model cannot be traced into a graph."""


class CompileError(TierodError):
    """Generated code did not compile, or the requested compiler is absent."""


class KernelWarning(UserWarning):
    """Compiled kernels are not kept in their usual folder, or a block runs interpreted because it does not compile."""


class PluginWarning(UserWarning):
    """An extension of an installed package cannot be used and is left out."""


class OutputError(TierodError):
    """A result cannot be written."""


class MissingExtra(TierodError):
    def __init__(self, library: str, extra: str, purpose: str):
        super().__init__(
            f"{purpose} needs the library '{library}', which is not installed; "
            f"install it with: pip install 'tierod[{extra}]'"
        )


class MissingPackage(TierodError):
    """A package beside tierod is missing, or does not fit."""

    def __init__(self, purpose: str, package: str, version: str, why: str):
        super().__init__(
            f"{purpose} needs the package {package} {version}, which {why}; pip install {package}=={version}"
        )


def lacks_memory(error: BaseException) -> bool:
    """Whether an error means that the memory was not enough, also for the code of a library."""
    # Python's own parser loses a part of a tree that it finds no memory for.
    said = {ImportError: "failed to map segment", ValueError: "is required for AnnAssign"}
    return isinstance(error, MemoryError) or any(
        isinstance(error, kind) and words in str(error) for kind, words in said.items()
    )


def nearest(name: str, known: Iterable[str], count: int = 3) -> str:
    """A half-sentence with the valid names nearest to a wrong one.

    Returns:
        for example ``"; did you mean 'yaw_rate'?"``, or the list of known names where none is near
    """
    known = sorted(set(known))
    lowered = {candidate.lower(): candidate for candidate in known}
    close = difflib.get_close_matches(name.lower(), lowered, n=count, cutoff=0.6)
    if close:
        return "; did you mean " + " or ".join(f"'{lowered[c]}'" for c in close) + "?"
    if len(known) <= 20:
        return "; known: " + ", ".join(known) + "."
    return f"; none of the {len(known)} known names resembles it."
