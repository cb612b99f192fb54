"""Simulated drives for the page: the shipped cars, courses and faults, and a drive with chosen ones."""

from __future__ import annotations

import json
import math
import re
import secrets
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from tierod.core.errors import ParameterError, nearest
from tierod.core.toml import quoted

LONGEST = 3600.0  # Longest drive that the page may request [s]

_SIZE = re.compile(r"[-+]?[0-9.]+(?:e[-+]?[0-9]+)?(?: ?[A-Za-z°µ%Ω/*·^0-9.]{1,20})?", re.IGNORECASE)


@cache
def catalogue() -> dict[str, Any]:
    """Shipped scenarios, cars, courses and faults to choose from, each with its description."""
    from tierod.core.toml_document import Document
    from tierod_lab.ground import courses
    from tierod_lab.ground.cars import catalogue as cars
    from tierod_lab.ground.faults import FAULTS
    from tierod_lab.ground.scenarios import SCENARIOS

    def listed(names: Any, find: Callable[[str], Path], what: str) -> list[dict[str, Any]]:
        found = []
        for name in names:
            content = Document.read(find(name), what).content
            found.append(
                {"name": name, **{key: content.get(key) for key in ("description", "car", "course", "seconds")}}
            )
        return found

    faults = []
    for name in FAULTS:
        content = Document.read(FAULTS.find(name), "fault").content
        faults.append({"name": name, "description": content["description"], "element": content.get("element", ""),
                       "size": _size_in(content), "start": str(content.get("start", "30 s"))})  # fmt: skip
    return {
        "scenarios": listed(SCENARIOS, SCENARIOS.find, "scenario"),
        "cars": listed(cars.shipped(), cars.find, "car"),
        "courses": listed(courses.shipped(), courses.find, "course"),
        "faults": faults,
    }


def _size_in(content: Mapping[str, Any]) -> str:
    """Size of a fault from its file; "" if it has none that can be changed separately."""
    behaviour = content.get("behaviour")
    inner = behaviour if isinstance(behaviour, Mapping) else {}
    return str(content.get("size", inner.get("to", inner.get("size", ""))))


def drive(given: Mapping[str, Any], progress: Callable[[float], None]) -> tuple[Path, dict[str, Any]]:
    """Simulate a scenario, and return the path of its recording and facts about the run."""
    from tierod.io.writers import write
    from tierod_lab.ground.faults.reading import fault_in_words
    from tierod_lab.ground.scenarios import load

    folder = Path(given["folder"])
    folder.mkdir(parents=True, exist_ok=True)
    text = scenario_text(given)
    source = folder / f"scenario-{secrets.token_hex(4)}.toml"
    source.write_text(text, encoding="utf-8")
    try:
        whole = load(source).with_run()
        outcome = whole.run(progress)
    except ParameterError as error:
        source.unlink()
        # The choice in the page has no file and lines that a message could name.
        plain = re.sub(rf"{re.escape(str(source))}, (line \d+: )?", "", str(error)).replace(str(source), "the scenario")
        raise ParameterError(_as_chosen(plain, given.get("faults", ()))) from None
    path = source.with_suffix(".parquet")
    write(outcome.recording, path)
    return path, {
        "vehicle": whole.vehicle,
        "scenario": text,
        "faults": [fault_in_words(each) for each in whole.faults],
        "windows": [json.loads(json.dumps(dict(each), default=str)) for each in outcome.windows],
        "diverged_at": outcome.diverged_at,
        "seconds": whole.duration,
    }


def _as_chosen(plain: str, faults: Iterable[Mapping[str, Any]]) -> str:
    usual = {each["name"]: each["size"] for each in catalogue()["faults"]}
    for number, fault in enumerate(faults):
        name, size = fault.get("name"), str(fault.get("size") or "").strip()
        said = re.sub(rf"^'[\w.]+' is '{re.escape(size)}'", f"the size of {name} is '{size}'", plain) if size else plain
        if said != plain:
            return f"{said}; give for example {usual.get(name)}"
        plain = plain.replace(f"'faults.{number}.start'", f"the start of {name}")
    return plain


def scenario_text(given: Mapping[str, Any]) -> str:
    """Scenario file of a choice; every name in it must be shipped."""
    known = catalogue()
    base: Mapping[str, Any] = {}
    if given.get("scenario"):
        base = next(
            each for each in known["scenarios"] if each["name"] == _known(given["scenario"], known["scenarios"])
        )
    car = given.get("car") or _name_in(base.get("car"))
    course = given.get("course") or _name_in(base.get("course"))
    lines = [
        'name = "from-the-page"',
        'description = "Chosen in the page."',
        f"car = {json.dumps(_known(car, known['cars']))}",
        f"course = {json.dumps(_known(course, known['courses']))}",
    ]
    seconds = given.get("seconds")
    if seconds is not None:
        if not 0.0 < float(seconds) <= LONGEST:
            raise ParameterError(f"a drive of {seconds:g} s is not taken here; give at most {LONGEST:g} s")
        lines.append(f"seconds = {float(seconds)!r}")
    lines.append(f"seed = {int(given.get('seed') or 0)}")
    for fault in given.get("faults", ()):
        lines += _fault_lines(fault, known["faults"])
    return "\n".join(lines) + "\n"


def _fault_lines(fault: Mapping[str, Any], known: list[dict[str, Any]]) -> list[str]:
    lines = ["", "[[faults]]", f"use = {json.dumps(_known(fault.get('name'), known))}"]
    start = fault.get("start")
    if start is not None:
        if not (math.isfinite(float(start)) and float(start) >= 0.0):
            raise ParameterError(f"a fault cannot begin at {start} s; give a time of 0 or more")
        lines.append(f'start = "{float(start):g} s"')
    if size := str(fault.get("size") or "").strip():
        if not _SIZE.fullmatch(size):
            raise ParameterError(f"the size '{size[:40]}' is not a number with a unit; give for example 6 N*m")
        lines.append(f"size = {quoted(size)}")
    return lines


def _name_in(given: object) -> str:
    return str(given.get("name", "")) if isinstance(given, Mapping) else str(given or "")


def _known(name: object, among: list[dict[str, Any]]) -> str:
    names = [str(each["name"]) for each in among]
    if name not in names:
        raise ParameterError(f"'{str(name)[:60]}' is not shipped{nearest(str(name)[:60], names)}")
    return str(name)
