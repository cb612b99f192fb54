"""What a block takes and gives is typed: no `step` has `Any` among its annotations."""

import ast
from pathlib import Path

import tierod
import tierod_lab

ROOTS = tuple(Path(package.__file__).parent for package in (tierod, tierod_lab))

UNTYPED = frozenset(
    {
        "monitors.friction",
        "monitors",
        "lab.papers.sideslip",
    }
)
"""Packages that are not there yet; one that is leaves the list for good."""


def package_of(path):
    """A package below tierod; of monitors, methods, papers and io each part by itself."""
    product, lab = ROOTS
    parts = path.relative_to(product).parts if path.is_relative_to(product) else ("lab", *path.relative_to(lab).parts)
    deep = {"io": 2, "methods": 2, "monitors": 2, "lab": 3 if parts[1] == "papers" else 2}
    return ".".join(parts[:-1][: deep.get(parts[0], 1)])


def steps(path):
    text = path.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text)) if "def step(" in text else ():
        if isinstance(node, ast.ClassDef):
            yield from (each for each in node.body if isinstance(each, ast.FunctionDef) and each.name == "step")


def untyped(step):
    arguments = step.args
    given = [*[*arguments.posonlyargs, *arguments.args][1:], *arguments.kwonlyargs]
    annotations = {each.arg: each.annotation for each in given} | {"return": step.returns}
    return [
        name
        for name, annotation in annotations.items()
        if annotation is None or any(isinstance(node, ast.Name) and node.id == "Any" for node in ast.walk(annotation))
    ]


def test_every_step_says_what_it_takes_and_gives_and_the_list_only_shrinks():
    lacking = {
        path: found
        for root in ROOTS
        for path in sorted(root.rglob("*.py"))
        if (found := [f"line {step.lineno}: {', '.join(untyped(step))}" for step in steps(path) if untyped(step)])
    }
    new = {path: found for path, found in lacking.items() if package_of(path) not in UNTYPED}
    listed = "\n".join(
        f"{path.relative_to(ROOTS[0].parents[2])} {line}" for path, lines in new.items() for line in lines
    )
    assert not new, f"annotate with Scalar and the block's own State, Sample and Output:\n{listed}"
    typed = UNTYPED - {package_of(path) for path in lacking}
    assert not typed, f"take off the list what is typed now: {sorted(typed)}"
