"""Print the verdicts that change when a tuning parameter of a monitor is 20 % larger or smaller.

python scripts/sensitivity.py friction
python scripts/sensitivity.py motor-angle
python scripts/sensitivity.py sideslip
python scripts/sensitivity.py driver-torque

The drives are not used in any study: their seeds are below those that the monitors draw. A number that changes no
verdict is uncritical; all others are listed with their effects. `tierod study condition --thorough` contains the same
for the condition monitor, with drives drawn for it.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from docs_text import table

from tierod.core.graph import scan

FACTORS = (0.8, 1.2)
GIVEN = ("parameters", "limits", "sample_time", "learnt_level", "learnt_deviation", "pole_pairs", "nominal_flux")
"""Fields that come from the vehicle file or the recording, and are no tuning parameters."""


class Case(NamedTuple):
    """A drive, and the verdict of a block on it.

    Args:
        name: what happens in the drive
        verdict: function of the block
    """

    name: str
    verdict: Callable[[Any], str]


def numbers(block: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Paths of all tuning parameters of a block: fields of dataclasses that are not derived from others."""
    for field in dataclasses.fields(block):
        value = getattr(block, field.name)
        if not field.init or field.name in GIVEN:
            continue
        if field.name == "ceiling" and value == getattr(block, "threshold", None):
            continue
        if isinstance(value, float):
            if np.isfinite(value) and value != 0.0:
                yield (*path, field.name)
        elif dataclasses.is_dataclass(value) and not isinstance(value, type):
            yield from numbers(value, (*path, field.name))
        elif isinstance(value, tuple) and hasattr(value, "_fields"):
            there = zip(value._fields, value, strict=True)
            yield from ((*path, field.name, name) for name, each in there if isinstance(each, float) and each != 0.0)


def scaled(block: Any, path: Sequence[str], factor: float) -> Any:
    """The block with one of its numbers scaled."""
    name, *rest = path
    value = getattr(block, name)
    changed = scaled(value, rest, factor) if rest else factor * value
    if isinstance(block, tuple):
        return block._replace(**{name: changed})  # type: ignore[attr-defined]
    changes = {name: changed}
    if name == "threshold" and getattr(block, "ceiling", None) == value:
        changes["ceiling"] = changed  # A ceiling equal to the threshold is derived from it.
    return dataclasses.replace(block, **changes)


def friction() -> tuple[Any, list[Case]]:
    """Friction monitor with fault-free and faulty cars, and with recordings that permit no verdict."""
    from tierod.core.block import leaves, skeleton
    from tierod.papers.friction.cases import Case as Drive
    from tierod.papers.friction.estimators import monitor

    block = monitor((4.0, 0.1))
    names = [name for name, _ in leaves(skeleton(block.Sample))]

    def case(name: str, drive: Drive, wrong: Mapping[str, float]) -> Case:
        values = np.array(drive.recording().align(names, 100.0).values)
        for signal, factor in wrong.items():
            values[:, names.index(signal)] *= factor
        return Case(name, lambda each: str(each.finding(scan(each, values)).status))

    levels = {"fault-free": 4.0, "1.5 N·m more": 5.5, "4 N·m more": 8.0, "8.5 N·m more": 12.5}
    cases = [
        case(f"{name}, drive {seed}", Drive(seed, level, 6.0, car=seed), {})
        for name, level in levels.items()
        for seed in (41, 42, 43)
    ]
    for seed in (44, 45):
        drive = Drive(seed, 4.0, 6.0, car=seed)
        cases.append(case(f"wrong sign of the rate, drive {seed}", drive, {"steering_wheel_rate": -1.0}))
        cases.append(case(f"acceleration in g, drive {seed}", drive, {"lateral_acceleration": 1.0 / 9.81}))
    return block, cases


def motor_angle() -> tuple[Any, list[Case]]:
    """Motor angle monitor with fault-free motors, and with every kind of sensor fault."""
    from tierod.papers.motor_angle.fault_drives import drive
    from tierod.papers.motor_angle.fault_kinds import FAULTS
    from tierod.papers.motor_angle.healthy_drives import bench_monitor

    def case(name: str, samples: np.ndarray) -> Case:
        def verdict(block: Any) -> str:
            found = scan(block, samples)
            alarms = (each for each in found.names if each.startswith("alarms."))
            return "alarm" if any((found[each] > 0.5).any() for each in alarms) else "none"

        return Case(name, verdict)

    cases = [case(f"fault-free, drive {seed}", drive(seed, 9.0).samples) for seed in (51, 52, 53)]
    cases += [case(fault.name, drive(54, 9.0, fault, 7.0).samples) for fault in FAULTS]
    return bench_monitor(), cases


