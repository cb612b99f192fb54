"""Functions behind the endpoints, which programs can use without HTTP.

with Workbench(site) as bench:
    job = bench.analyse(Analysed(file="recordings/drive.mf4", vehicle="car.toml"))
"""

from __future__ import annotations

import json
import os
import shutil
import threading
from collections import OrderedDict
from collections.abc import Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, ParameterError
from tierod.core.plugins import installed, part
from tierod.core.shown import shown
from tierod.core.signals import SIGNALS
from tierod.core.version import __version__
from tierod.web import fleets, shapes
from tierod.web.demo import folders
from tierod.web.errors import Absent, Forbidden, in_the_page
from tierod.web.jobs import Job, Jobs
from tierod.web.series import SeriesReader
from tierod.web.site import UPLOADS, Listing, Root, Site, listing
from tierod.web.store import Store, stamp_of

READERS = 32  # Number of recordings whose index of signals stays in memory


class Workbench:
    """Context manager with all functions of a site; its end cancels all jobs.

    Raises:
        OutputError: the cache cannot be written
    """

    def __init__(self, site: Site, workers: int = 1):
        from dataclasses import replace

        self.store = Store(site.cache)
        self.uploads = Path(os.path.realpath(site.cache / UPLOADS))
        self.site = replace(site, roots=(*site.roots, Root(UPLOADS, self.uploads)))
        self.store.sweep(site.limits.cache)
        self.jobs = Jobs(workers, site.limits, self._finished)
        self.fleets = fleets.Fleets(site.cache)
        self._readers: OrderedDict[Path, SeriesReader] = OrderedDict()
        self._lock = threading.Lock()
        if site.demo:
            folders(site.cache / "demo")[0].mkdir(parents=True, exist_ok=True)
            self.jobs.submit("demo", {"folder": str(site.cache / "demo")}, "making the demo")

    def __enter__(self) -> Workbench:
        return self

    def __exit__(self, *_: object) -> None:
        self.jobs.close()

    @cached_property
    def about(self) -> shapes.SiteShape:
        """Description of the served site."""
        from tierod.vehicles import VEHICLES

        known = {
            name: {
                "meaning": each.meaning,
                "positive": each.positive,
                "label": shown(each.unit)[1],
                "group": each.group,
            }
            for name, each in SIGNALS.items()
        }
        return shapes.SiteShape(
            version=__version__,
            roots=[each.name for each in self.site.roots],
            results=[each.name for each in self.site.results],
            vehicle=self.site.vehicle,
            vehicles=list(VEHICLES.own),
            live=list(self.site.live),
            dbc=[Path(each).name for each in self.site.dbc],
            demo=self._demo(),
            scenarios=installed(),
            upload_limit=self.site.limits.upload,
            signals=known,
        )

    def _demo(self) -> str:
        if not self.site.demo:
            return ""
        return self.site.name_of(folders(self.site.cache / "demo")[0] / "demo-drive.parquet")

    def files(
        self, folder: str = "", search: str = "", sort: str = "name", offset: int = 0, count: int = 200
    ) -> Listing:
        """Listing of a folder; arguments and errors as in `tierod.web.site.listing`."""
        found = listing(self.site, folder, search, sort, offset, count)
        for each in found.entries:
            if not each.folder:
                each.analysed = bool(self._known(each.file).get("series"))
        return found

    def _known(self, file: str) -> dict[str, Any]:
        try:
            return self.store.known(stamp_of(self.site.file(file)))
        except Absent:
            return {}

    def state(self, file: str) -> shapes.State:
        path = self.site.file(file)
        status = path.stat()
        known = self.store.known(stamp_of(path))
        series, result = known.get("series", ""), known.get("result", "")
        return shapes.State(
            file=file,
            name=path.name,
            bytes=status.st_size,
            modified=status.st_mtime,
            series=series if series and self.store.holds("series", series) else "",
            result=result if result and self.store.holds("results", result) else "",
            vehicle=known.get("vehicle", ""),
            why=known.get("why", ""),
            corrected=bool(known.get("chosen")),
        )

    def opened(self, file: str) -> shapes.Opened:
        """State of a recording, with its signals and findings if they are stored; raises as `state`."""
        state = self.state(file)
        series, result = None, None
        with suppress(Absent):  # removed from the store in between: it is computed again
            series = self.series(state.series) if state.series else None
            result = self.result(state.result) if state.result else None
        return shapes.Opened(state=state, series=series, result=result)

    def analyse(self, asked: shapes.Analysed) -> Job:
        """Start the analysis of a recording; a stored result is reused.

        Raises:
            Absent: there is no such file
            Busy: too many jobs are waiting
        """
        given = {**self._given(asked), "spread": asked.spread}
        return self.jobs.submit("analyse", given, f"analysing {Path(given['path']).name}")

    def propose(self, file: str, dbc: Sequence[str] = ()) -> Job:
        """Start the proposal of a channel map, with databases from the served folders; raises as `analyse`."""
        given = self._given(shapes.Asked(file=file, vehicle="", channel_map=None, dbc=list(dbc)))
        return self.jobs.submit("propose", given, f"looking for the signals of {Path(given['path']).name}")

    def inspect(self, asked: shapes.Asked) -> Job:
        """Start the inspection of a recording: its content, and what each monitor lacks; raises as `analyse`."""
        given = self._given(asked)
        return self.jobs.submit("inspect", given, f"looking into {Path(given['path']).name}")

    def _given(self, asked: shapes.Analysed | shapes.Asked) -> dict[str, Any]:
        path = self.site.file(asked.file)
        if path.stat().st_size == 0:
            raise InputError(f"{path.name} is empty; record or copy it again")
        vehicle = self.vehicle(asked.vehicle)
        before = self.store.known(stamp_of(path)).get("chosen", {})
        chosen = {"channel_map": asked.channel_map, "dbc": [str(self.site.file(each[:4096])) for each in asked.dbc]}
        chosen = {name: value or before.get(name) for name, value in chosen.items()}
        return {"path": str(path), "vehicle": vehicle, "dbc": chosen["dbc"] or list(self.site.dbc),
                "channel_map": chosen["channel_map"] or self.site.channel_map or None,
                "cache": str(self.site.cache), "chosen": {k: v for k, v in chosen.items() if v}}  # fmt: skip

    def vehicle(self, name: str) -> str:
        """Argument of `load` for a vehicle: that of the site if none is given, a shipped name, or a served file."""
        from tierod.vehicles import VEHICLES

        if not name:
            return self.site.vehicle
        if name == self.site.vehicle or name in VEHICLES.own:
            return name
        try:
            return str(self.site.file(name))
        except Absent:
            raise ParameterError(
                f"'{name[:100]}' is neither a vehicle of 'tierod vehicles' nor a file in the folders that are served"
            ) from None

    def simulate(self, chosen: shapes.ChosenScenario) -> Job:
        """Start a simulated drive and its judgement.

        Raises:
            ParameterError: a name is not shipped
            Busy: too many jobs are waiting
        """
        given = chosen.model_dump()
        # Checked here, so that a wrong choice is refused before it becomes a job.
        part("page", "a simulated drive").scenario_text(given)
        given |= {"folder": str(self.uploads / "scenarios"), "cache": str(self.site.cache)}
        return self.jobs.submit("simulate", given, f"driving {chosen.scenario or chosen.car}")

    def series(self, key: str) -> shapes.SeriesShape:
        """Descriptions of the signals of a recording."""
        return shapes.series_shape(key, self.reader("series", key))

    def reader(self, kind: str, key: str) -> SeriesReader:
        """Reader of the samples stored under a key; raises as `series`."""
        path = self.store.path(kind, key)
        if not self.store.holds(kind, key):
            raise Absent("the analysed recording is not kept any more; open it again from the list")
        with self._lock:
            found = self._readers.pop(path, None) or SeriesReader(path)
            self._readers[path] = found
            while len(self._readers) > READERS:
                self._readers.popitem(last=False)
        return found

    def readers(self, series: str, result: str = "") -> list[SeriesReader]:
        """Readers of a recording's samples, and of the monitors' estimates in it; raises as `series`."""
        return [self.reader("series", series), *([self.reader("results", result)] if result else [])]

    def result(self, key: str) -> dict[str, Any]:
        """Findings of the monitors in a recording."""
        try:
            path = self.store.path("results", key) / "result.json"
            found: dict[str, Any] = json.loads(in_the_page(path.read_text(encoding="utf-8")))
        except (OSError, ValueError):
            raise Absent("the result is not kept any more; open the recording again from the list") from None
        estimates = shapes.series_shape(key, self.reader("results", key)).signals
        return {**found, "path": Path(found["path"]).name, "signals": [each.model_dump() for each in estimates]}

    def report(self, key: str, monitor: str) -> str:
        if monitor not in self.result(key)["monitors"]:
            raise Absent(f"there is no report of '{monitor[:60]}'; choose a monitor of the list")
        try:
            return (self.store.path("results", key) / f"report-{monitor}.html").read_text(encoding="utf-8")
        except OSError:
            raise Absent("the report is not kept any more; open the recording again from the list") from None

    def fleet(self, name: str) -> dict[str, Any] | Job:
        results = self.site.result(name)
        if self.site.demo and not (results / "ledger").is_dir():
            raise Absent("the demo fleet is still being made; try again in some seconds")
        key = fleets.key_of(results)
        found = self.fleets.loaded(key)
        if found is not None:
            return found
        given = {"results": str(results), "cache": str(self.site.cache), "key": key}
        return self.jobs.submit("fleet", given, f"working out the fleet {name}")

    def drives(self, name: str, vehicle: str) -> list[dict[str, Any]]:
        """All findings of a car in a results folder; raises as `tierod.web.fleets.drives_of`."""
        rows = fleets.drives_of(self.site.result(name), vehicle)
        return [{**row, "file": self.site.name_of(row["recording_name"] or "")} for row in rows]

    def parameters(self, vehicle: str) -> dict[str, Any]:
        from tierod.vehicles import QUANTITIES, load

        car = load(self.vehicle(vehicle))
        names = ("name", "value", "unit", "standard_deviation", "source")
        rows = [dict(zip(names, row, strict=True)) for row in car.rows()]
        for row in rows:
            row["meaning"] = QUANTITIES[str(row["name"])].meaning
            row["assumed"] = car.parameters[str(row["name"])].assumed
        return {"name": car.name, "description": car.description, "source": car.source, "good_for": list(car.good_for),
                "not_good_for": list(car.not_good_for), "parameters": rows}  # fmt: skip

    def room(self, name: str) -> Path:
        plain = not set(name) & set('/\\\0:*?"<>|') and name.isprintable() and not name.startswith(".")
        if not plain or not 0 < len(name.encode()) <= 200:
            raise Forbidden(f"'{name[:60]}' is not a plain file name; rename it, with letters, digits, point and dash")
        if shutil.disk_usage(self.uploads).free < self.site.limits.upload // 8:
            raise InputError("the disk of the cache is almost full; make room, or name another folder with --cache")
        return self.uploads / name

    def _finished(self, job: Job) -> None:
        if path := job.given.get("path") or job.found.get("path"):
            self.store.forget_read(stamp_of(Path(path)))
            if job.kind == "analyse" and (chosen := job.given.get("chosen")):
                self.store.remember(stamp_of(Path(path)), {"chosen": chosen})
        self.store.sweep(self.site.limits.cache)
