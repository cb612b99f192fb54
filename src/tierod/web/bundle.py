"""The modules that the first view needs as one file, made while the server starts.

A browser asks a server for six files at a time, so that twenty small modules take longer than one large. The modules
stay as they are in their folder: each becomes the content of a function, in the order in which they need each other,
and a view that is fetched later finds at their addresses what the one file has made.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from posixpath import basename, dirname, normpath

IMPORT = re.compile(r'^import \{([^}]*)\} from "(\./[^"]+)";$', re.MULTILINE)
PASSED_ON = re.compile(r'^export \{([^}]*)\} from "(\./[^"]+)";$', re.MULTILINE)
GIVEN = re.compile(r"\bexport ?\{([^}]*)\};?")
DECLARED = re.compile(r"^export (?=(?:async )?(?:function|const|class) (\w+))", re.MULTILINE)


def bundled(content: Mapping[str, str], entry: str, name: str) -> tuple[str, dict[str, str]]:
    """(the one file, what stands for each of its modules at the module's own address).

    Args:
        content: text of every module by its name, a path
        entry: the module that begins
        name: of the one file, in the folder of the entry

    Raises:
        ValueError: a module has an import or export of another form than those of this project
    """
    order: list[str] = []
    _needed(content, entry, order)
    parts = [f"const {_variable(each)} = (() => {{\n{_function(content[each], each)}\n}})();" for each in order]
    stands = {}
    for each in order:
        if dirname(each) == dirname(entry) and each != entry:
            names = ", ".join(_exports(content[each]))
            made = _variable(each)
            stands[each] = f'import {{ {made} }} from "./{name}";\nexport const {{ {names} }} = {made};\n'
    exported = ", ".join(_variable(each) for each in stands)
    return "\n".join([*parts, f"export {{ {exported} }};\n"]), stands


def _needed(content: Mapping[str, str], module: str, order: list[str]) -> None:
    """Append a module behind all those that it imports."""
    for pattern in (IMPORT, PASSED_ON):
        for _, place in pattern.findall(content[module]):
            other = normpath(f"{dirname(module)}/{place}" if dirname(module) else place)
            if other not in order:
                _needed(content, other, order)
    order.append(module)


def _variable(module: str) -> str:
    return "$" + re.sub(r"\W", "_", basename(module).removesuffix(".js"))


def _exports(text: str) -> list[str]:
    """Names that a module exports, with those that it passes on."""
    listed = [name for names, _ in PASSED_ON.findall(text) for name in _renamed(names).values()]
    given = [name for names in GIVEN.findall(PASSED_ON.sub("", text)) for name in _renamed(names).values()]
    return [*listed, *given, *DECLARED.findall(text)]


def _renamed(names: str) -> dict[str, str]:
    """Name here to name there of "a, b as c"."""
    pairs = [each.split(" as ") for each in names.split(",") if each.strip()]
    return {pair[0].strip(): pair[-1].strip() for pair in pairs}


def _function(text: str, module: str) -> str:
    """A module as the content of a function that gives what it exports."""
    given = [f"...{_picked(names, place)}" for names, place in PASSED_ON.findall(text)]
    body = PASSED_ON.sub("", text)
    for names in GIVEN.findall(body):
        given += [f"{there}: {here}" for here, there in _renamed(names).items()]
    given += DECLARED.findall(body)
    body = GIVEN.sub("", DECLARED.sub("", IMPORT.sub(_taken, body)))
    if re.search(r"^(?:import|export)\b(?! ?\()", body, re.MULTILINE):
        raise ValueError(f"{module} imports or exports in a form that is not expected; write import {{ a }} from './b'")
    return f"{body}\nreturn {{ {', '.join(given)} }};"


def _taken(found: re.Match[str]) -> str:
    names = ", ".join(here if here == there else f"{here}: {there}" for here, there in _renamed(found.group(1)).items())
    return f"const {{ {names} }} = {_variable(found.group(2))};"


def _picked(names: str, place: str) -> str:
    """Names that a module passes on, as an object."""
    source = _variable(place)
    return f"{{ {', '.join(f'{there}: {source}.{here}' for here, there in _renamed(names).items())} }}"
