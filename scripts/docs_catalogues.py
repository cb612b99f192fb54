"""Reference pages of what is shipped: signals, parameters, residuals, codes, faults, scenarios, words, papers."""

from __future__ import annotations

import contextlib
import functools
import io
import itertools
import json
import math
from collections.abc import Callable
from typing import Any

from docs_text import names, page, table, unit

from tierod.cli import main
from tierod.core.signals import SIGNALS
from tierod.core.statuses import SEVERITY
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.vehicles import QUANTITIES
from tierod_lab.papers.condition.rules.parameters import RESIDUALS
from tierod_lab.papers.contents import PAPERS, contents


def pages() -> dict[str, Callable[[], str]]:
    return {
        "reference/signals.md": signals,
        "reference/parameters.md": parameters,
        "reference/residuals.md": residuals,
        "reference/trouble-codes.md": trouble_codes,
        "reference/faults.md": faults,
        "reference/scenarios.md": scenarios,
        "reference/words.md": glossary,
        "reference/papers.md": papers,
    }


@functools.cache
def printed(*arguments: str) -> Any:
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        assert main([*arguments, "--json"]) == 0
    return json.loads(text.getvalue())


def signals() -> str:
    parts = []
    for group, members in itertools.groupby(SIGNALS.values(), key=lambda each: each.group):
        rows: list[tuple[str, ...]] = []
        for each in members:
            low, high = each.plausible
            range_ = unit(each.unit) if math.isinf(low) else f"{low:g} to {high:g} {unit(each.unit)}".removesuffix(" -")
            row = (f"`{each.name}`", each.meaning.rstrip("."), each.positive, range_)
            joined = _joined(rows[-1], row) if rows else None
            rows[-1:] = [joined] if joined else [*rows[-1:], row]
        parts += [f"## {group}", table(("signal", "meaning", "positive", "plausible values, or unit"), rows)]
    return page(
        "Signals",
        "SI units and radians inside; degrees, km/h and rpm only in files, reports and on the command line. ISO 8855: "
        "x forward, y left, z up. Values outside the plausible range of a healthy car earn a remark, never a "
        "correction. Usual other names of a signal are recognised.",
        *parts,
    )


def _joined(before: tuple[str, ...], row: tuple[str, ...]) -> tuple[str, ...] | None:
    """One row (name, meaning, ...) of two whose meanings differ in one word alone: phases, axes, wheels."""
    words, others = before[1].split(), row[1].split()
    differing = [place for place, pair in enumerate(zip(words, others, strict=False)) if pair[0] != pair[1]]
    if len(words) != len(others) or len(differing) != 1 or before[2:] != row[2:]:
        return None
    words[differing[0]] += f"/{others[differing[0]]}"
    return f"{before[0]}, {row[0]}", " ".join(words), *row[2:]


def glossary() -> str:
    statuses = [(f"`{each}`", each.symbol, f"`{each.colour}`", str(each.exit_code), each.meaning) for each in SEVERITY]
    return page(
        "Statuses",
        "The words of a verdict. Every other term of a report is explained at the end of that report.",
        "The worst comes first: the status of several monitors, or of several recordings, is the first of this list "
        "that one of them has. Terminal, JSON, report, fleet, live display and web page show the same word, symbol and "
        "colour.",
        table(("status", "symbol", "colour", "exit code", "meaning"), statuses),
        "A monitor that only estimates is `estimated` or `consistent`, never `healthy`, and `inconsistent`, never "
        "`suspect`.",
    )


def parameters() -> str:
    rows: list[tuple[str, ...]] = []
    for each in QUANTITIES.values():
        row = (f"`{each.name}`", each.meaning, unit(each.unit) + (" or count" if each.torque else ""))
        joined = _joined(rows[-1], row) if rows else None
        rows[-1:] = [joined] if joined else [*rows[-1:], row]
    return page(
        "Parameters of a vehicle",
        "The names that a [vehicle file](vehicle-file.md) may hold. A value that no car has is an error, which states "
        "the plausible range. "
        "[Each monitor's page](monitors/index.md) lists the parameters that it needs and can use.",
        table(("parameter", "meaning", "unit"), rows),
    )


def residuals() -> str:
    rows: list[tuple[str, ...]] = []
    equations: list[str] = []
    for each in RESIDUALS.values():
        row = (f"`{each.name}`", each.meaning, unit(each.unit), each.correction)
        equation = each.equation.removeprefix("Li, Frey, Gauterin, ")
        found = ((place, _joined(before, row)) for place, before in enumerate(rows))
        place, joined = next((pair for pair in found if pair[1]), (len(rows), None))
        rows[place : place + 1] = [joined or row]
        several = joined is not None and equations[place] != equation
        equations[place : place + 1] = [f"{equations[place]}, {equation}" if several else equation]
    return page(
        "Residuals of the condition monitor",
        "A residual is an estimate less a measurement, or a target less an actual value. It is judged only where its "
        "signals are present and, for most, above walking speed; those of the single-track model below 6 m/s² of "
        "lateral acceleration; those of the requested torque where it does not jump. Equations are those of "
        "[the paper](../explanation/papers/condition.md).",
        table(
            ("name", "what", "equation", "unit", "corrected"),
            ((*row[:2], equation, *row[2:]) for row, equation in zip(rows, equations, strict=True)),
        ),
    )


