"""Bundle of the modules of the first view in one file, made when the server starts.

A browser requests six files from a server at a time, so that twenty small modules take longer than one large file. The
modules stay unchanged in their folder: each becomes the body of a function, in the order of their dependencies, and a
view that is loaded later finds the objects of the bundle under the addresses of the modules.
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
    """(text of the bundle, replacement for each of its modules at the address of the module).

    Args:
        content: text of every module by its name, a path
        entry: module that is executed first
        name: name of the bundle, in the folder of the entry

    Raises:
        ValueError: a module has an import or export in a form that is not supported
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
    """Append a module after all modules that it imports."""
    for pattern in (IMPORT, PASSED_ON):
        for _, place in pattern.findall(content[module]):
            other = normpath(f"{dirname(module)}/{place}" if dirname(module) else place)
            if other not in order:
                _needed(content, other, order)
    order.append(module)


def _variable(module: str) -> str:
    return "$" + re.sub(r"\W", "_", basename(module).removesuffix(".js"))


def _exports(text: str) -> list[str]:
    """Names that a module exports, including those that it re-exports."""
    listed = [name for names, _ in PASSED_ON.findall(text) for name in _renamed(names).values()]
    given = [name for names in GIVEN.findall(PASSED_ON.sub("", text)) for name in _renamed(names).values()]
    return [*listed, *given, *DECLARED.findall(text)]


def _renamed(names: str) -> dict[str, str]:
    """Local name and exported name of each entry in a list such as "a, b as c"."""
    pairs = [each.split(" as ") for each in names.split(",") if each.strip()]
    return {pair[0].strip(): pair[-1].strip() for pair in pairs}


def _function(text: str, module: str) -> str:
    """A module as the body of a function that returns its exports."""
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
    """Names that a module re-exports, as a JavaScript object."""
    source = _variable(place)
    return f"{{ {', '.join(f'{there}: {source}.{here}' for here, there in _renamed(names).items())} }}"
