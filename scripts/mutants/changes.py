"""All single changes of a Python file: of signs, operators, bounds, constants and terms."""

from __future__ import annotations

import ast
import difflib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

SWAPPED = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*"}
BOUNDARY = {ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">"}
REVERSED = {ast.Lt: ">", ast.LtE: ">=", ast.Gt: "<", ast.GtE: "<=", ast.Eq: "!=", ast.NotEq: "=="}
EXCHANGED = {"minimum": "maximum", "maximum": "minimum", "min": "max", "max": "min", "sin": "cos", "cos": "sin"}
TENTH = 1.1
"""Factor applied to a changed constant."""


@dataclass(frozen=True)
class Change:
    """One change of one file.

    Args:
        path: of the file, relative to the root of the source
        kind: of the change
        line: number of its first line
        begin, end: limits of the replaced bytes
        text: replacement
    """

    path: Path
    kind: str
    line: int
    begin: int
    end: int
    text: str

    def applied(self, source: bytes) -> bytes:
        """Source with the change."""
        return source[: self.begin] + self.text.encode() + source[self.end :]

    def valid(self, source: bytes) -> bool:
        """Whether the changed source is valid Python and a different program."""
        try:
            changed = ast.parse(self.applied(source))
        except SyntaxError:
            return False
        return ast.dump(changed) != ast.dump(ast.parse(source))

    def diff(self, source: bytes) -> str:
        """Changed lines, before and after."""
        before, after = source.decode().splitlines(), self.applied(source).decode().splitlines()
        lines = difflib.unified_diff(before, after, n=0, lineterm="")
        return "\n".join(line for line in lines if line[:1] in "+-" and line[:3] not in ("+++", "---"))


def changes_of(path: Path, source: bytes) -> list[Change]:
    """All changes of a file; a few of them are not valid Python.

    Args:
        path: of the file, copied to the changes
        source: content of the file
    """
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def span(node: ast.expr) -> tuple[int, int]:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return starts[node.lineno - 1] + node.col_offset, starts[node.end_lineno - 1] + node.end_col_offset

    def text(node: ast.expr) -> str:
        begin, end = span(node)
        return source[begin:end].decode()

    return [
        Change(path, kind, node.lineno, *span(node), replacement)
        for node in _values(ast.parse(source))
        for kind, replacement in _replacements(node, text)
    ]


def _values(node: ast.AST) -> Iterator[ast.expr]:
    """Expressions that determine a value: no annotations, decorators, f-strings or raise statements."""
    for name, field in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "bases", "type_params"):
            continue
        for child in field if isinstance(field, list) else [field]:
            if not isinstance(child, ast.AST) or isinstance(child, ast.Raise | ast.JoinedStr) or _is_type(child):
                continue
            if isinstance(child, ast.expr):
                yield child
            yield from _values(child)


def _is_type(node: ast.AST) -> bool:
    return isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and node.value.id == "Annotated"


def _replacements(node: ast.expr, text: Callable[[ast.expr], str]) -> Iterator[tuple[str, str]]:
    """(kind, replacement) of every change of one expression."""
    match node:
        case ast.Constant(value=bool(value)):
            yield "constant", str(not value)
        case ast.Constant(value=float(value)) if value == value and abs(value) != float("inf"):
            yield "constant", repr(TENTH * value if value else 0.1)
        case ast.Constant(value=int(value)):
            yield "index", str(value + 1)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            yield "sign", f"(+{text(operand)})"
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield "logic", f"(bool({text(operand)}))"
        case ast.BinOp(left=left, op=op, right=right) if not (_is_text(left) or _is_text(right)):
            if type(op) in SWAPPED:
                yield "operator", f"({text(left)}) {SWAPPED[type(op)]} ({text(right)})"
            if isinstance(op, ast.Add | ast.Sub):
                yield "term", f"({text(left)})"
            elif isinstance(op, ast.Mult | ast.Div | ast.Pow):
                yield "factor", f"({text(left)})"
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            for kind, table in (("boundary", BOUNDARY), ("comparison", REVERSED)):
                if type(op) in table:
                    yield kind, f"({text(left)}) {table[type(op)]} ({text(right)})"
        case ast.BoolOp(op=op, values=values):
            word = " or " if isinstance(op, ast.And) else " and "
            yield "logic", f"({word.join(f'({text(value)})' for value in values)})"
        case ast.Call(func=ast.Name(id="where"), args=[condition, yes, no], keywords=[]):
            yield "branch", f"where({text(condition)}, {text(no)}, {text(yes)})"
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in EXCHANGED:
            yield "function", f"{EXCHANGED[name]}({', '.join(map(text, args))})"
        case ast.Attribute(value=value, attr=name) if name in EXCHANGED:
            yield "function", f"{text(value)}.{EXCHANGED[name]}"


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str | bytes))
