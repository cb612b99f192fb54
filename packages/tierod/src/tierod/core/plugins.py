"""Registries of monitors, readers, writers, vehicles, faults and scenarios: tierod's own and those of other packages.

An installed package adds to tierod by an entry point:

    [project.entry-points."tierod.monitors"]
    wheel-imbalance = "my_package.monitor:MONITOR"

Installed packages are searched only for a name that is not one of tierod's own, or for a list of all names: reading
their metadata takes some 10 ms, and importing `importlib.metadata` 50 ms more.
"""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import cache, cached_property
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from tierod.core.errors import MissingPackage, ParameterError, PluginWarning, lacks_memory, nearest
from tierod.core.files import expanded
from tierod.core.version import __version__

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


T = TypeVar("T")

OWN_PACKAGE = "tierod"


class Registry(Mapping[str, T], Generic[T]):
    """Objects of one kind by name; a plug-in is imported only when it is used.

    Iterating gives tierod's own names, then those of plug-ins that can be used; a `PluginWarning` names the others.

    Args:
        obstacle: gives the reason why a loaded object cannot be used, as a half-sentence ("has no variant"); ""
            where it can
    """

    def __init__(self, group: str, kind: str, own: Mapping[str, str], obstacle: Callable[[str, object], str]):
        self.group, self.kind, self.own = group, kind, own
        self._obstacle = obstacle
        self._loaded: dict[str, T] = {}
        self._warned: set[str] = set()

    def __getitem__(self, name: str) -> T:
        if name not in self._loaded:
            if name in self.own:
                self._loaded[name] = self._load_own(name)
            else:
                self._loaded[name] = self._load_plugin(name, self._plugins[name])
        return self._loaded[name]

    def __contains__(self, name: object) -> bool:
        return name in self.own or name in self._plugins

    def __iter__(self) -> Iterator[str]:
        yield from self.own
        yield from self.plugin_names()

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def plugin_names(self) -> tuple[str, ...]:
        """The names of plug-ins that can be used; a `PluginWarning` names each of the others once."""
        usable = []
        for name, points in self._plugins.items():
            try:
                if name in self.own:
                    raise ParameterError(self._shadowed(name, points))
                self[name]
                usable.append(name)
            except ParameterError as error:
                if name not in self._warned:
                    self._warned.add(name)
                    warnings.warn(f"{error}", PluginWarning, stacklevel=2)
        return tuple(usable)

    def required(self, name: str) -> T:
        if name not in self:
            raise ParameterError(f"there is no {self.kind} '{name}'{nearest(name, self)}")
        return self[name]

    def package_of(self, name: str) -> str:
        """The package that provides a name, with its version where it is not tierod itself."""
        return OWN_PACKAGE if name in self.own else " and ".join(map(_package, self._plugins[name]))

    @cached_property
    def _plugins(self) -> dict[str, list[EntryPoint]]:
        """Entry points of installed packages by name; several where packages use the same name."""
        from importlib.metadata import entry_points

        found: dict[str, list[EntryPoint]] = {}
        for point in sorted(entry_points(group=self.group), key=lambda point: (point.name, _package(point))):
            found.setdefault(point.name, []).append(point)
        return found

    def _load_own(self, name: str) -> T:
        module, _, attribute = self.own[name].partition(":")
        value: T = getattr(importlib.import_module(module), attribute)
        return value

    def _load_plugin(self, name: str, points: list[EntryPoint]) -> T:
        who = f"the {self.kind} '{name}' of the package {_package(points[0])}"
        if len(points) > 1:
            packages = " and ".join(map(_package, points))
            raise ParameterError(
                f"the packages {packages} both register a {self.kind} '{name}'; uninstall one of them: "
                f"pip uninstall {_distribution(points[-1])}"
            )
        remedy = f"update or uninstall it: pip uninstall {_distribution(points[0])}"
        try:
            value = points[0].load()
        except (Exception, SystemExit) as error:  # the import runs foreign code, which may raise anything or exit
            reason = " ".join(str(error).split())[:200]
            raise ParameterError(f"{who} cannot be imported ({type(error).__name__}: {reason}); {remedy}") from error
        if why := self._obstacle(name, value):
            raise ParameterError(f"{who} {why}; {remedy}")
        loaded: T = self._converted(name, value)
        return loaded

    def _converted(self, name: str, value: Any) -> Any:
        return value

    def _shadowed(self, name: str, points: list[EntryPoint]) -> str:
        packages = " and ".join(map(_package, points))
        return (
            f"the {self.kind} '{name}' of the package {packages} is not used, since tierod has one of this name; "
            f"rename it there, or uninstall it: pip uninstall {_distribution(points[0])}"
        )


class FileRegistry(Registry[Path]):
    """Files of one kind by name; the entry point of a plug-in names the package whose folder holds NAME.toml."""

    def __init__(
        self, group: str, kind: str, folder: Path, without: tuple[str, ...] = (".channels.toml", "classes.toml")
    ):
        files = sorted(path for path in folder.glob("*.toml") if not path.name.endswith(without))
        super().__init__(group, kind, {path.stem: str(path) for path in files}, self._missing_file)

    def find(self, given: str, beside: Path | None = None) -> Path:
        """The file with a name, or at a path that the user gives.

        Args:
            beside: folder that a relative path refers to; the working directory where None
        """
        path = (beside or Path()) / expanded(given)
        if given not in self.own and path.exists() and not path.is_dir():
            return path
        if given in self:
            return self[given]
        if path.suffix == ".toml" or expanded(given).parent != Path():
            raise ParameterError(
                f"there is no {self.kind} file {path}; 'tierod {self.kind}s' lists those that are shipped"
            )
        raise ParameterError(f"no {self.kind} is called '{given}'{nearest(given, self)} A file is named by its path")

    def _load_own(self, name: str) -> Path:
        return Path(self.own[name])

    def _converted(self, name: str, value: Any) -> Path:
        return _file_beside(value, name)

    def _missing_file(self, name: str, value: Any) -> str:
        if not isinstance(value, ModuleType):
            return f"names {type(value).__name__} where a package is expected, in whose folder {name}.toml lies"
        path = _file_beside(value, name)
        return "" if path.is_file() else f"lacks its file {path}"


def _file_beside(package: ModuleType, name: str) -> Path:
    folders = list(getattr(package, "__path__", [])) or [str(Path(str(package.__file__)).parent)]
    return Path(folders[0]) / f"{name}.toml"


def _package(point: EntryPoint) -> str:
    return f"{_distribution(point)} {point.dist.version}" if point.dist else _distribution(point)


def _distribution(point: EntryPoint) -> str:
    return point.dist.name if point.dist else point.value.partition(".")[0]


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
