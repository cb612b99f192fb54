"""Pages of all numbers in the monitors: defaults of fields, module constants, and demonstrated performance."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from docs_text import page, table

MONITORS = Path(__file__).resolve().parent.parent / "src" / "tierod" / "monitors"
PAGES: dict[str, tuple[Any, ...]] = {
    "condition": ("The condition monitor", ("condition", "condition/kinds", "condition/recording_checks")),
    "condition-bank": ("The condition monitor's bank of filters", ("condition/bank", "condition/calibration")),
    "driver-torque": ("The driver torque monitor", ("driver_torque",)),
    "friction": ("The friction and the hysteresis monitor", ("friction", "hysteresis")),
    "motor-angle": ("The motor angle monitor", ("motor_angle",)),
    "sideslip": ("The sideslip monitor, a to combined", ("sideslip",), "", "conventional"),
    "sideslip-2": ("The sideslip monitor, conventional to z", ("sideslip",), "conventional"),
    "inputs": ("Checks of the inputs", (".", "harness", "harness/spread")),
}
"""End of a page's name -> title, folders, and optionally first and end name of the listed modules."""


class Number(NamedTuple):
    """A number in the code.

    Args:
        where: module, and class for a field
        name, value: as in the code
        unit: of a field
        reason: explanation in the docstring
    """

    where: str
    name: str
    value: str
    unit: str
    reason: str


def pages() -> dict[str, Callable[[], str]]:
    """Path below docs -> function that returns the text."""
    return {f"reference/tuning/{name}.md": partial(_page, *about) for name, about in PAGES.items()}


def _page(title: str, folders: tuple[str, ...], first: str = "", last: str = "~") -> str:
    """Page of the numbers in the modules of some folders, with module names from `first` to before `last`."""
    files = [
        file for folder in folders for file in sorted((MONITORS / folder).glob("*.py")) if first <= file.stem < last
    ]
    found = [number for file in files for number in numbers(file)]
    parts = [
        "Every default of a tuning and every constant, with what the code says about it. A vehicle file, or a tuning "
        "given in Python, takes the place of the defaults.",
    ]
    for where in dict.fromkeys(number.where for number in found):
        rows = [(f"`{each.name}`", each.value, each.unit, each.reason) for each in found if each.where == where]
        parts += [f"## {where}", table(("name", "value", "unit", "meaning"), rows)]
    return page(f"{title}: numbers", *parts)


def numbers(path: Path) -> Iterator[Number]:
    """All chosen numbers of a module: named constants and defaults, not the 0 or 1 of an equation.

    Args:
        path: of the module
    """
    tree = ast.parse(path.read_text(encoding="utf-8"))
    module = path.relative_to(MONITORS).with_suffix("").as_posix()
    for place, node in enumerate(tree.body):
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None and _has_number(node.value):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            value = _written(node.value)
            yield Number(module, ", ".join(map(ast.unparse, targets)), value, "", _below(tree.body, place))
        elif isinstance(node, ast.ClassDef):
            yield from _fields(module, node)
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Demonstrated":
            yield Number(module, "demonstrated", _written(node), "", "observed on fault-free data")


def _fields(module: str, node: ast.ClassDef) -> Iterator[Number]:
    meanings = _meanings(ast.get_docstring(node) or "")
    for each in node.body:
        if not isinstance(each, ast.AnnAssign) or each.value is None or not _has_number(each.value):
            continue
        name = ast.unparse(each.target)
        unit = ""
        if isinstance(each.annotation, ast.Subscript) and isinstance(each.annotation.slice, ast.Tuple):
            unit = ast.literal_eval(each.annotation.slice.elts[1]) if _is_text(each.annotation.slice.elts[1]) else ""
        yield Number(f"{module}, {node.name}", name, _written(each.value), unit, meanings.get(name, ""))


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _has_number(node: ast.expr) -> bool:
    return any(
        isinstance(each, ast.Constant) and isinstance(each.value, int | float) and not isinstance(each.value, bool)
        for each in ast.walk(node)
    )


def _written(node: ast.expr) -> str:
    """An expression as in the code; of a long one its numbers only, in their order."""
    text = ast.unparse(node)
    if len(text) <= 40:
        return f"`{text}`"
    found = [each.value for each in ast.walk(node) if isinstance(each, ast.Constant)]
    return "`" + ", ".join(repr(each) for each in found if isinstance(each, int | float)) + "`"


def _below(body: list[ast.stmt], place: int) -> str:
    """The docstring below a constant."""
    after = body[place + 1] if place + 1 < len(body) else None
    text = after.value.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else ""
    return _short(text) if isinstance(text, str) else ""


def _meanings(docstring: str) -> dict[str, str]:
    """Field -> its explanation in the list of arguments."""
    listed = re.search(r"Args:\n(.*?)(\n\n|\Z)", docstring, re.DOTALL)
    found: dict[str, str] = {}
    for entry in re.split(r"\n(?=    \w)", "\n" + listed[1] if listed else ""):
        names, _, text = entry.partition(": ")
        for name in re.split(r", ", names.strip()):
            found[name] = _short(text)
    return found


def _short(text: str) -> str:
    """A text on one line, up to its first semicolon or full stop, for a table cell."""
    line = " ".join(text.split())
    return re.split(r"(?<=[^0-9]); |\. ", line)[0].rstrip(".")
