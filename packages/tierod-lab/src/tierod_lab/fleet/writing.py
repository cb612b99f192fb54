"""Output of a virtual fleet: its drives as recordings, or their estimates as the results of a fleet."""

from __future__ import annotations

import datetime as dt
import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.files import replacing, write_text
from tierod.core.recording import Channel, Recording
from tierod.core.toml import Document, build
from tierod.fleet.series import stamps
from tierod.work.pool import Failure, run
from tierod_lab.fleet.estimates import ErrorLaw, estimates, findings_table
from tierod_lab.fleet.virtual import VirtualCars
from tierod_lab.ground import SensorSet, drive
from tierod_lab.ground.cars.road_cars import EpsCar
from tierod_lab.ground.chassis.two_track import TwoTrack
from tierod_lab.ground.chassis.tyres import TYRES
from tierod_lab.ground.courses.roads import City, Country, Motorway
from tierod_lab.ground.run import CHANNELS
from tierod_lab.ground.scatter import Scatter

_CARS, _ROADS = 77, 78  # Numbers of the random streams of cars and roads

BETWEEN_DRIVES = Scatter(
    torque_gain=0.0, damping=0.0, inertia=0.0, trail=0.05, driver_torque_offset=0.1, lateral_acceleration_bias=0.1,
    tyre_stiffness=0.05, mass=0.04,
)  # fmt: skip
"""Scatter from drive to drive of one car: load (standard deviation 64 kg), tyre pressure and wear, zero drift."""

AMBIENT = "ambient_temperature"


@dataclass(frozen=True)
class VirtualDrive:
    """One drive of one car."""

    car: int  # seed of the car's parameters
    road: int  # seed of road, driver, load and noise
    friction: Annotated[float, "N*m"]  # true friction
    duration: Annotated[float, "s"]
    winter: bool = False  # whether the car has winter tyres
    temperature: Annotated[float, "K"] = 288.15

    def recording(self) -> Recording:
        """The drive as measured by the sensors of a production car, with the ambient temperature."""
        car = EpsCar()
        assert isinstance(car.chassis, TwoTrack)
        if self.winter:
            car = replace(car, chassis=car.chassis.on_tyres(TYRES["winter"]))
        sensors = SensorSet.production().only(CHANNELS)
        car, sensors = Scatter().draw(car, sensors, np.random.default_rng([self.car, _CARS]))
        chance = np.random.default_rng([self.road, _ROADS])
        roads = [(City(), Country(), Motorway())[number] for number in chance.permutation(3)]
        found = drive(car, self.duration / 60.0, self.friction, self.road, BETWEEN_DRIVES, sensors, roads)
        first, last = found.span
        time = np.arange(first, last, 10.0)
        air = Channel(AMBIENT, time, np.full(len(time), self.temperature), "K")
        return replace(found, channels={**found.channels, AMBIENT: air})


EPOCH = dt.datetime(1970, 1, 1, tzinfo=dt.UTC)
PATTERN = r"(?P<vehicle>car-\d+)/(?P<start>\d{8}T\d{6})_(?P<mileage>\d+)km\.parquet$"
"""Pattern of the names of recordings: vehicle, time and mileage."""


def shipped_law() -> ErrorLaw:
    """The shipped error model for drives at estimate level, measured on drives of five minutes."""
    document = Document.read(Path(__file__).with_name("friction-errors.toml"), "error law")
    law: ErrorLaw = build(ErrorLaw, document.content, document)
    return law


class Recorded(NamedTuple):
    """Recording to be made."""

    drive: VirtualDrive
    path: Path


def record(task: Recorded) -> None:
    """Simulate and write one recording, unless it exists: then it is complete, from an earlier run."""
    from tierod.io.writers import write

    if not task.path.is_file():
        task.path.parent.mkdir(parents=True, exist_ok=True)
        write(task.drive.recording(), task.path)


def recordings_of(cars: VirtualCars, folder: Path) -> list[Recorded]:
    found = []
    for number, car in np.ndindex(cars.day.T.shape):
        start = EPOCH + dt.timedelta(days=float(cars.day[car, number]))
        file = f"{start:%Y%m%dT%H%M%S}_{cars.mileage[car, number] / 1000.0:.0f}km.parquet"
        # Distinct seeds for up to a million cars and 4099 drives per car.
        seed, friction = cars.file.seed * 1_000_003 + car, float(cars.friction[car, number])
        around = bool(cars.winter[car, number]), float(cars.temperature[car, number])
        virtual = VirtualDrive(seed, seed * 4099 + number, friction, cars.file.duration, *around)
        found.append(Recorded(virtual, folder / "recordings" / cars.names[car] / file))
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
