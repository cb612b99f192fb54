"""Selection of the tests that concern a file: its mirror, tests that import it, and tests of modules importing it."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

FAR = ("attack", "cli", "examples", "plugins", "contract")
"""Folders with tests of the whole program, which concern a file only if they import it directly."""

DISTANCE = 3
"""Largest number of import steps between a test and a file; 1 means a direct import."""


@dataclass(frozen=True)
class ChosenTests:
    """Tests of a checkout and their imports.

    Args:
        root: folder with `src` and `tests`
    """

    root: Path

    @cached_property
    def _sources(self) -> dict[str, Path]:
        return {_module(self.root / "src", path): path for path in sorted((self.root / "src").rglob("*.py"))}

    @cached_property
    def _importers(self) -> dict[str, set[str]]:
        """Module -> source modules that import it."""
        found: dict[str, set[str]] = {}
        for name, path in self._sources.items():
            for imported in self._imported(path):
                found.setdefault(imported, set()).add(name)
        return found

    @cached_property
    def _tests(self) -> dict[Path, set[str]]:
        """Test file -> modules that it imports, directly or through helpers in tests/."""
        folder = self.root / "tests"
        return {path: set(self._of_test(path, set())) for path in sorted(folder.rglob("test_*.py"))}

    def _of_test(self, path: Path, seen: set[Path]) -> Iterator[str]:
        seen.add(path)
        yield from self._imported(path)
        for name in _names(path):
            helper = self.root / "tests" / (name.replace(".", "/") + ".py")
            if helper.exists() and helper not in seen:
                yield from self._of_test(helper, seen)

    def _imported(self, path: Path) -> Iterable[str]:
        return {name for name in _names(path) if name in self._sources}

    def of(self, path: Path) -> list[Path]:
        """Test files that concern a source file, nearest first, relative to the root.

        Args:
            path: of the file, relative to `src`
        """
        folder = self.root / "tests"
        mirror = folder.joinpath(*path.parent.parts[1:])
        distances = self._distances(_module(Path(), path))
        ranked = []
        for test, imported in self._tests.items():
            near = min((distances[name] for name in imported if name in distances), default=DISTANCE + 1)
            far = test.relative_to(folder).parts[0] in FAR
            mirrored = test.parent == mirror or mirror in test.parents
            if test.name == f"test_{path.stem}.py" and mirrored:
                near = 0
            if near <= (1 if far else DISTANCE) or mirrored:
                ranked.append((near, not mirrored, test.relative_to(self.root)))
        return [test for *_, test in sorted(ranked)]

    def _distances(self, module: str) -> dict[str, int]:
        """Module -> number of import steps from a test that imports it to the given module."""
        found, edge = {module: 1}, [module]
        for distance in range(2, DISTANCE + 1):
            edge = [each for name in edge for each in self._importers.get(name, ()) if each not in found]
            found.update(dict.fromkeys(edge, distance))
        return found


def _module(root: Path, path: Path) -> str:
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _names(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module
            yield from (f"{node.module}.{each.name}" for each in node.names)
        elif isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
