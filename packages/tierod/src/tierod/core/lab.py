"""What the package tierod-lab adds: the virtual vehicle, campaigns and studies, found by its entry points alone."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tierod.core.errors import MissingPackage, lacks_memory
from tierod.core.version import __version__

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

PACKAGE = "tierod-lab"
GROUP = "tierod.lab"

VERBS = ("campaign", "scenarios", "simulate", "study")  # Verbs that the package adds to the command line


@cache
def _points() -> dict[str, EntryPoint]:
    from importlib.metadata import entry_points

    return {each.name: each for each in entry_points(group=GROUP)}


def installed() -> bool:
    """Whether the package is installed in the version of tierod."""
    return bool(_points()) and _version() in ("", __version__)


def _version() -> str:
    """Version of the package; "" where it is not installed, or does not say it."""
    return next((each.dist.version for each in _points().values() if each.dist), "")


def folders() -> list[Path]:
    """Folders of the packages that registered."""
    from importlib.util import find_spec

    roots = {each.value.partition(":")[0].partition(".")[0] for each in _points().values()}
    found = (find_spec(each) for each in sorted(roots))
    return [Path(place) for each in found if each for place in each.submodule_search_locations or ()]


def part(name: str, purpose: str) -> Any:
    """Object that the package registers under a name."""
    point = _points().get(name)
    if (version := _version()) not in ("", __version__):
        raise MissingPackage(purpose, PACKAGE, __version__, f"is installed in version {version}")
    if point is None:
        raise MissingPackage(purpose, PACKAGE, __version__, "lacks it" if _points() else "is not installed")
    try:
        return point.load()
    except (ImportError, AttributeError) as error:
        if lacks_memory(error):
            raise
        reason = " ".join(str(error).split())[:160]
        raise MissingPackage(purpose, PACKAGE, __version__, f"cannot be imported ({reason})") from error
