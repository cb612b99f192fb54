"""Output of a virtual fleet: its drives as recordings, or their estimates as the results of a fleet."""

from __future__ import annotations

import datetime as dt
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tierod.core.files import replacing, write_text
from tierod.core.toml import Document, build
from tierod.fleet.series import stamps
from tierod.work.pool import Failure, run
from tierod_lab.fleet.drives import VirtualDrive
from tierod_lab.fleet.estimates import ErrorLaw, estimates, findings_table
from tierod_lab.fleet.virtual import VirtualCars

LAW = Path(__file__).parent / "friction-errors.toml"  # Error model measured on drives of five minutes

EPOCH = dt.datetime(1970, 1, 1, tzinfo=dt.UTC)
PATTERN = r"(?P<vehicle>car-\d+)/(?P<start>\d{8}T\d{6})_(?P<mileage>\d+)km\.parquet$"
"""Pattern of the names of recordings: vehicle, time and mileage."""


def shipped_law() -> ErrorLaw:
    """The shipped error model for drives at estimate level."""
    document = Document.read(LAW, "error law")
    law: ErrorLaw = build(ErrorLaw, document.content, document)
    return law


@dataclass(frozen=True)
class Recorded:
    """Recording to be made."""

    drive: VirtualDrive
    path: Path


def record(task: Recorded) -> bool:
    """Simulate and write one recording unless it exists; returns whether it was simulated."""
    from tierod.io.writers import write

    if task.path.is_file():  # complete, since files are written completely or not at all: from an earlier run
        return False
    task.path.parent.mkdir(parents=True, exist_ok=True)
    write(task.drive.recording(), task.path)
    return True


def recordings_of(cars: VirtualCars, folder: Path) -> list[Recorded]:
    found = []
    for drive in range(cars.day.shape[1]):
        for car, name in enumerate(cars.names):
            start = EPOCH + dt.timedelta(days=float(cars.day[car, drive]))
            file = f"{start:%Y%m%dT%H%M%S}_{cars.mileage[car, drive] / 1000.0:.0f}km.parquet"
            # Distinct seeds for up to a million cars and 4099 drives per car.
            virtual = VirtualDrive(
                cars.file.seed * 1_000_003 + car,
                (cars.file.seed * 1_000_003 + car) * 4099 + drive,
                float(cars.friction[car, drive]),
                cars.file.duration,
                bool(cars.winter[car, drive]),
                float(cars.temperature[car, drive]),
            )
            found.append(Recorded(virtual, folder / "recordings" / name / file))
    return found


def write_drives(
    cars: VirtualCars, folder: str | Path, workers: int, progress: Callable[[int, int], None] = lambda done, of: None
) -> list[str]:
    """Simulate a fleet into a folder, with the fleet file for `tierod fleet` and the truth; returns the failures."""
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    tasks = recordings_of(cars, target)
    write_text(target / "fleet.toml", fleet_file(cars))
    write_truth(cars, target / "truth.parquet")
    failures = []
    for done, (number, outcome) in enumerate(run(record, tasks, workers)):
        if isinstance(outcome, Failure):
            failures.append(f"{tasks[number].path.name}: {outcome.reason}")
        progress(done + 1, len(tasks))
    return failures


def fleet_file(cars: VirtualCars) -> str:
    lines = ["[[recordings]]", f"pattern = '{PATTERN}'", f"parameters = {json.dumps(cars.file.vehicle)}", ""]
    for number, name in enumerate(cars.names):
        labels = ", ".join(f"{json.dumps(kind)} = {json.dumps(names[number])}" for kind, names in cars.labels.items())
        if labels:
            lines += [f"[vehicles.{name}]", f"cohort = {{{labels}}}", ""]
    return "\n".join(lines)


def write_truth(cars: VirtualCars, path: Path) -> None:
    """Write the true friction of every drive, and the ageing of its car."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    number = np.repeat(np.arange(len(cars.names)), cars.day.shape[1])
    table = pa.table(
        {
            "vehicle": np.array(cars.names)[number].tolist(),
            "start": stamps(cars.day.ravel()),
            "friction": cars.friction.ravel(),
            "temperature_K": cars.temperature.ravel(),
            "mileage_m": cars.mileage.ravel(),
            "ageing": np.array(cars.ageing)[number].tolist(),
            "ageing_begin": pa.array(cars.begin[number], from_pandas=True),
        }
    )
    with replacing(path) as temporary:
        pq.write_table(table, temporary)


def write_estimates(cars: VirtualCars, folder: str | Path, law: ErrorLaw) -> int:
    """Write drives at estimate level as the results of a fleet; returns the number of drives."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    from tierod.fleet.schema import ledger

    target = Path(folder)
    findings = findings_table(cars, *estimates(cars, law, (cars.file.seed, 1)))
    rows = [
        {"recording_name": name, "vehicle": vehicle, "outcome": "judged", "reason": "", "findings": 1}
        for name, vehicle in zip(findings["recording_name"].to_pylist(), findings["vehicle"].to_pylist(), strict=True)
    ]
    for name, table in (("findings", findings), ("ledger", pa.Table.from_pylist(rows, schema=ledger()))):
        (target / name).mkdir(parents=True, exist_ok=True)
        with replacing(target / name / "virtual.parquet") as temporary:
            pq.write_table(table, temporary)
    write_truth(cars, target / "truth.parquet")
    return len(findings)
