"""Job that identifies parameters, and stores their document, their page, and the new vehicle file."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from tierod.core.errors import TierodError
from tierod.core.files import write_text
from tierod.experiments.fingerprint import fingerprint
from tierod.fleet.stamps import code, vehicle_digest
from tierod.io.readers.streaming import loaded_map
from tierod.report.html import Origin
from tierod.report.identification import Identification
from tierod.report.identification import identify as run
from tierod.vehicles import Vehicle, load
from tierod.web.analysing import Say, digest
from tierod.web.store import Store

KIND = "identified"
"""Kind of the results in the store."""

DOCUMENT, PAGE, VEHICLE = "identification.json", "page.html", "vehicle.toml"


def identify(store: Store, given: Mapping[str, Any], say: Say) -> dict[str, Any]:
    """Identify parameters of a vehicle from recordings; a stored result is reused.

    Args:
        store: store for the result
        given: "subject", "paths", "vehicle", "free", "channel_map", and "folder" for the vehicle file
        say: receives the progress

    Returns:
        the key of the result, and the path of the vehicle file; "" if none was written

    Raises:
        InputError: a recording cannot be read, or lacks required signals
        ParameterError: there is no such vehicle or parameter
    """
    paths, car = [Path(each) for each in given["paths"]], load(given["vehicle"])
    say(0.01, "reading the files")
    used = loaded_map(given["channel_map"] or car.channel_map)
    content = [(each.name, digest(each)) for each in paths]
    key = fingerprint("tierod.web-identification/1", given["subject"], content, vehicle_digest(car), given["free"],
                      None if used is None else (used.entries, used.time), code())  # fmt: skip
    if not store.holds(KIND, key):
        found = run(
            given["subject"], paths, car, given["free"], channel_map=used,
            progress=lambda share: say(0.02 + 0.93 * share, f"identifying the {given['subject']}"),
        )  # fmt: skip
        _keep(store, found, key, paths)
    return {"identified": key, "vehicle_file": _served(store, Path(given["folder"]), car, key)}


def _keep(store: Store, found: Identification, key: str, paths: list[Path]) -> None:
    folder, car = store.begun(KIND), found.vehicle
    names = [car.path.name if car.path.suffix == ".toml" else car.name, *(each.name for each in paths)]
    words = ["tierod", "identify", found.subject.title.lower(), *names[1:], "--vehicle", names[0]]
    origin = Origin.now(shlex.join(words))
    # The page must not reveal where the file lies on this machine.
    replace(found, vehicle=replace(car, path=Path(car.path.name))).write_html(folder / PAGE, origin)
    if not found.doubt:
        found.write_vehicle(folder / VEHICLE, origin)
    document = {**found.document(origin), "doubt": found.doubt, "files": [each.name for each in paths]}
    write_text(folder / DOCUMENT, json.dumps(document), sweeps=False)
    store.settled(folder, KIND, key)


def _served(store: Store, folder: Path, car: Vehicle, key: str) -> str:
    """Copy the vehicle file to a folder from which recordings can be judged by it; "" if there is none."""
    source, target = store.path(KIND, key) / VEHICLE, folder / f"{car.name}-{key[:8]}.toml"
    if not source.is_file():
        return ""
    folder.mkdir(parents=True, exist_ok=True)
    if not target.is_file():
        write_text(target, source.read_text(encoding="utf-8"))
    with suppress(TierodError, OSError):
        load(target)
        return str(target)
    return ""
