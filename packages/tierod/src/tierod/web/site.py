"""The served site: folders of recordings and results, vehicle, limits; and the only way from a name to a file."""

from __future__ import annotations

import os
import stat
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Annotated

from pydantic import BaseModel

from tierod.core.errors import InputError
from tierod.core.files import expanded
from tierod.web.errors import Absent

UPLOADS = "uploads"  # Name of the root for uploaded files

LONGEST_NAME = 4096  # Length of a name that no file system exceeds [characters]


@dataclass(frozen=True)
class Root:
    """A served folder, or a single served file in it."""

    name: str
    path: Path  # resolved path of the folder
    only: str = ""  # the single file that is served; "" for all files


@dataclass(frozen=True)
class Limits:
    """Limits on what the server accepts."""

    upload: int = 2 << 30  # largest body of an upload [bytes]
    body: int = 1 << 20  # largest body of any other request [bytes]
    job_time: Annotated[float, "s"] = 3600.0  # longest duration of one job
    job_memory: int = 4 << 30  # largest memory of the process of a job [bytes]
    waiting: int = 100  # largest number of jobs in the queue
    cache: int = 20 << 30  # largest total size of stored analyses [bytes]
    # largest number of open connections; a quarter of the usual 1024 descriptors of a process, since jobs and files
    # need others
    connections: int = 256
    header_time: Annotated[float, "s"] = 10.0  # longest time for the header of a request, which a browser sends at once
    body_pause: Annotated[float, "s"] = 30.0  # longest pause within the body of a request, as in a wireless network


@dataclass(frozen=True)
class Site:
    """Description of what is served."""

    roots: tuple[Root, ...]
    results: tuple[Root, ...]  # folders with results of `tierod fleet`
    cache: Path  # folder for analysed recordings
    # name or path of the vehicle as which recordings are judged; "" for the one named in each of them
    vehicle: str = ""
    dbc: tuple[str, ...] = ()  # databases of bus logs
    channel_map: str = ""  # channel map of the recordings; "" for that of the vehicle
    live: tuple[str, ...] = ()  # buses that are followed, as INTERFACE:CHANNEL
    limits: Limits = field(default_factory=Limits)  # limits on what the server accepts
    demo: bool = False  # whether the demo drive and fleet are made

    def file(self, name: str) -> Path:
        path = self._within(name)
        if not (path.is_file() or path.is_dir()):
            raise Absent(
                f"there is no '{name[:200]}' in the folders that are served; go back to the list and reload it"
            )
        return path

    def folder(self, name: str) -> Path:
        """The folder of a name in an address, resolved; raises as `file`."""
        path = self.file(name)
        if not path.is_dir():
            raise Absent(f"'{name[:200]}' is not a folder; go back to the list and reload it")
        return path

    def name_of(self, path: str | Path) -> str:
        """Name of a file in addresses; "" if it lies outside the served folders."""
        real = os.path.realpath(path)
        for root in self.roots:
            if real.startswith(f"{root.path}{os.sep}") and root.only in ("", os.path.basename(real)):
                return f"{root.name}/{Path(real).relative_to(root.path).as_posix()}"
        return ""

    def result(self, name: str) -> Path:
        found = next((root.path for root in self.results if root.name == name), None)
        if found is None:
            raise Absent(f"no results folder '{name[:200]}' is served; give its path to 'tierod serve'")
        return found

    def _served_as(self, path: str) -> str:
        """Name of an absolute path within the served folders; "" for any other."""
        if not path.startswith("/") or len(path) > LONGEST_NAME:
            return ""
        try:
            return self.name_of(path)
        except (OSError, ValueError):
            return ""

    def _within(self, name: str) -> Path:
        refusal = Absent(f"there is no '{name[:200]}' in the folders that are served")
        if known := self._served_as(name):
            raise Absent(f"'{name[:200]}' lies in a folder that is served; here its name is '{known[:200]}'")
        parts = PurePosixPath(name).parts
        root = next((each for each in self.roots if parts and each.name == parts[0]), None)
        plain = "\0" not in name and "\\" not in name and ".." not in parts and not name.startswith("/")
        if root is None or not plain or len(name) > LONGEST_NAME:
            raise refusal
        try:
            real = Path(os.path.realpath(root.path.joinpath(*parts[1:])))
        except (OSError, ValueError):
            raise refusal from None
        if real != root.path and root.path not in real.parents:
            raise refusal
        if root.only and real not in (root.path / root.only, root.path):
            raise refusal
        return real


