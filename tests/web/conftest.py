"""A small site: one weave of forty seconds, analysed once."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from live_drives import drive
from tierod.core.recording import Channel
from tierod.io.writers import write
from tierod.web.analysing import Reading, analyse
from tierod.web.guard import Trust
from tierod.web.site import Limits, Site, roots_of
from tierod.web.store import Store

HOST = "http://localhost:8765"


@dataclass(frozen=True)
class Analysed:
    """An analysed recording, and the store that keeps it."""

    folder: Path
    cache: Path
    series: str
    result: str


@pytest.fixture(scope="session")
def analysed(tmp_path_factory):
    top = tmp_path_factory.mktemp("web")
    folder, cache = top / "drives", top / "cache"
    folder.mkdir()
    weave = drive(40.0)
    slow = Channel("slow", np.arange(40.0), np.where(np.arange(40) % 7, np.arange(40.0), np.nan), "K")
    write(weave.with_channels([slow]), folder / "weave.parquet")
    (folder / "deep").mkdir()
    (folder / "deep" / "notes.txt").write_text("none")
    said = []
    found = analyse(
        Store(cache), Reading(folder / "weave.parquet"), "midsize-eps", False, lambda *words, **more: said.append(words)
    )
    assert any(text == "judging" for _, text in said)
    return Analysed(folder, cache, found["series"], found["result"])


@pytest.fixture
def site(analysed, tmp_path):
    cache = tmp_path / "cache"
    shutil.copytree(analysed.cache, cache)
    recordings, results = roots_of([analysed.folder])
    return Site(recordings, results, cache, "midsize-eps", limits=Limits(upload=1 << 20, job_time=60.0))


@pytest.fixture
def bench(site):
    pytest.importorskip("fastapi", reason="the extra 'web' is not installed")
    from tierod.web.workbench import Workbench

    with Workbench(site, workers=0) as made:
        yield made


@pytest.fixture
def working(site):
    """A bench whose jobs run."""
    from tierod.web.workbench import Workbench

    with Workbench(site) as made:
        yield made


@pytest.fixture
def client(bench):
    from tierod.web.app import application
    from web_client import TestClient

    app = application(bench, Trust(8765, upload=1 << 20))
    with TestClient(app, base_url=HOST, raise_server_exceptions=False) as made:
        yield made
