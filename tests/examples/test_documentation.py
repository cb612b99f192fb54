"""Every block of README, docs and docstrings runs.

```python blocks of a page run one after another, in one namespace, in a folder that holds the drives below.
```console blocks run through the command line where `<!-- run -->` stands before them; everywhere their commands exist.
"""

import doctest
import importlib
import json
import pkgutil
import re
import shlex
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path

import jsonschema
import pytest

import tierod
import tierod_lab
from tierod.cli import main
from tierod.cli.app import commands

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
SCHEMA = json.loads((ROOT / "packages/tierod/src/tierod/report/diagnosis.schema.json").read_text(encoding="utf-8"))
MODULES = sorted(
    module.name
    for package in (tierod, tierod_lab)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    if not module.name.endswith("__main__")
)
WITH_EXAMPLES = [
    name for name in MODULES if re.search(r"```|>>>", Path(find_spec(name).origin).read_text(encoding="utf-8"))
]
BLOCK = re.compile(r"(<!-- run -->\n)?```(\w+)\n(.*?)```", re.DOTALL)


def name_of(page):
    return page.relative_to(ROOT).as_posix()


def blocks(text, language):
    """(first line, code, marked to be run) of every fenced block in a language."""
    for found in BLOCK.finditer(text):
        if found[2] == language:
            yield text[: found.start(3)].count("\n") + 1, found[3], bool(found[1])


@pytest.fixture(scope="session")
def drives(tmp_path_factory):
    """A folder with the recordings that the pages speak of."""
    from tierod.diagnosis.fault_memory import FaultMemory
    from tierod.io.writers import write
    from tierod_lab.ground import FrictionCourse, drive

    folder = tmp_path_factory.mktemp("drives")
    recording = drive(minutes=4.0, friction=FrictionCourse.step(4.0, 8.0, at=120.0), seed=1)
    for ending in ("parquet", "mf4", "csv"):
        write(recording, folder / f"drive.{ending}")
    scenarios = {"column-bench-hands": "hands", "steer-by-wire-sideslip": "sideslip", "demonstrator-lap": "lap"}
    for scenario, name in scenarios.items():
        assert main(["simulate", scenario, "--seconds", "20", "-o", str(folder / f"{name}.parquet")]) == 0
    memory = FaultMemory.opened(folder / "memory.json", "midsize-eps")
    memory.begin_cycle()
    memory.end_cycle()
    return folder


@pytest.fixture
def folder(drives, tmp_path, monkeypatch):
    for path in drives.iterdir():
        # No symbolic link: what a page writes anew would go through it to the pages after.
        (tmp_path / path.name).hardlink_to(path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


WITH_PYTHON = [page for page in PAGES if list(blocks(page.read_text(encoding="utf-8"), "python"))]


@pytest.mark.parametrize("page", WITH_PYTHON, ids=name_of)
def test_python_of_a_page_runs(page, folder):
    run_page(page.read_text(encoding="utf-8"), str(page))


def run_page(text, name):
    module = type(sys)("example")
    sys.modules["example"] = module
    try:
        for line, code, _ in blocks(text, "python"):
            exec(compile("\n" * line + code, name, "exec"), vars(module))
    finally:
        del sys.modules["example"]


def commands_of(page):
    for language in ("console", "sh"):
        for line, code, marked in blocks(page.read_text(encoding="utf-8"), language):
            for offset, row in enumerate(code.splitlines()):
                command = row.removeprefix("$ ").partition(" #")[0].strip()
                if command.startswith("tierod"):
                    yield line + offset, command, marked


WITH_COMMANDS = [page for page in PAGES if list(commands_of(page))]


EXPORTING = [ROOT / "docs/how-to/fmu.md", ROOT / "docs/how-to/control-unit.md"]
"""Pages whose commands compile for seconds; cli/test_export and export/ run the same exports."""

RUNS = [(page, page not in EXPORTING) for page in WITH_COMMANDS]


@pytest.mark.parametrize(
    ("page", "run"),
    [*RUNS, *(pytest.param(page, True, marks=pytest.mark.slow) for page in EXPORTING)],
    ids=lambda given: name_of(given) if isinstance(given, Path) else "run" if given else "exist",
)
def test_commands_of_a_page_exist_and_run_where_marked(page, run, folder, capsys):
    """Those that run do so one after another in one folder: a later one reads what an earlier one wrote."""
    for line, command, marked in commands_of(page):
        verb, *arguments = shlex.split(command)[1:]
        assert verb in commands(), line
        if not (marked and run):
            options = {argument for argument in arguments if argument.startswith("--")}
            assert main([verb, "--help"]) == 0
            known = set(re.findall(r"--[a-z-]+", capsys.readouterr().out))
            assert options <= known, line
            continue
        assert main([verb, *arguments]) in (0, 1, 2), line
        printed = capsys.readouterr().out
        assert printed, line
        if "--json" in arguments:
            jsonschema.validate(json.loads(printed), SCHEMA)


def test_toml_of_every_page_is_valid():
    for page in PAGES:
        for line, code, _ in blocks(page.read_text(encoding="utf-8"), "toml"):
            try:
                tomllib.loads(code)
            except tomllib.TOMLDecodeError as error:
                pytest.fail(f"{name_of(page)}, block of line {line}: {error}")


def test_links_of_every_page_lead_somewhere():
    for page in PAGES:
        links_lead_somewhere(page)


def links_lead_somewhere(page):
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith(("http://", "https://", "mailto:")):
            continue
        name, _, heading = target.partition("#")
        there = (page.parent / name).resolve() if name else page
        assert there.exists(), f"{page.name} links to {target}"
        if heading:
            assert heading in anchors(there.read_text(encoding="utf-8")), f"{page.name} links to {target}"


def anchors(text):
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_examples_in_docstrings_run(name, folder):
    module = importlib.import_module(name)
    results = doctest.testmod(module, optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    assert results.failed == 0
    for value in [module, *vars(module).values()]:
        if getattr(value, "__module__", name) == name and isinstance(getattr(value, "__doc__", None), str):
            run_page(value.__doc__, name)
