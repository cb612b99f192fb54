"""Folders that are one recording: a ROS 2 bag."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import IO

from tierod.core.errors import InputError
from tierod.io.readers.content import Content


def holds_bag(folder: Path) -> bool:
    """Whether a folder is a ROS 2 bag, with its description beside its data."""
    return (folder / "metadata.yaml").is_file() and bool(bag_files(folder))


def bag_files(folder: Path) -> list[Path]:
    """The data files of a ROS 2 bag."""
    return sorted(each for each in folder.iterdir() if each.suffix in (".db3", ".mcap"))


def beside_bag(folder: Path, endings: Iterable[str]) -> str:
    """A sentence on recordings in the folder of a bag that are no part of it; "" where there are none."""
    known = set(endings)
    own = set(bag_files(folder))
    others = [each.name for each in sorted(folder.iterdir()) if each.suffix.lower() in known and each not in own]
    if not others:
        return ""
    more = f" and {len(others) - 3} more" if len(others) > 3 else ""
    return f"the folder is a ROS 2 bag; {', '.join(others[:3])}{more} beside it was not read: give it by its own path"


def folder_content(folder: Path) -> Content:
    """The content of a folder, which only the reader of bags can open."""

    def opened() -> IO[bytes]:
        raise InputError(f"{folder} is a folder; give one recording in it")

    return Content(folder, sum(each.stat().st_size for each in bag_files(folder)), False, False, opened)