def trouble_codes() -> str:
    rows = []
    for name, code in load_trouble_codes().codes.items():
        statuses = f"{', '.join(code.failed_by)}/{', '.join(code.passed_by)}"
        cycles = f"{code.confirmation_cycles}/{code.healing_cycles}/{code.aging_cycles}"
        unusual = [each for each in (statuses, cycles) if each not in ("fault/healthy", "1/3/40")]
        unusual += [] if code.lamp else ["no lamp"]
        cells = (code.meaning, str(code.priority), code.reaction, names(code.consequence_of), "; ".join(unusual))
        rows.append((f"`{code.code}`", f"`{name}`", *cells))
    header = ("code", "name", "meaning", "priority", "reaction", "consequence of", "unusual")
    return page(
        "Trouble codes",
        "Letter and digits of ISO 15031-6, type of failure of SAE J2012-DA. Usually the status fault fails a code and "
        "healthy passes it, any other gives no result; 1 failed cycle confirms it, 3 passed ones heal it, 40 more age "
        "it (1/3/40), and the lamp lights. A code is not raised while one that it is a consequence of has failed. "
        "[How the fault memory uses them](../how-to/fault-memory.md).",
        table(header, rows),
    )


IN_UNIT = " [unit of the element]"
SENSOR_FAULTS = ("-loss", "-offset", "-negative-offset", "-outlier")  # Endings of the faults that six sensors share


def faults() -> str:
    shipped_faults = [each["name"] for each in printed("faults")["faults"]]
    sensors = [name.removesuffix("-outlier") for name in shipped_faults if name.endswith("-outlier")]
    every = [f"{sensor}{ending}" for sensor in sensors for ending in SENSOR_FAULTS]
    single = names(name for name in shipped_faults if name not in every)
    kinds = [
        (f"`{each['name']}`", each["description"], each["fields"].replace(IN_UNIT, ""), each["elements"])
        for each in printed("faults", "--behaviours")["behaviours"]
    ]
    return page(
        "Faults",
        "Faults that can be injected into a simulation. `tierod faults NAME` prints one; "
        "[how to use them](../how-to/inject-faults.md).",
        "## Shipped faults",
        f"`tierod faults` describes them: {single}.",
        f"The sensors {names(sensors)} have the faults {names(f'SENSOR{each}' for each in SENSOR_FAULTS)}.",
        "## Behaviours",
        "Fields in brackets have a default; those without a unit are in that of the element, or pure numbers.",
        table(("behaviour", "what it does", "fields", "elements"), kinds),
    )


def scenarios() -> str:
    rows = [(f"`{each['name']}`", each["description"]) for each in printed("scenarios")["scenarios"]]
    cars = []
    for each in printed("scenarios", "--cars")["cars"]:
        found = printed("scenarios", each["name"], "--cars")
        cars.append((f"`{each['name']}`", each["description"], f"`{found['vehicle']}`" if found["vehicle"] else ""))
    return page(
        "Scenarios, virtual cars and courses",
        "`tierod simulate NAME -o drive.mf4` drives a scenario; `tierod scenarios NAME` prints a scenario, car or "
        "course with every parameter, `--toml` its file. [How to write one](../how-to/simulate.md).",
        "## Scenarios",
        table(("scenario", "what it is"), rows),
        "## Cars",
        "The last column names the vehicle file that monitors use for the recordings of the car.",
        table(("car", "what it is", "vehicle"), cars),
        "## Courses",
        "`tierod scenarios --courses` lists natural drives, circuits, ISO 4138, 7401, 13674-1, 3888-1 and others.",
    )


def papers() -> str:
    rows = []
    for package in PAPERS:
        held = contents(package)
        misprints = sum("misprint" in row.verdict for row in held.rows)
        gaps = sum("gap" in row.verdict for row in held.rows)
        counts = (str(number) for number in (held.equations, held.tables, held.figures, misprints, gaps))
        rows.append((f"[{held.paper}](../explanation/papers/{held.explanation}.md)", *counts))
    return page(
        "The five papers",
        "tierod carries out every numbered equation, table and figure of five papers; their pages explain what is "
        "corrected. In the repository `contents.toml` of each package of `tierod_lab.papers` names, for every number, "
        "the function that implements it and what differs from the print; a test requires that none is missing.",
        table(("paper", "equations", "tables", "figures", "parts with misprints", "with gaps"), rows),
        "[Claims of the papers, measured](studies/index.md).",
    )
