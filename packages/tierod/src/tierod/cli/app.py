"""Finds the command of a verb, runs it, and turns every error into one line and an exit code.

Every other module of this package is a command: a docstring whose first line is its summary, and a function named like
the module, with typer annotations, that returns an exit code (or None for 0). A new file is a new command.
"""

from __future__ import annotations

import errno
import importlib
import os
import pkgutil
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, TextIO

from tierod.cli.streams import abandon_output, complain
from tierod.cli.terminal import spell_what_cannot_be_shown, visible
from tierod.core import plugins as lab
from tierod.core.errors import KernelWarning, PluginWarning, TierodError, lacks_memory, nearest

HEALTHY, FAULT, NOT_JUDGED, BAD_INPUT, DEFECT, INTERRUPTED, UNHEARD = 0, 1, 2, 3, 4, 130, 141
"""Exit codes.

DEFECT means an error in tierod itself, INTERRUPTED that the user stopped it, and UNHEARD (128 + SIGPIPE) that the
reader of the output closed it before a verdict was available.
"""

COMPLETION = ("--install-completion", "--show-completion")
"""Options of typer that enable the completion of commands and options in a shell."""

COMPLETE = "_TIEROD_COMPLETE"  # Variable of the environment in which a shell asks for completions

LONGEST_SENTENCE = 1200
"""Largest number of characters of an error that are printed: a name in a damaged file may be as long as the file."""

_LOOP = "Symlink loop from "
"""Beginning of the error that Python before 3.13 raises when it resolves a symbolic link to itself."""

_NOT_COMMANDS = {
    "app",
    "examples",
    "export_c",
    "export_fmu",
    "streams",
    "terminal",
}

_GROUPS = {
    "Begin": ("demo", "inspect", "new", "diagnose", "serve"),
    "Follow a car or a fleet": ("fleet", "live", "replay", "faults"),
    "Virtual car": ("scenarios", "simulate", "campaign", "study"),
    "Expert": ("convert", "design", "export", "formats", "identify", "isolability", "monitors", "vehicles"),
}

_HEADER = """\
Estimate what cannot be measured in a steering system, and find what is going wrong in it.

Usage: tierod COMMAND ...
"""
_FOOTER = """
  --version        print the version
  --install-completion   let the shell complete commands and options
  --debug          with any command: show the traceback of an error
  --help           with any command: its arguments and options

Exit codes: 0 healthy or done, 1 fault, 2 could not judge, 3 bad input or usage, 4 a defect of tierod itself.
"""


def commands() -> tuple[str, ...]:
    """All verbs as they are typed."""
    return tuple(sorted((*_own(), *(lab.VERBS if lab.installed() else ()))))


@cache
def _own() -> tuple[str, ...]:
    modules = (module.name for module in pkgutil.iter_modules([str(Path(__file__).parent)]))
    return tuple(sorted(name.replace("_", "-") for name in modules if name not in _NOT_COMMANDS))


def run(arguments: Sequence[str]) -> int:
    """Run a verb with its arguments, and return the exit code."""
    debug, code = "--debug" in arguments, UNHEARD
    spell_what_cannot_be_shown()
    try:
        with warnings.catch_warnings():
            warnings.showwarning = Warnings(debug).show
            code = _dispatch([argument for argument in arguments if argument != "--debug"])
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        abandon_output()
        return code
    except (Exception, KeyboardInterrupt) as error:
        if debug:
            raise
        code, sentence = _explain(error)
        complain(visible(_shortened(sentence)))
        return code


class Warnings:
    """Prints warnings during one command: tierod's own as sentences, the first one of a library as one sentence.

    Args:
        debug: whether to print every warning of a library with its place in the code
    """

    def __init__(self, debug: bool):
        self._debug, self._said = debug, False

    def show(
        self,
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        """Print a warning; the signature is that of `warnings.showwarning`."""
        text = " ".join(str(message).split())
        if issubclass(category, KernelWarning | PluginWarning):
            complain(text)
        elif self._debug:
            complain(f"{filename}:{lineno}: {category.__name__}: {text}")
        elif not self._said:
            self._said = True
            complain(f"a library warns of '{text[:200]}'; the same command with --debug says where")


def _shortened(sentence: str) -> str:
    """The sentence, without its middle if it is very long: the error comes first, the remedy last."""
    if len(sentence) <= LONGEST_SENTENCE:
        return sentence
    return f"{sentence[: LONGEST_SENTENCE // 2]} ... {sentence[-LONGEST_SENTENCE // 2 :]}"


def _dispatch(arguments: Sequence[str]) -> int:
    if COMPLETE in os.environ or (arguments[:1] and arguments[0] in COMPLETION):
        return _complete(arguments)
    if not arguments or arguments[0] in ("--help", "-h"):
        print(_overview(), file=sys.stdout if arguments else sys.stderr)
        return HEALTHY if arguments else BAD_INPUT
    verb, *rest = arguments
    if verb not in (*_own(), *lab.VERBS):
        raise _Usage(f"there is no command '{verb}'{nearest(verb, commands())} See 'tierod --help'")
    return _call(verb, rest)


def _call(verb: str, arguments: Sequence[str]) -> int:
    import typer

    # typer has no public name for its usage errors, the base of BadParameter; they exit with 2, here "could not judge".
    usage_error: type[Exception] = typer.BadParameter.__mro__[1]
    try:
        code = parser(verb, _below_help(verb, arguments)).main(
            list(arguments), prog_name=f"tierod {verb}", standalone_mode=False
        )
    except usage_error as error:
        sentence = error.format_message().rstrip(".")  # type: ignore[attr-defined]
        raise _Usage(f"{sentence}; see 'tierod {verb} --help'") from error
    except SystemExit as ended:
        # typer exits with 1 if stdout is closed, which here means a fault.
        raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE)) from ended
    if code == INTERRUPTED:
        raise KeyboardInterrupt  # typer turns Ctrl-C into this exit code
    return code if isinstance(code, int) else HEALTHY


