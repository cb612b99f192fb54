"""Print a script that lets a shell complete commands, options and names."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

if TYPE_CHECKING:
    from collections.abc import Sequence


def completion(
    shell: Annotated[str, typer.Argument(help="bash, zsh or fish.")],
) -> None:
    """Print the script; 'source <(tierod completion bash)' in ~/.bashrc enables it."""
    from tierod.cli.terminal import progress, say
    from tierod.core.errors import ParameterError, nearest

    if shell not in _SHELLS:
        raise ParameterError(f"there is no script for the shell '{shell}'{nearest(shell, _SHELLS)}")
    with progress("reading the commands") as advance:
        found = list(_verbs(advance))
    say(_SHELLS[shell](found), end="")


class Option(NamedTuple):
    """An option of a command: spellings, help, whether it takes a value, and the possible names as its value."""

    spellings: tuple[str, ...]
    help: str
    takes_value: bool
    names: tuple[str, ...]


class Verb(NamedTuple):
    """A command: summary, options, and the possible names as its arguments."""

    name: str
    summary: str
    options: tuple[Option, ...]
    names: tuple[str, ...]


def _verbs(advance: Any) -> Iterator[Verb]:
    """Every command with the options of its parser."""
    from tierod.cli.app import commands, parser, summary
    from tierod.cli.examples import names_of

    every = commands()
    for place, name in enumerate(every):
        options: list[Option] = []
        names: list[str] = []
        for parameter in parser(name).params:
            if parameter.param_type_name == "argument":
                names += names_of(f"{name} {parameter.name}")
                continue
            spellings = (*parameter.opts, *parameter.secondary_opts)
            text = " ".join((getattr(parameter, "help", "") or "").split())
            value = not getattr(parameter, "is_flag", False)
            options.append(Option(spellings, text, value, names_of(parameter.opts[0]) if value else ()))
        yield Verb(name, summary(name), (*options, Option(("--help",), "show the help", False, ())), tuple(names))
        advance((place + 1) / len(every))


def _bash(verbs: Sequence[Verb]) -> str:
    lines = [
        "# bash completion of tierod; written by 'tierod completion bash'",
        "_tierod() {",
        '  local cur="${COMP_WORDS[COMP_CWORD]}" prev="${COMP_WORDS[COMP_CWORD-1]}" words="" names=""',
        '  if [ "$COMP_CWORD" -eq 1 ]; then',
        f'    COMPREPLY=($(compgen -W "{" ".join(verb.name for verb in verbs)} --help --version" -- "$cur")); return',
        "  fi",
        '  case "${COMP_WORDS[1]} $prev" in',
    ]
    for verb in verbs:
        for option in verb.options:
            if option.names:
                patterns = "|".join(f'"{verb.name} {each}"' for each in option.spellings)
                lines.append(
                    f'    {patterns}) COMPREPLY=($(compgen -W "{" ".join(option.names)}" -- "$cur")); return;;'
                )
    lines += ["  esac", '  case "${COMP_WORDS[1]}" in']
    for verb in verbs:
        words = " ".join(each for option in verb.options for each in option.spellings)
        lines.append(f'    {verb.name}) words="{words}"; names="{" ".join(verb.names)}";;')
    lines += [
        "  esac",
        '  if [ "${cur#-}" != "$cur" ]; then COMPREPLY=($(compgen -W "$words" -- "$cur"))',
        '  else COMPREPLY=($(compgen -W "$names" -- "$cur")); fi',
        "}",
        "# Where nothing is offered, bash completes the names of files.",
        "complete -o default -F _tierod tierod",
    ]
    return "\n".join(lines) + "\n"


def _zsh(verbs: Sequence[Verb]) -> str:
    start = "autoload -Uz compinit bashcompinit\n(( $+functions[compdef] )) || compinit\nbashcompinit\n"
    return start + _bash(verbs).replace("tierod completion bash", "tierod completion zsh", 1)


def _fish(verbs: Sequence[Verb]) -> str:
    lines = ["# fish completion of tierod; written by 'tierod completion fish'"]
    for verb in verbs:
        lines.append(f"complete -c tierod -n __fish_use_subcommand -f -a {verb.name} -d {_quoted(verb.summary)}")
        seen = f"complete -c tierod -n '__fish_seen_subcommand_from {verb.name}'"
        for option in verb.options:
            spelt = " ".join(
                f"-l {each[2:]}" if each.startswith("--") else f"-s {each[1:]}" for each in option.spellings
            )
            value = " -r" if option.takes_value else ""
            value += f" -a {_quoted(' '.join(option.names))}" if option.names else ""
            lines.append(f"{seen} {spelt}{value} -d {_quoted(option.help)}")
        if verb.names:
            lines.append(f"{seen} -a {_quoted(' '.join(verb.names))}")
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    return "'" + re.sub(r"(['\\])", r"\\\1", text) + "'"


_SHELLS = {"bash": _bash, "zsh": _zsh, "fish": _fish}
