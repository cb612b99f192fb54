"""Reference of the command line and index of the Python API, generated from commands and package."""

from __future__ import annotations

import importlib
import inspect
import textwrap
import typing
from collections.abc import Callable
from pathlib import Path
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
    every: dict[str, Callable[[], str]] = {f"reference/cli/{verb}.md": _page_of(verb) for verb in commands()}
    python = {"index": python_index, "tierod": tierod_page, "packages": packages_page}
    return {
        "reference/cli/index.md": index,
        **every,
        **{f"reference/python/{name}.md": it for name, it in python.items()},
    }


def _page_of(verb: str) -> Callable[[], str]:
    return lambda: command_page(verb)


def index() -> str:
    """Page of all commands with their summaries, and of the exit codes."""
    rows = [(f"[`{verb}`]({verb}.md)", first_sentence(module_of(verb).__doc__).split(". ")[0]) for verb in commands()]
    return page(
        "Command line",
        "`tierod COMMAND ...`: a verb, its input, its options. With `--json` a command prints one JSON document to "
        "stdout; everything else goes to stderr.",
        table(("command", "what it does"), rows),
        "## Options of every command",
        table(
            ("option", "meaning"),
            (
                ("`--help`, `-h`", "the arguments and options of a command"),
                ("`--debug`", "the traceback of an error"),
                ("`--version`", "the version; without a command"),
            ),
        ),
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
                (
                    "`TIEROD_CFLAGS`",
                    "more options for the compiler, after ours: `-O1` compiles in a third of the time and runs up to "
                    "a third slower, with the same numbers",
                ),
                ("`TIEROD_ENGINE`", "`auto`, `compiled` or `virtual machine`: how blocks run"),
                (
                    "`TIEROD_GRAPHS`",
                    "`known`, as on the command line: graphs that an earlier process traced are taken from the cache; "
                    "`traced`: they are not",
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


def command_page(verb: str) -> str:
    """Page of one command: usage, description, arguments and options."""
    function = getattr(module_of(verb), verb.replace("-", "_"))
    hints = typing.get_type_hints(function)
    app = typer.Typer(add_completion=False)
    app.command(verb)(function)
    command = typer.main.get_command(app)
    arguments = [each for each in command.params if each.param_type_name == "argument"]
    options = [each for each in command.params if each.param_type_name == "option" and each.name != "help"]
    first, _, rest = inspect.cleandoc(function.__doc__ or "").partition("\n\n")
    parts = [" ".join(first.split())]
    usage = " ".join((f"tierod {verb}", *(_shape(each) for each in arguments), *(["[OPTIONS]"] if options else [])))
    parts.append(f"```text\n{usage}\n```")
    if rest:
        parts.append(f"```text\n{textwrap.dedent(rest).strip()}\n```")
    if arguments:
        rows = [(f"`{each.name.upper()}`", _kind(each, hints[each.name]), _meaning(each)) for each in arguments]
        parts += ["## Arguments", table(("argument", "value", "meaning"), rows)]
    if options:
        rows = [
            (", ".join(f"`{name}`" for name in _names(each)), _kind(each, hints[each.name]), _meaning(each))
            for each in options
        ]
        parts += ["## Options", table(("option", "value", "meaning"), rows)]
    return page(f"tierod {verb}", *parts)


def _names(option: Any) -> list[str]:
    return [*option.opts, *option.secondary_opts]


def _shape(argument: Any) -> str:
    shape = argument.name.upper() + ("..." if argument.nargs == -1 else "")
    return shape if argument.required else f"[{shape}]"


WORDS = {str: "text", int: "whole number", float: "number", Path: "path"}
"""Type of an argument -> its name in the table."""


def _kind(parameter: Any, hint: Any) -> str:
    if hint is bool:
        return "flag"
    inner = [each for each in typing.get_args(hint) if each is not type(None)]
    if typing.get_origin(hint) in (list, tuple):
        return f"{WORDS.get(inner[0], 'text')}, several"
    if typing.get_origin(hint) is typing.Literal:
        return " or ".join(f"`{choice}`" for choice in inner)
    return _kind(parameter, inner[0]) if inner else WORDS.get(hint, "text")


def _meaning(parameter: Any) -> str:
    help_ = (parameter.help or "").strip()
    help_ = help_[:1].upper() + help_[1:] + ("" if not help_ or help_.endswith((".", "?")) else ".")
    default = parameter.default
    shown = default is not None and not callable(default) and default not in (False, "", (), [])
    if shown and not getattr(parameter, "is_flag", False):
        help_ += f" Default: `{default}`."
    elif shown:
        help_ += " Default: on."
    return help_ + (" Required." if parameter.required and parameter.param_type_name == "option" else "")


def python_index() -> str:
    """Page of every name of `tierod` with its module and the first sentence of its docstring."""
    rows = []
    for name in dir(tierod):
        if name.startswith("__"):
            continue
        value = getattr(tierod, name)
        home = getattr(value, "__module__", None) or value.__name__
        rows.append((f"[`tierod.{name}`](tierod.md)", f"`{home}`", first_sentence(value.__doc__)))
    return page(
        "Python API",
        "`import tierod` gives these names; each is imported when it is first used. The pages of this section hold the "
        "docstrings of every public module, class and function.",
        table(("name", "module", "what it is"), rows),
        "## Packages",
        table(("package", "what lives there"), _packages()),
    )


PACKAGES = (
    "tierod.core",
    "tierod.core.graph",
    "tierod.physics",
    "tierod.models",
    "tierod.methods",
    "tierod.io",
    "tierod.vehicles",
    "tierod.diagnosis",
    "tierod.monitors.harness",
    "tierod.report",
    "tierod_lab.ground",
    "tierod_lab.campaign",
)
"""Packages whose docstrings the site shows."""

WITHOUT = {"tierod.core": '\n    options:\n      filters: ["!^_", "!^graph$"]'}
"""Package -> mkdocstrings option that excludes a part listed by itself."""


def _packages() -> list[tuple[str, str]]:
    return [(f"`{name}`", first_sentence(importlib.import_module(name).__doc__)) for name in PACKAGES]


def packages_page() -> str:
    """Page of all packages, whose last lines mkdocstrings replaces by the docstrings."""
    return page(
        "Packages",
        "The site shows here the docstrings of every module; in a terminal `python -c \"help('tierod.core')\"` does.",
        *(f"::: {name}" + WITHOUT.get(name, "") for name in PACKAGES),
    )


def tierod_page() -> str:
    """Page of the docstrings of the names of `tierod`."""
    homes = []
    for name in dir(tierod):
        value = getattr(tierod, name)
        if inspect.isclass(value) or inspect.isfunction(value):
            # Links to these objects must lead to the pages of their packages.
            home = f"{value.__module__}.{value.__qualname__}"
            homes.append(f"::: {home}\n    options:\n      skip_local_inventory: true\n      show_root_toc_entry: true")
    return page("tierod", "Docstrings of what `import tierod` gives.", *homes)
