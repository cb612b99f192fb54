"""Reference of the command line, of the JSON documents, and index of the Python API."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import typer
from docs_text import first_sentence, names, page, table

import tierod
from tierod.cli.app import commands, module_of

EXIT_CODES = (
    ("0", "healthy, or done"),
    ("1", "fault; a missed pass criterion of a campaign"),
    ("2", "no verdict was possible"),
    ("3", "wrong input or usage"),
    ("4", "a defect of tierod itself"),
    ("130", "stopped by Ctrl-C or SIGTERM; no half-written file remains"),
    ("141", "the reader of the output closed it before a verdict was known"),
)


def pages() -> dict[str, Callable[[], str]]:
    return {
        "reference/command-line.md": index,
        "reference/python.md": python,
        "reference/json.md": schemas_page,
    }


def index() -> str:
    rows = [(f"`{_usage(verb)}`", first_sentence(module_of(verb).__doc__).split(". ")[0]) for verb in commands()]
    return page(
        "Command line",
        "`tierod COMMAND --help` explains all options of a command. With `--json` a command prints one JSON document "
        "to stdout; everything else goes to stderr.",
        table(("`tierod ...`", "what it does"), rows),
        "Every command knows `--help` and `--debug`, which shows the traceback of an error.",
        "## Exit codes",
        table(("code", "meaning"), EXIT_CODES),
        "## Environment variables",
        table(
            ("variable", "meaning"),
            (
                (
                    "`TIEROD_CC`",
                    "the C compiler, empty for none; `cc`, `gcc`, `clang` or the wheel `ziglang` otherwise",
                ),
                ("`TIEROD_CFLAGS`", "more options for the compiler, after ours"),
                ("`TIEROD_ENGINE`", "`auto`, `compiled` or `virtual machine`: how blocks run"),
                (
                    "`TIEROD_GRAPHS`",
                    "`known`: graphs that an earlier process traced are used, as by commands; or `traced`",
                ),
                ("`TIEROD_CACHE`", "folder of compiled kernels; `~/.cache/tierod` where it is not set"),
                ("`TIEROD_LARGEST`", "largest unpacked recording, such as `8GB`; 1.1 GB where it is not set"),
                (
                    "`TIEROD_DATA`",
                    "folder of recordings of real cars for studies and tests; `../shared/data` otherwise",
                ),
            ),
        ),
    )


def _usage(verb: str) -> str:
    app = typer.Typer(add_completion=False)
    app.command(verb)(getattr(module_of(verb), verb.replace("-", "_")))
    given = [each for each in typer.main.get_command(app).params if each.param_type_name == "argument"]
    return " ".join((verb, *(_shape(each) for each in given)))


def _shape(argument: Any) -> str:
    shape = argument.name.upper() + ("..." if argument.nargs == -1 else "")
    return shape if argument.required else f"[{shape}]"


# Packages whose docstrings the site shows
PACKAGES = (
    "tierod.core",
    "tierod.core.graph",
    "tierod.physics",
    "tierod.models",
    "tierod.methods",
    "tierod.io",
    "tierod.vehicles",
    "tierod.diagnosis",
    "tierod.monitors.diagnose",
    "tierod.monitors.inspection",
    "tierod.monitors.session",
    "tierod.report",
    "tierod_lab.ground",
    "tierod_lab.campaign",
)

# Package -> mkdocstrings option that excludes a part listed by itself
WITHOUT = {"tierod.core": '\n    options:\n      filters: ["!^_", "!^graph$"]'}


def python() -> str:
    rows = []
    for name in dir(tierod):
        if not name.startswith("__"):
            rows.append((f"`{name}`", first_sentence(getattr(tierod, name).__doc__)))
    return page(
        "Python API",
        "`import tierod` gives these names; each is imported when it is first used. `help(tierod.diagnose)` prints a "
        "docstring with its arguments.",
        table(("name of `tierod`", "what it is"), rows),
        "## Packages",
        "The site shows here the docstrings of every module; in a terminal `help()` prints them.",
        *(f"::: {name}" + WITHOUT.get(name, "") for name in PACKAGES),
    )


# Name -> package that contains the schema, and origin of the document
SCHEMAS = {
    "diagnosis": ("tierod.report", "`tierod diagnose --json`; `tierod.to_json(diagnosis)` gives the same text"),
    "diagnoses": ("tierod.report", "`tierod diagnose --json` of several recordings or all monitors"),
    "campaign": ("tierod_lab.campaign", "`tierod campaign`, as `campaign.json`"),
    "fleet": ("tierod.fleet", "`tierod fleet report`, as `fleet.json` or with `--json`"),
    "claims": ("tierod.core", "`tierod study`, as `claims.json`: a list with one object for each claim"),
}

# Fields that most documents share
COMMON = ("schema", "version", "created", "command", "status", "symbol", "colour", "exit_code")


def schemas_page() -> str:
    rows = []
    for name, (package, origin) in SCHEMAS.items():
        schema = json.loads(files(package).joinpath(f"{name}.schema.json").read_text(encoding="utf-8"))
        fields = [field for field in _fields(schema) if field not in COMMON]
        rows.append((f"`{name}`", origin, f"`{package}`", names(fields)))
    return page(
        "JSON documents",
        "A schema (draft 2020-12) describes every field of a document; it is installed with its package as "
        "`NAME.schema.json`. This prints what the fields of a diagnosis mean:",
        "```python\nimport json\nfrom importlib.resources import files\n\n"
        'file = files("tierod.report").joinpath("diagnosis.schema.json")\n'
        'schema = json.loads(file.read_text(encoding="utf-8"))\n'
        'for name, field in schema["properties"].items():\n    print(name, field["description"])\n```',
        table(("document", "written by", "schema in", "fields"), rows),
        "Documents also hold `schema` (name and version, which rises when a field goes or changes its meaning), "
        "`version` (of tierod), `created` (UTC) and `command`, and those with a verdict `status`, `symbol`, `colour` "
        "and `exit_code` as [the table of statuses](words.md) has them. Numbers are in SI units whatever a report "
        "shows. What could not be computed is `null`, never NaN. `traces`, `histograms` and `loops` of a diagnosis are "
        "filled by `tierod.to_json(diagnosis, series=True)`.",
    )


def _fields(schema: dict[str, Any]) -> list[str]:
    if schema.get("type") == "array":
        items = schema["items"]
        return _fields(schema["$defs"][items["$ref"].rpartition("/")[2]] if "$ref" in items else items)
    return list(schema["properties"])
