"""Reference of the command line and index of the Python API, generated from commands and package."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import typer
from docs_text import first_sentence, page, table

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
    """Path below docs/ -> function that returns the text."""
    return {
        "reference/command-line.md": index,
        "reference/python.md": python,
    }


def index() -> str:
    """Page of all commands with their arguments and summaries, and of the exit codes."""
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
    """A command with its arguments, without `tierod`."""
    app = typer.Typer(add_completion=False)
    app.command(verb)(getattr(module_of(verb), verb.replace("-", "_")))
    given = [each for each in typer.main.get_command(app).params if each.param_type_name == "argument"]
    return " ".join((verb, *(_shape(each) for each in given)))


def _shape(argument: Any) -> str:
    shape = argument.name.upper() + ("..." if argument.nargs == -1 else "")
    return shape if argument.required else f"[{shape}]"


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
"""Packages whose docstrings the site shows."""

WITHOUT = {"tierod.core": '\n    options:\n      filters: ["!^_", "!^graph$"]'}
"""Package -> mkdocstrings option that excludes a part listed by itself."""


def python() -> str:
    """Page of every name of `tierod`, and of all packages, whose lines mkdocstrings replaces by the docstrings."""
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
