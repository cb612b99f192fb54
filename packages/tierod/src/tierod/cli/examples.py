"""Examples and names shown below the help of a command."""

from __future__ import annotations

EXAMPLES: dict[str, tuple[str, ...]] = {
    "convert": (
        "tierod convert bag/ -o drive.mf4",
        "tierod convert morning-1.mf4 morning-2.mf4 -o morning.parquet",
    ),
    "demo": ("tierod demo",),
    "diagnose": (
        "tierod diagnose drive.mf4 --vehicle car.toml",
        "tierod diagnose monday.mf4 tuesday.mf4 --vehicle car.toml -o week.html",
        "tierod diagnose drive.mf4 --vehicle car.toml --monitor sideslip --from 60 --to 180",
    ),
    "fleet": (
        "tierod fleet 'drives/**/*.parquet' --vehicles fleet.toml -o results/",
        "tierod fleet s3://bucket/2026-11/ --vehicle car.toml --scheduler tcp://host:8786 -o s3://bucket/results",
        "tierod fleet report results/",
    ),
    "export": ("tierod export c friction --vehicle car.toml -o ecu/",),
    "identify": (
        "tierod identify column bench.parquet --vehicle column-bench -o mine.toml",
        "tierod identify thresholds monday.mf4 tuesday.mf4 --vehicle car.toml --in-place",
    ),
    "inspect": (
        "tierod inspect drive.mf4",
        "tierod inspect drive.mf4 --write-map car.channels.toml",
        "tierod inspect can.log --vehicle rav4",
    ),
    "live": (
        "tierod live --interface socketcan --channel can0 --vehicle car.toml --dbc car.dbc --log drive.mf4",
        "tierod live --interface udp_multicast --channel 239.74.163.2 --vehicle rav4 --memory car.json --json",
    ),
    "monitors": ("tierod monitors", "tierod monitors sideslip --vehicle car.toml"),
    "new": (
        "tierod new car.toml --like midsize-eps mass=1480 wheelbase=2.68",
        'tierod new car.toml --class van "mass=2.1 t +- 3 %" steering_ratio=1/17 --drive drive.mf4',
    ),
    "replay": ("tierod replay drive.mf4 --dbc car.dbc --interface udp_multicast --channel 239.74.163.2 --speed 10",),
    "serve": ("tierod serve", "tierod serve recordings/ results/ --vehicle car.toml --port 8765 --no-browser"),
    "vehicles": ("tierod vehicles", "tierod vehicles midsize-eps --toml > car.toml"),
}
"""Examples by command, as they are typed."""


def names_of(parameter: str) -> tuple[str, ...]:
    """The possible names of an option or argument; empty if its values are not names."""
    from tierod.monitors.registry import MONITORS
    from tierod.vehicles import VEHICLES
    from tierod.vehicles.classes import classes

    if parameter in ("--vehicle", "--like", "vehicles name"):
        return tuple(VEHICLES.own)
    if parameter == "--monitor":
        return (*MONITORS.own, "all")
    if parameter == "monitors name":
        return tuple(MONITORS.own)
    if parameter == "--class":
        return tuple(classes())
    return _of_argument(parameter)


def _of_argument(parameter: str) -> tuple[str, ...]:
    if parameter == "identify subject":
        from tierod.report.identification import SUBJECTS

        return tuple(SUBJECTS)
    return ()