def roots_of(paths: Iterable[str | Path]) -> tuple[tuple[Root, ...], tuple[Root, ...]]:
    """(folders with recordings, folders with results) from the paths given by the user."""
    recordings: list[Root] = []
    results: list[Root] = []
    for path in paths:
        real = Path(os.path.realpath(expanded(path)))
        if not real.exists():
            raise InputError(f"there is no {path}; give folders with recordings, or results of 'tierod fleet'")
        into = results if (real / "ledger").is_dir() else recordings
        taken = {each.name for each in [*recordings, *results]} | {UPLOADS}
        folder, only = (real, "") if real.is_dir() else (real.parent, real.name)
        into.append(Root(_free(folder.name or "files", taken), folder, only))
    return tuple(recordings), tuple(results)


def _free(name: str, taken: set[str]) -> str:
    """A unique name, with a number appended if it is taken, and without characters that have a meaning in addresses."""
    plain = "".join(letter if letter.isalnum() or letter in "-_." else "-" for letter in name).strip(".") or "files"
    return next(each for each in (plain, *(f"{plain}-{n}" for n in range(2, 1000))) if each not in taken)


SEARCH_TIME = 0.8  # Time after which a search in subfolders ends with the entries found so far [s]

MOST_FOUND = 2000  # Largest number of entries of a search


class Entry(BaseModel):
    """A file or folder in a listing; `file` is its name in addresses."""

    name: str
    file: str
    folder: bool
    bytes: int
    modified: float
    analysed: bool = False


class Listing(BaseModel):
    """A part of the listing of a folder; `total` counts all matching entries, `gone` are vanished served folders."""

    folder: str
    total: int
    entries: list[Entry]
    complete: bool = True
    gone: list[str] = []


def roots(site: Site) -> list[Entry]:
    """The served folders as entries of a listing, without those that do not exist."""
    there = [root for root in site.roots if _there(root)]
    return [Entry(name=root.name, file=root.name, folder=True, bytes=0, modified=0.0) for root in there]


def _there(root: Root) -> bool:
    return (root.path / root.only).exists()


def listing(
    site: Site, folder: str, search: str = "", sort: str = "name", offset: int = 0, count: int = 200
) -> Listing:
    if not folder and not search:
        found = roots(site)
        return Listing(folder="", total=len(found), entries=found, gone=_gone(site))
    complete = True
    if search:
        found, complete = _searched(site, folder, search.casefold())
    else:
        path = site.folder(folder)
        found = list(_entries(path, folder, _root(site, folder)))
    key = {"modified": lambda each: -each.modified, "bytes": lambda each: -each.bytes}.get(sort)
    found.sort(key=key or (lambda each: (not each.folder, each.name.casefold())))
    return Listing(folder=folder, total=len(found), entries=found[offset : offset + count], complete=complete,
                   gone=_gone(site) if search and not folder else [])  # fmt: skip


def _gone(site: Site) -> list[str]:
    # The folders of the demo appear while the page is open.
    return [] if site.demo else [root.name for root in (*site.roots, *site.results) if not _there(root)]


def _root(site: Site, folder: str) -> Root:
    return next(root for root in site.roots if root.name == folder.partition("/")[0])


def _entries(path: Path, folder: str, root: Root) -> Iterator[Entry]:
    try:
        with os.scandir(path) as entries:
            for each in entries:
                if (found := _entry(each, folder, root)) is not None:
                    yield found
    except OSError as error:
        raise Absent(
            f"the folder '{folder}' cannot be read ({(error.strerror or '').lower()}); check that it still exists"
        ) from None


def _entry(each: os.DirEntry[str], folder: str, root: Root) -> Entry | None:
    if each.name.startswith(".") or (root.only and each.name != root.only):
        return None
    try:
        status = each.stat()
        if each.is_symlink():
            real = os.path.realpath(each.path)
            if not real.startswith(f"{root.path}{os.sep}"):
                return None
    except OSError:
        return None
    is_folder = stat.S_ISDIR(status.st_mode)
    if not is_folder and not stat.S_ISREG(status.st_mode):
        return None
    # Names that are not Unicode are listed too, though no address leads to them.
    name = each.name.encode("utf-8", "replace").decode()
    return Entry(name=name, file=f"{folder}/{name}", folder=is_folder, bytes=status.st_size, modified=status.st_mtime)


def _searched(site: Site, folder: str, wanted: str) -> tuple[list[Entry], bool]:
    until = time.monotonic() + SEARCH_TIME
    waiting = [folder] if folder else [root.name for root in site.roots]
    found: list[Entry] = []
    seen: set[Path] = set()  # a link may lead to a parent folder
    while waiting:
        if time.monotonic() > until or len(found) >= MOST_FOUND:
            return found[:MOST_FOUND], False
        name = waiting.pop()
        try:
            path = site.folder(name)
            entries = [] if path in seen else list(_entries(path, name, _root(site, name)))
        except Absent:
            continue
        seen.add(path)
        waiting += [each.file for each in entries if each.folder]
        found += [each for each in entries if not each.folder and wanted in each.name.casefold()]
    return found, True
