"""Writing of identified values into a vehicle file, without changing comments, order or anything else."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tierod.core.errors import ParameterError
from tierod.core.toml import quoted
from tierod.core.toml_document import line_of
from tierod.core.units import scale
from tierod.vehicles.catalogue import QUANTITIES

_LINE = re.compile(
    r"""(?P<head>\s*[A-Za-z_]+\s*=\s*)(?P<value>"(?:\\.|[^"\\])*"|'[^']*'|[^\s#]+)(?P<tail>\s*(?:\#.*)?)"""
)


@dataclass(frozen=True)
class Change:
    """A new value of a parameter."""

    value: float
    standard_deviation: float  # one sigma, in SI units
    source: str


def changed(text: str, changes: Mapping[str, Change]) -> str:
    """Text of a vehicle file with new values, each in the unit used in the file."""
    before = tomllib.loads(text)
    # Windows line ends are preserved.
    windows = "\r\n" in text
    text = text.replace("\r\n", "\n")
    for name, change in changes.items():
        entry = before.get("parameters", {}).get(name)
        wanted = _entry(name, change, entry)
        text = _added(text, name, wanted) if entry is None else _replaced(text, name, wanted, entry)
    _require_same(before, text, changes)
    return text.replace("\n", "\r\n") if windows else text


def with_thresholds(text: str, of: str, table: Mapping[str, float | str | Mapping[str, float]]) -> str:
    """Text of a vehicle file with thresholds at its end, which replace earlier ones of the same kind."""
    windows, text = "\r\n" in text, text.replace("\r\n", "\n")
    header = re.compile(rf"\[thresholds\.{re.escape(of)}(\..+)?\]\s*(#.*)?")
    kept, inside = [], False
    for line in text.split("\n"):
        if line.lstrip().startswith("["):
            inside = header.fullmatch(line.strip()) is not None
        if not inside:
            kept.append(line)
    plain = [f"{key} = {_written(value)}" for key, value in table.items() if not isinstance(value, Mapping)]
    parts = [[f"[thresholds.{of}]", *plain]]
    for key, value in table.items():
        if isinstance(value, Mapping):
            rows = [f"{quoted(name)} = {_written(number)}" for name, number in value.items()]
            parts.append([f"[thresholds.{of}.{key}]", *rows])
    whole = "\n".join(kept).rstrip() + "".join("\n\n" + "\n".join(part) for part in parts) + "\n"
    # The text is edited line by line, so everything else must be verified to be unchanged.
    if _less_thresholds(text, of) != _less_thresholds(whole, of):
        raise ParameterError(
            f"the older thresholds cannot be replaced; write them as tables [thresholds.{of}], or leave them out"
        )
    return whole.replace("\n", "\r\n") if windows else whole


def _less_thresholds(text: str, of: str) -> dict[str, Any] | None:
    """Content of a vehicle file without one kind of thresholds; None if it is not valid TOML."""
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return None
    thresholds = {name: table for name, table in content.pop("thresholds", {}).items() if name != of}
    return content | {"thresholds": thresholds}


def _written(value: float | str) -> str:
    return quoted(value) if isinstance(value, str) else repr(float(f"{value:.6g}"))


def _entry(name: str, change: Change, entry: Mapping[str, Any] | None) -> dict[str, str]:
    unit = QUANTITIES[name].unit
    written = unit if entry is None else str(entry["unit"])
    factor = 1.0 if written == unit else scale(written, unit).factor
    # TOML requires digits on both sides of the decimal point, as repr() writes them.
    return {
        "value": repr(float(f"{change.value / factor:.8g}")),
        "unit": quoted(written),
        "standard_deviation": repr(float(f"{change.standard_deviation / factor:.3g}")),
        "source": quoted(change.source),
    }


def _added(text: str, name: str, wanted: Mapping[str, str]) -> str:
    lines = "".join(f"{key} = {value}\n" for key, value in wanted.items())
    return f"{text.rstrip()}\n\n[parameters.{name}]\n{lines}"


def _replaced(text: str, name: str, wanted: Mapping[str, str], entry: Mapping[str, Any]) -> str:
    lines = text.split("\n")
    # Every key is located in the current text, because an inserted line shifts those below.
    for key, value in wanted.items():
        if key == "unit":
            continue
        if key not in entry:
            anchor = line_of(text, ("parameters", name, "value")) or 0
            lines.insert(anchor, f"{key} = {value}")
        else:
            number = (line_of(text, ("parameters", name, key)) or 0) - 1
            found = _LINE.fullmatch(lines[number])
            if found is None:
                raise ParameterError(
                    f"line {number + 1}, '{lines[number].strip()[:60]}', cannot be changed where it stands; write the "
                    f"parameter as a table [parameters.{name}] with one key a line"
                )
            lines[number] = f"{found['head']}{value}{found['tail']}"
        text = "\n".join(lines)
    return text


def _require_same(before: dict[str, Any], text: str, changes: Mapping[str, Change]) -> None:
    """Check that nothing but the changed parameters differs, because the text is edited line by line."""
    after = tomllib.loads(text)
    for content in (before, after):
        for name in changes:
            content.get("parameters", {}).pop(name, None)
    if before != after:
        raise ParameterError(
            f"{', '.join(changes)} cannot be changed in this vehicle file without changing more; write every parameter "
            "as a table [parameters.name] with one key a line"
        )
