"""Imports point downwards only; libraries have one door, and nothing heavy is imported before it is needed."""

import ast
import graphlib
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import tierod
import tierod_lab

ROOT, LAB = (Path(package.__file__).parent for package in (tierod, tierod_lab))

LAYERS = (
    {"lab.cli", "lab.web"},
    {"lab.papers"},
    {"lab.studies", "lab.methods"},
    {"lab.campaign", "lab.fleet"},
    {"cli"},
    {"web"},
    {"fleet"},
    {"export", "live", "report"},
    {"work"},
    {"monitors"},
    {"diagnosis"},
    {"methods", "io", "vehicles"},
    {"models"},
    {"physics"},
    {"core.graph"},
    {"core"},
)
"""Highest first; neighbours in one layer may use each other."""

FRONT = ROOT / "__init__.py"  # Names everything for users, and imports nothing before it is used

GROUND = "lab.ground"
GROUND_USES = {GROUND, "physics", "core.graph", "vehicles", "core"}

HEAVY = {
    "asammdf",
    "can",
    "cantools",
    "casadi",
    "h5py",
    "jinja2",
    "mcap",
    "pandas",
    "pint",
    "plotly",
    "pyarrow",
    "rich",
    "rosbags",
    "typer",
    "websockets",
}
HEAVY_PARTS = {"scipy.signal", "scipy.optimize"}

FILES = sorted([*ROOT.rglob("*.py"), *LAB.rglob("*.py")])
FILE_SET = set(FILES)


def part_of(module):
    """The layer of a dotted name: a package below tierod, one of its packages with a layer of its own, or of the lab.

    `tierod` itself only offers names from everywhere, and `__main__` is the command line.
    """
    names = module.split(".")
    if names[0] == "tierod_lab":
        return f"lab.{names[1]}" if names[1:] and names[1] != "version" else "lab.cli"
    if names[1:] in ([], ["__main__"]):
        return "cli"
    nested = ".".join(names[1:3])
    return nested if any(nested in layer for layer in LAYERS) else names[1]


def module_of(path):
    root = ROOT if path.is_relative_to(ROOT) else LAB
    return ".".join((root.name, *path.relative_to(root).with_suffix("").parts)).removesuffix(".__init__")


@cache
def imports(path):
    """(absolute name, whether it is taken on import of the module, line) of every import of a file."""
    return tuple(found_in(ast.parse(path.read_text(encoding="utf-8")), path))


def found_in(tree, path):
    package = module_of(path).split(".")
    package = package if path.name == "__init__.py" else package[:-1]
    for node, at_once in statements(tree.body):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, at_once, node.lineno
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            stem = ".".join(filter(None, (base, node.module)))
            for alias in node.names:
                yield f"{stem}.{alias.name}", at_once, node.lineno


def statements(nodes, at_once=True):
    """Every statement with whether it runs on import; expressions, which hold none, are not searched."""
    for node in nodes:
        yield node, at_once
        for part in ("body", "orelse", "finalbody", "handlers", "cases"):
            yield from statements(getattr(node, part, ()), at_once and not is_late(node))


def is_late(node):
    """Functions run later, and TYPE_CHECKING never."""
    if isinstance(node, ast.If):
        return "TYPE_CHECKING" in ast.dump(node.test)
    return isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)


def allowed(importer, imported):
    if GROUND in (importer, imported):
        return imported in GROUND_USES if importer == GROUND else importer.startswith("lab.")
    depth = {part: depth for depth, layer in enumerate(LAYERS) for part in layer}
    return depth[importer] <= depth[imported]


def violations(path):
    """What a file imports that its layer may not use, or that is heavy and imported at once."""
    here = part_of(module_of(path))
    for name, at_once, line in imports(path):
        place, first = f"{path.relative_to(ROOT.parents[2])}:{line} imports {name}", name.split(".")[0]
        if first in (ROOT.name, LAB.name) and path != FRONT and not allowed(here, part_of(name)):
            yield f"{place}: {here} may not use {part_of(name)}"
        if first == "casadi" and here != "core.graph":
            yield f"{place}: only tierod.core.graph may"
        heavy = first in HEAVY or any(name.startswith(part) for part in HEAVY_PARTS)
        if heavy and at_once and (here.removeprefix("lab."), first) != ("cli", "typer"):
            yield f"{place} at its top: move it into the function"


def test_modules_import_downwards_only_and_hide_what_is_heavy():
    found = [each for path in FILES for each in violations(path)]
    assert not found, "\n".join(found)


def file_of(name):
    """The file that a dotted name leads to: a module, or the module that holds the name; None outside the package."""
    first, *parts = name.split(".")
    root = {ROOT.name: ROOT, LAB.name: LAB}.get(first)
    for count in range(len(parts) if root else 0, 0, -1):
        path = root.joinpath(*parts[:count])
        for candidate in (path.with_suffix(".py"), path / "__init__.py"):
            if candidate in FILE_SET:
                return candidate
    return None


def test_no_file_imports_itself_over_others():
    graph = {
        path: {found for name, _, _ in imports(path) if (found := file_of(name)) not in (None, path)}
        for path in FILES
        if path != FRONT
    }
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        circle = " -> ".join(module_of(path) for path in error.args[1])
        pytest.fail(f"a circle of files: {circle}; move what both need into a file of its own")


def test_every_package_has_its_place():
    folders = [*((path.name, path) for path in ROOT.iterdir()), *((f"lab.{path.name}", path) for path in LAB.iterdir())]
    packages = {name for name, path in folders if path.is_dir() and list(path.glob("*.py"))}
    assert packages <= set().union(*LAYERS) | {GROUND}


def loaded_after(statement):
    code = f"import sys\n{statement}\nprint('\\n'.join(sys.modules), file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stderr.split())


@pytest.mark.parametrize(
    ("statement", "more"),
    [
        ("import tierod", {"numpy", "scipy", "pydantic"}),
        ("from tierod.cli import main; main(['--version'])", {"numpy", "scipy", "pydantic"}),
        ("from tierod.cli import main; main(['--help'])", {"numpy", "scipy", "pydantic"}),
        ("import tierod.monitors.diagnose", {"scipy.signal", "scipy.optimize"}),
        ("import tierod.report", set()),
        ("import tierod.io.readers", set()),
    ],
)
def test_nothing_heavy_is_loaded_before_it_is_needed(statement, more):
    needed = {"typer"} if "--help" in statement else set()
    assert not loaded_after(statement) & ((HEAVY | HEAVY_PARTS | more) - needed)
