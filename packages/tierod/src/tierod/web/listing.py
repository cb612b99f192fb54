"""Listing of a folder from its entries alone: no file is opened, so that large folders are listed quickly."""

from __future__ import annotations

import os
import stat
import time
from collections.abc import Iterator
from pathlib import Path

from pydantic import BaseModel

from tierod.web.errors import Absent
from tierod.web.site import Root, Site

SEARCH_TIME = 0.8
"""Time after which a search in subfolders ends with the entries found so far [s]."""

MOST_FOUND = 2000
"""Largest number of entries of a search."""


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
    """Files whose name contains a text, and whether all folders were searched."""
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
