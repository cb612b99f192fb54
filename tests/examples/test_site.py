"""The pages of docs/: generated ones are up to date, every page is short and in the navigation, the site builds."""

import ast
import functools
import importlib
import re
import sys
from pathlib import Path

import pytest

import tierod

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(page.relative_to(DOCS).as_posix() for page in DOCS.rglob("*.md"))
HAND_WRITTEN = [page for page in PAGES if "; do not edit. -->" not in (DOCS / page).read_text(encoding="utf-8")[:300]]
ENTRY_POINTS = {f'"tierod.{kind}"' for kind in ("monitors", "readers", "writers", "vehicles", "faults", "scenarios")}
MOST_WORDS = 2500
MOST_WORDS_OF_A_STUDY = 4000


def words(text):
    """Words of a page: whatever holds a letter or a digit, without comments and the addresses of links."""
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"\]\([^)]*\)", "]", text)
    return sum(bool(re.search(r"\w", word)) for word in re.split(r"[\s|]+", text))


def test_no_page_is_long():
    for page in PAGES:
        most = MOST_WORDS_OF_A_STUDY if page.startswith("reference/studies/") else MOST_WORDS
        assert words((DOCS / page).read_text(encoding="utf-8")) <= most, page


def test_every_page_is_in_the_navigation_once():
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:\n")[2]
    assert sorted(re.findall(r"[\w/-]+\.md$", navigation, re.MULTILINE)) == PAGES


@pytest.fixture(scope="module")
def generator():
    """The scripts that write pages, which import each other by name."""
    sys.path.insert(0, str(ROOT / "scripts"))
    try:
        yield importlib.import_module("docs"), importlib.import_module("study_docs")
    finally:
        sys.path.remove(str(ROOT / "scripts"))


def test_generated_pages_are_up_to_date(generator):
    assert generator[0].stale() == [], "run: make docs"


def test_the_layers_of_the_page_are_those_of_the_imports():
    source = (ROOT / "tests" / "contract" / "test_imports.py").read_text(encoding="utf-8")
    assigned = next(
        node.value
        for node in ast.parse(source).body
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "LAYERS"
    )
    page = (DOCS / "explanation" / "architecture.md").read_text(encoding="utf-8").partition("## Layers")[2]
    rows = [set(re.findall(r"`([\w.]+)`", row)) for row in re.findall(r"^\| (`.*) \|$", page, re.MULTILINE)]
    assert tuple(rows[: len(ast.literal_eval(assigned))]) == ast.literal_eval(assigned)


@functools.cache
def vocabulary():
    """Every word of the code, its data and the Makefile."""
    files = [
        path
        for folder in ("packages", "tests", "scripts", "benchmarks", "examples")
        for path in (ROOT / folder).rglob("*")
    ]
    texts = [path.read_text(encoding="utf-8") for path in files if path.suffix in (".py", ".toml", ".json", ".dbc")]
    texts += [(ROOT / name).read_text(encoding="utf-8") for name in ("Makefile", "pyproject.toml")]
    found = {word for text in texts for word in re.findall(r"\w+", text)} | {path.stem for path in files}
    return {word.lower() for word in found}


def resolved(name):
    """Whether a dotted name is a module of tierod, or an attribute of one, as deep as it goes."""
    value, parts = tierod, name.split(".")[1:]
    for place, part in enumerate(parts, 2):
        try:
            value = getattr(value, part)
        except AttributeError:
            try:
                value = importlib.import_module(".".join(["tierod", *parts[: place - 1]]))
            except ImportError:
                return False
    return True


@pytest.mark.parametrize("page", [*HAND_WRITTEN, "../README.md", "../CONTRIBUTING.md"])
def test_names_of_the_code_on_a_page_exist(page):
    text = re.sub(r"```.*?```", "", (DOCS / page).read_text(encoding="utf-8"), flags=re.DOTALL)
    quoted = re.findall(r"`([^`\n]+)`", text)
    dotted = {found for code in quoted for found in re.findall(r"\btierod(?:\.\w+)+", code)}
    assert {name for name in dotted if not resolved(name) and f'"{name}"' not in ENTRY_POINTS} == set()
    single = {code.removesuffix("()").lower() for code in quoted if re.fullmatch(r"[A-Za-z]\w*(\(\))?", code)}
    assert single - vocabulary() - {"site", "sideslip_angle_deviation"} == set()
    paths = {
        found for code in quoted for found in re.findall(r"^(?:tests|scripts|examples|benchmarks)/[\w./-]+$", code)
    }
    assert {path for path in paths if not (ROOT / path).exists()} == set()
