"""Single precision on a control unit compared with double here: fault-free and faulty drives of every monitor.

`python -m benchmarks.single_precision` prints the table of docs/how-to/control-unit.md.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tierod.core.toml import Document
from tierod.export.c_export import files, interface_of, write_folder
from tierod.export.evidence.comparison import Apart, aim_of, apart
from tierod.export.interface import Interface, Options
from tierod.export.subject import Subject, subject_of
from tierod.export.vectors import inputs_from, rounded, vectors_of
from tierod.vehicles import load as vehicle
from tierod_lab.ground.scenarios import Scenario, from_document

_TABLE = 'name = "given"\ndescription = "With a fault or without."\n'


class Case(NamedTuple):
    """A monitor, and the drives on which it is run."""

    monitor: str  # monitor, vehicle: names
    vehicle: str
    drive: str  # scenario table without its name
    faults: dict[str, str]  # fault tables, one per further drive, by the name of their row


_BENCH = 'car = "motor-bench"\nseconds = "31 s"\n[course]\nname = "bench-sweep"\ntime = "31 s"\namplitude = "0.5 N*m"\n'
_HANDS = 'car = "midsize-eps"\ncourse = "hands-on-and-off"\n'
_MIXED = 'car = "midsize-eps"\ncourse = "mixed"\nseconds = "13 min"\nseed = 1\n'

_RISE = 'element = "steering.friction.level"\nbehaviour = "step"\nsize = "8 N*m"\nstart = "390 s"\n'
_TURN = 'element = "sensor.yaw_rate"\nbehaviour = "offset"\nsize = "0.1 rad/s"\nstart = "390 s"\n'

CASES = (
    Case("friction", "midsize-eps", _MIXED, {"friction doubles": _RISE}),
    Case("motor-angle", "motor-bench", _BENCH, {"motor-angle-offset": 'use = "motor-angle-offset"\nstart = "10 s"\n'}),
    Case("driver-torque", "midsize-eps", _HANDS, {"driver-torque-offset": 'use = "driver-torque-offset"\n'}),
    Case(
        "sideslip",
        "midsize-eps",
        _MIXED,
        {
            "lateral-acceleration-drop-out": 'use = "lateral-acceleration-drop-out"\n',
            "vehicle-speed-stuck": 'use = "vehicle-speed-stuck"\n',
            "yaw rate 0.1 rad/s too much": _TURN,
        },
    ),
)


def run() -> Iterator[tuple[Interface, list[Apart]]]:
    """Every monitor, with the effect of single precision on its results.

    Raises:
        SystemExit: gcc is not available
    """
    for case in CASES:
        subject = subject_of(case.monitor, case.vehicle)
        texts = {name: f"{case.drive}[[faults]]\n{fault}" for name, fault in case.faults.items()}
        samples = {name: _inputs(subject, case, text) for name, text in {"fault-free": case.drive, **texts}.items()}
        face = interface_of(subject, Options("single"))
        with tempfile.TemporaryDirectory() as place:
            write_folder(files(face, vectors_of(subject, samples["fault-free"], "a drive", 100)), Path(place))
            found = apart(face, Path(place), samples)
        if isinstance(found, str):
            sys.exit(found)
        yield face, found


def _inputs(subject: Subject, case: Case, text: str) -> np.ndarray:
    drive: Scenario = from_document(Document.parse(_TABLE + text, Path("given.toml"), "scenario"))
    return rounded(inputs_from(subject, vehicle(case.vehicle), drive.run().recording))


def main() -> int:
    """Print the table; returns 1 if a requirement is not met."""
    failed = 0
    print("| monitor | drive | clocks began at | largest difference | aim | changes of the status | they differ for |")
    print("|---|---|---|---|---|---|---|")
    for face, found in run():
        aim = aim_of(face)
        if aim is None:
            sys.exit(f"nothing is laid down for {face.subject.monitor}")
        for each in found:
            failed += not each.within(aim)
            print(
                f"| {face.subject.monitor} | {each.samples}, {each.steps} steps | {each.hours:g} h | "
                f"{each.largest:.2g} {aim.unit} | {aim.limit:g} {aim.unit} | {each.verdicts} | "
                f"{1e3 * each.longest:.3g} ms |"
            )
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