def parser(verb: str, epilog: str | None = None) -> Any:
    import typer

    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command(verb, epilog=epilog, context_settings={"help_option_names": ["-h", "--help"]})(_function(verb))
    command = typer.main.get_command(app)
    # rich takes brackets for markup, and would drop a unit such as [s].
    for parameter in command.params:
        vars(parameter)["help"] = (getattr(parameter, "help", None) or "").replace("[", "\\[")
    command.help = (command.help or "").replace("[", "\\[")
    return command


def _complete(arguments: Sequence[str]) -> int:
    """Let typer install or print the completion of a shell, or answer a shell that asks."""
    import typer

    app = typer.Typer()
    for verb in commands():
        app.command(verb)(_function(verb))
    try:
        typer.main.get_command(app).main(list(arguments), prog_name="tierod", standalone_mode=False)
    except SystemExit as ended:
        return int(ended.code or HEALTHY)
    return HEALTHY


def _below_help(verb: str, arguments: Sequence[str]) -> str | None:
    """Examples and names below the help; made only if help is requested, since listing the names takes time."""
    if "--help" not in arguments and "-h" not in arguments:
        return None
    from tierod.cli import examples

    of_verb = lab.part("verbs", f"'tierod {verb}'") if verb in lab.VERBS else examples
    lines = [f"Example: {each}" for each in of_verb.EXAMPLES.get(verb, ())]
    for parameter in parser(verb).params:
        argument = parameter.param_type_name == "argument"
        if names := of_verb.names_of(f"{verb} {parameter.name}" if argument else parameter.opts[0]):
            lines.append(f"{parameter.name if argument else parameter.opts[0]}: {', '.join(names)}")
    return "\n\n".join(line.replace("[", "\\[") for line in lines) or None


def module_of(verb: str) -> ModuleType:
    package = lab.part("verbs", f"'tierod {verb}'").__name__ if verb in lab.VERBS else __package__
    return importlib.import_module(f"{package}.{verb.replace('-', '_')}")


def _function(verb: str) -> Callable[..., int | None]:
    module = module_of(verb)
    command: Callable[..., int | None] = getattr(module, module.__name__.rpartition(".")[2])
    return command


def _overview() -> str:
    rest = [verb for verb in commands() if not any(verb in verbs for verbs in _GROUPS.values())]
    groups = {title: [verb for verb in verbs if verb in commands()] for title, verbs in _GROUPS.items()}
    groups["Expert"] += rest
    lines = [_HEADER.rstrip()]
    for title, verbs in groups.items():
        lines += [f"\n{title}", *(f"  {verb:<16} {summary(verb)}" for verb in verbs)] if verbs else []
    return "\n".join([*lines, _FOOTER.rstrip()])


def summary(verb: str) -> str:
    """One-line description of a verb."""
    return (module_of(verb).__doc__ or "").strip().splitlines()[0].rstrip(".")


class _Usage(TierodError):
    """Error in the use of the command line."""


def _explain(error: BaseException) -> tuple[int, str]:
    if isinstance(error, TierodError):
        return BAD_INPUT, " ".join(str(error).split())
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED, "stopped; no incomplete file is left"
    if lacks_memory(error):
        return BAD_INPUT, "not enough memory; give a shorter recording or fewer channels"
    if isinstance(error, OSError):
        return BAD_INPUT, _of_the_system(error)
    if isinstance(error, RuntimeError) and str(error).startswith(_LOOP):
        return BAD_INPUT, f"{str(error).removeprefix(_LOOP)} is a link that leads back to itself; name another file"
    return DEFECT, (
        f"a defect of tierod itself: {type(error).__name__}: {' '.join(str(error).split())[:200]}; "
        "please report it with the output of the same command and --debug"
    )


def _of_the_system(error: OSError) -> str:
    place = f"{error.filename}: " if error.filename else ""
    reason = error.strerror or str(error)
    remedies = {
        errno.ENOSPC: "make room on the disk, or name another place with --output",
        errno.EACCES: "check the permissions of the file and its folder, or name another place",
        errno.EROFS: "name a place that can be written",
        errno.ENOENT: "check the path",
        errno.EISDIR: "name a file, not a folder",
        errno.ENOTDIR: "check the path",
    }
    remedy = remedies.get(error.errno or 0, "check the file and its folder")
    return f"{place}{reason[:1].lower()}{reason[1:]}; {remedy}"