def sideslip() -> tuple[Any, list[Case]]:
    """Sideslip monitor of a steer-by-wire car on several courses; the verdict is whether the 95 % band is valid."""
    from tierod.papers.sideslip.combined_drives import COURSES, errors, estimator, on

    def case(name: str) -> Case:
        drive = on(name, 61)

        def verdict(block: Any) -> str:
            error, held = errors(drive, scan(block, drive.samples))
            return f"band {'holds' if np.mean(held) >= HELD else 'does not hold'}" if len(error) else "not estimated"

        return Case(name, verdict)

    return estimator(), [case(name) for name in COURSES]


def driver_torque() -> tuple[Any, list[Case]]:
    """Hands-on monitor on benches; the verdict is whether every change is detected without false ones."""
    from tierod.monitors.driver_torque.hands import HandsMonitor
    from tierod.papers.column.handled_bench import STEP, drawn, pieces, score
    from tierod.vehicles import load

    def case(seed: int, share: float) -> Case:
        bench = drawn(seed, share, 900.0)
        samples = np.concatenate([piece.samples for piece in pieces(bench)])

        def verdict(block: Any) -> str:
            found = score(scan(block, samples)["hands"], bench.course)
            missed = sum(int(np.isinf(each).sum()) for each in (found.grabs, found.releases))
            wrong = found.false_on + found.false_off
            return "right" if not missed and not wrong else f"{missed} not seen, {wrong} false"

        return Case(f"{share:.0%} off, bench {seed}", verdict)

    block = HandsMonitor.of_vehicle(load("column-bench"), STEP)
    return block, [case(seed, share) for share in (0.02, 0.05) for seed in (71, 72, 73)]


HELD = 0.9
"""Required share of true values in the 95 % band of a drive: 0.95 less one standard deviation for 20 errors."""

MONITORS = {"friction": friction, "motor-angle": motor_angle, "sideslip": sideslip, "driver-torque": driver_torque}


def rows(block: Any, cases: Sequence[Case]) -> Iterator[tuple[str, ...]]:
    """(number, value, changed verdicts at 0.8 and at 1.2 times the value, effects) of every number of a block."""
    usual = [case.verdict(block) for case in cases]
    for path in numbers(block):
        value = block
        for name in path:
            value = getattr(value, name)
        cells, changes = [], []
        for factor in FACTORS:
            try:
                found = [case.verdict(scaled(block, path, factor)) for case in cases]
            except Exception as error:  # a tuning that the block rejects
                cells.append("refused")
                changes.append(str(error).split(";")[0])
                continue
            different = [place for place, each in enumerate(found) if each != usual[place]]
            cells.append(f"{len(different)}")
            changes += [f"{cases[place].name}: {usual[place]} to {found[place]}" for place in different]
        yield f"`{'.'.join(path)}`", f"{value:g}", *cells, "; ".join(changes[:3])


def main(name: str = "") -> int:
    """Print the table of a monitor; returns the exit code."""
    if name not in MONITORS:
        print(f"there is no table of '{name}'; known: {', '.join(MONITORS)}", file=sys.stderr)
        return 1
    block, cases = MONITORS[name]()
    every = list(rows(block, cases))
    print(page(name, every, [case.name for case in cases]))
    return 0


def page(name: str, every: Sequence[tuple[str, ...]], cases: Sequence[str]) -> str:
    """Page of a monitor: numbers that change a verdict, and the number of those that do not."""
    changed = [list(row) for row in every if row[2:4] != ("0", "0")]
    return "\n\n".join(
        (
            f"# Sensitivity of the {name} monitor",
            f"<!-- Written by `python scripts/sensitivity.py {name}`; do not edit. -->",
            "Verdicts that change where one number of the tuning is a fifth smaller or larger, all others as they are. "
            "A number that changes none rests on no fine choice. The drives are none that a study reports.",
            f"{len(every) - len(changed)} of {len(every)} numbers change no verdict of {len(cases)} drives."
            + (" These do:" if changed else ""),
            table(("number", "value", "0.8 of it", "1.2 of it", "what changes"), changed) if changed else "",
            "Drives: " + "; ".join(cases) + ".",
        )
    ).replace("\n\n\n\n", "\n\n")


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:2]))
