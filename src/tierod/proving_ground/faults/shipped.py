"""The faults that tierod ships, one file each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tierod.errors import ParameterError, nearest
from tierod.files import expanded
from tierod.proving_ground.faults.fault import Fault
from tierod.toml import Document

SHIPPED = Path(__file__).parent / "shipped"
"""Where the files are."""


@dataclass(frozen=True)
class FaultFile:
    """A file with one fault.

    Args:
        name: of the file
        description: one sentence
        source: where its size comes from, or what it stands for
        fault: as it is used
        path: of the file
    """

    name: str
    description: str
    source: str
    fault: Fault
    path: Path


def shipped() -> tuple[str, ...]:
    """The names of the faults that tierod ships, in alphabetical order."""
    return tuple(sorted(path.stem for path in SHIPPED.glob("*.toml")))


def load(name_or_path: str | Path, within: Document | None = None) -> FaultFile:
    """The fault of a shipped name or of a file.

    Args:
        name_or_path: a name that `shipped` lists, or the path of a fault file (.toml)
        within: document that names it, from whose folder a relative path counts; the working directory where None

    Raises:
        ParameterError: no such fault, or a file with a slip in it; the message names the line and the nearest names
    """
    path = _find(str(name_or_path), Path() if within is None else within.path.parent)
    document = Document.read(path, "fault") if within is None else within.beside(path.absolute(), "fault")
    table = dict(document.content)
    texts = {}
    for key in ("description", "source"):
        texts[key] = table.pop(key, None)
        if not isinstance(texts[key], str):
            raise document.error((key,), f"'{key}' is missing; describe the fault in a sentence")
    table.setdefault("name", path.stem)
    return FaultFile(path.stem, texts["description"], texts["source"], Fault.from_table(table, document), path)


def _find(given: str, beside: Path) -> Path:
    if given in shipped():
        return SHIPPED / f"{given}.toml"
    path = beside / expanded(given)
    if path.exists() and not path.is_dir():
        return path
    if path.suffix == ".toml" or Path(given).parent != Path():
        raise ParameterError(f"there is no fault file {path}; 'tierod faults' lists those that are shipped")
    raise ParameterError(f"no fault is called '{given}'{nearest(given, shipped())} A file is named by its path")
