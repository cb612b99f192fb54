"""What a block takes and gives is typed: no `step` has `Any` among its annotations."""

import ast
from pathlib import Path

import tierod

ROOT = Path(tierod.__file__).parent

UNTYPED = frozenset(
    {
        "experiments",
        "monitors.friction",
        "monitors.harness",
        "papers.sideslip",
    }
)
"""Packages that are not there yet; one that is leaves the list for good."""


def package_of(path):
    """A package below tierod; of monitors, methods, papers and io each part by itself."""
    parts = path.relative_to(ROOT).parent.parts
    return ".".join(parts[:2] if parts[:1] and parts[0] in ("io", "methods", "monitors", "papers") else parts[:1])


def steps(path):
    """Every method `step` of a file."""
    text = path.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text)) if "def step(" in text else ():
        if isinstance(node, ast.ClassDef):
            yield from (each for each in node.body if isinstance(each, ast.FunctionDef) and each.name == "step")


def untyped(step):
    """What of a function has no annotation, or one with `Any` in it."""
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
        for path in sorted(ROOT.rglob("*.py"))
        if (found := [f"line {step.lineno}: {', '.join(untyped(step))}" for step in steps(path) if untyped(step)])
    }
    new = {path: found for path, found in lacking.items() if package_of(path) not in UNTYPED}
    listed = "\n".join(f"{path.relative_to(ROOT)} {line}" for path, lines in new.items() for line in lines)
    assert not new, f"annotate with Scalar and the block's own State, Sample and Output:\n{listed}"
    typed = UNTYPED - {package_of(path) for path in lacking}
    assert not typed, f"take off the list what is typed now: {sorted(typed)}"
