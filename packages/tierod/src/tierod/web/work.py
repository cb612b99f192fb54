"""The kinds of work of jobs, each a function of its arguments and of a function that receives progress."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tierod.core.plugins import part
from tierod.web.analysing import Reading, Say, analyse
from tierod.web.store import Store


def _analyse(given: Mapping[str, Any], say: Say) -> dict[str, Any]:
    return analyse(Store(Path(given["cache"])), _reading(given), given["vehicle"], given["spread"], say)


def _reading(given: Mapping[str, Any]) -> Reading:
    return Reading(Path(given["path"]), tuple(given.get("dbc", ())), given.get("channel_map") or None)


def _propose(given: Mapping[str, Any], say: Say) -> dict[str, Any]:
    """Proposed assignment of columns to signals, as a table that can be corrected."""
    from tierod.io.proposal import propose, text_of

    say(0.1, "reading the file")
    found = propose(
        Path(given["path"]), list(given.get("dbc", ())) or None, lambda share: say(share, "reading the file")
    )
    entries = [
        {
            "signal": each.signal,
            "source": each.column.name,
            "unit": each.unit.unit.name,
            "factor": each.factor,
            "sign": each.sign.sign,
            "doubtful": each.doubtful,
            "reasons": [each.meant.reason, each.unit.reason, each.sign.reason],
            "others": list(each.others),
        }
        for each in found.entries
    ]
    others = [{"name": each.name, "unit": each.unit} for each in found.unmatched]
    return {"entries": entries, "unmatched": others, "text": text_of(found)}


def _inspect(given: Mapping[str, Any], say: Say) -> dict[str, Any]:
    """Content of a recording, and the requirements of each monitor that it does not meet."""
    from tierod.monitors.inspection import inspect
    from tierod.report.document import plain
    from tierod.vehicles import load

    say(0.1, "reading the file")
    reading = _reading(given)
    car = load(given["vehicle"]) if given.get("vehicle") else None
    dbc, used = reading.files(car)
    document: dict[str, Any] = plain(inspect(reading.path, car, dbc=dbc, channel_map=used).document())
    return document


def _simulate(given: Mapping[str, Any], say: Say) -> dict[str, Any]:
    path, facts = part("page", "a simulated drive").drive(given, lambda share: say(0.3 * share, "driving"))
    found = analyse(
        Store(Path(given["cache"])), Reading(path), facts["vehicle"], True,
        lambda share, text, **more: say(0.3 + 0.7 * share, text, **more),
    )  # fmt: skip
    return {**found, **facts, "path": str(path)}


def _fleet(given: Mapping[str, Any], say: Say) -> dict[str, Any]:
    from tierod.web.fleets import work_out

    say(0.1, "working out the trends of all cars")
    return work_out(Path(given["results"]), Path(given["cache"]), given["key"])


def _demo(given: Mapping[str, Any], say: Say) -> dict[str, Any]:
    from tierod.web.demo import make

    return make(Path(given["folder"]), say)


WORKS: dict[str, Callable[[Mapping[str, Any], Say], dict[str, Any]]] = {
    "analyse": _analyse,
    "propose": _propose,
    "inspect": _inspect,
    "simulate": _simulate,
    "fleet": _fleet,
    "demo": _demo,
}
