"""Open the interactive page: recordings, vehicles, fleets and live buses in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def serve(
    paths: Annotated[
        list[Path] | None,
        typer.Argument(
            help="Folders of recordings, results folders of 'tierod fleet', or single recordings; the demo if none "
            "is given."
        ),
    ] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="A vehicle's name or the path of its TOML file; the one that a recording names if not given."
        ),
    ] = None,
    dbc: Annotated[list[Path] | None, typer.Option(help="CAN database; may be given more than once.")] = None,
    channel_map: Annotated[
        Path | None, typer.Option("--map", help="TOML file: source name, unit, sign and offset of each signal.")
    ] = None,
    live: Annotated[
        list[str] | None, typer.Option(help="Bus to follow, as INTERFACE:CHANNEL; may be given more than once.")
    ] = None,
    port: Annotated[int, typer.Option(help="Port; 0: any free port.")] = 8765,
    bind: Annotated[
        str,
        typer.Option(
            help="Address on which it answers; if it is not this computer's own, clients need the printed token."
        ),
    ] = "127.0.0.1",
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page.")] = True,
    cache: Annotated[Path | None, typer.Option(help="Folder that keeps analysed recordings.")] = None,
    workers: Annotated[int | None, typer.Option(help="Jobs at a time; half of the cores where not given.")] = None,
    job_time: Annotated[float, typer.Option(help="Time limit of one job [s].")] = 3600.0,
    job_memory: Annotated[int, typer.Option(help="Memory limit of one job [MiB].")] = 4096,
    upload: Annotated[int, typer.Option(help="Largest upload [MiB].")] = 2048,
    cache_size: Annotated[int, typer.Option(help="Limit of the folder of analysed recordings [MiB].")] = 20480,
) -> int:
    """Serve the page until Ctrl-C: ended by the user (0), bad input (3)."""
    from tierod.core.errors import ParameterError
    from tierod.web.server import serve as run
    from tierod.web.site import Limits

    for name, value in (("--job-time", job_time), ("--job-memory", job_memory), ("--upload", upload)):
        if not value > 0:
            raise ParameterError(f"{name} needs a positive number, not {value:g}")
    if not 0 <= port <= 65535:
        raise ParameterError(f"--port is {port}; give 0 to 65535")
    limits = Limits(upload << 20, job_time=job_time, job_memory=job_memory << 20, cache=max(cache_size, 0) << 20)
    run(
        *(paths or ()), vehicle=vehicle, dbc=dbc or (), channel_map=channel_map, live=live or (), port=port, bind=bind,
        cache=cache, workers=workers, limits=limits, browser=browser,
    )  # fmt: skip
    return 0
