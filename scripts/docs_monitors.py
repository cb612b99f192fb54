"""Reference of the monitors, generated from the monitors: signals, parameters, variants, decisions, trouble codes.

The parameters are found by opening every variant with every shipped vehicle and recording which of them are read.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Collection, Mapping
from typing import Any

from docs_text import names, page, table

from tierod.core.signals import SIGNALS
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.monitors.inspection import Reading, readings
from tierod.monitors.registry import MONITORS
from tierod.monitors.session import Monitor
from tierod.vehicles import QUANTITIES, load, shipped

# Page with the equations of each monitor, by its name
EXPLANATION = {name: f"../../explanation/{name}.md" for name in MONITORS}


def pages() -> dict[str, Callable[[], str]]:
    every = {f"reference/monitors/{name}.md": functools.partial(monitor_page, name) for name in MONITORS}
    return {"reference/monitors/index.md": index, **every}


def index() -> str:
    rows = [
        (f"[`{each.name}`]({each.name}.md)", each.summary, f"`{each.default}`" if each.default else "to be chosen")
        for each in MONITORS.values()
    ]
    suited = []
    for vehicle in shipped():
        fitting = []
        for monitor in MONITORS:
            variants = [name for name, found in readings(monitor).items() if vehicle in found]
            if variants:
                some = "" if len(variants) == len(readings(monitor)) else f" ({names(variants)})"
                fitting.append(f"{monitor}{some}")
        car = load(vehicle)
        about = car.description.rstrip(".") + ("" if car.calibrated else "; torques in counts")
        suited.append((f"`{vehicle}`", about, ", ".join(fitting)))
    return page(
        "Monitors",
        "`tierod diagnose RECORDING --monitor NAME` runs one of them. Without `--monitor` the vehicle file names it; "
        "else every monitor runs that recording and vehicle file allow. `tierod inspect RECORDING` lists these.",
        table(("monitor", "what it does", "default variant"), rows),
        "## Shipped vehicles",
        "`tierod vehicles NAME` prints one with the source of every value, and what it is good and not good for. The "
        "last column names the monitors, or variants, that a vehicle file has all needed parameters for.",
        table(("vehicle", "what it is", "monitors"), suited),
    )


def monitor_page(name: str) -> str:
    monitor = MONITORS[name]
    return page(
        name,
        f"**{monitor.title}.** {monitor.summary}",
        f"Source: {monitor.source}. [Equations and limits]({EXPLANATION[name]}).",
        f"**What to record.** {monitor.drive}",
        "## Signals",
        _signals(monitor),
        "## Variants",
        _variants(monitor),
        "## Parameters",
        _parameters(monitor),
        "## Decisions",
        _decisions(monitor),
        _codes(name),
    )


def _signals(monitor: Monitor) -> str:
    uses = {"needed": monitor.required, "optional": monitor.optional}
    rows = [(use, names([name for name in group if name in SIGNALS])) for use, group in uses.items() if group]
    slower = f", or slower for slow recordings ({', '.join(f'{rate:g}' for rate in monitor.slower)} Hz)"
    parts = [
        table(("use", "signals"), rows),
        f"Needed signals come at {monitor.minimum_rate:g} Hz or faster. The monitor runs at {monitor.rate:g} Hz"
        f"{slower if monitor.slower else ''}; a sample older than {monitor.maximum_age:g} s is missing."
        + (f" It runs only if {monitor.condition}." if monitor.condition else "")
        + (" It learns a baseline of the vehicle (`--baseline`)." if monitor.learns else "")
        + " [Units and meaning](../signals.md).",
    ]
    others = [each for each in monitor.variants.values() if each.required is not None]
    if others:
        parts.append(table(("variant", "needs"), [(f"`{each.name}`", names(each.required or ())) for each in others]))
    return "\n\n".join(parts)


def _linked(source: str) -> str:
    return re.sub(r"docs/([\w/-]+\.md)", r"[this page](../../\1)", source)


def _variants(monitor: Monitor) -> str:
    rows = []
    for each in monitor.variants.values():
        where = _linked(each.source).replace(monitor.source, "").strip("; ,")
        where = "" if where.startswith("beyond") else where  # the page with the equations, linked above
        name = f"`{each.name}`" + (" (default)" if each.name == monitor.default else "")
        rows.append((name, each.summary, where))
    return table(("variant", "what it does", "of the source"), rows)


def _parameters(monitor: Monitor) -> str:
    found = {variant: cars for variant, cars in readings(monitor.name).items() if cars}
    uses: dict[str, dict[str, str]] = {}
    for variant, cars in found.items():
        common = set.intersection(*(reading.needed for reading in cars.values()))
        for name in QUANTITIES:
            if name in common:
                uses.setdefault(name, {})[variant] = "needed"
            elif any(name in reading.needed | reading.optional for reading in cars.values()):
                uses.setdefault(name, {})[variant] = _in_some(name, cars)
    order = sorted(uses, key=lambda name: (set(uses[name].values()) != {"needed"}, list(QUANTITIES).index(name)))
    by_use: dict[str, list[str]] = {}
    for name in order:
        by_use.setdefault(_use(uses[name], found), []).append(name)
    return "[Units and meaning](../parameters.md).\n\n" + table(
        ("use", "parameters"), [(use, names(group)) for use, group in by_use.items()]
    )


def _in_some(name: str, cars: Mapping[str, Reading]) -> str:
    needing = [car for car, reading in cars.items() if name in reading.needed]
    return f"needed in a car such as {names(needing)}" if needing else "optional"


def _use(by_variant: Mapping[str, str], every: Collection[str]) -> str:
    kinds: dict[str, list[str]] = {}
    for variant in every:
        kinds.setdefault(by_variant.get(variant, ""), []).append(variant)
    if len(kinds) == 1:
        return next(iter(kinds))
    unused = kinds.pop("", [])
    if len(kinds) == 1 and len(unused) < len(every) / 2:
        return f"{next(iter(kinds))}; not used by {names(unused)}"
    parts = [f"{use}: {names(which)}" for use, which in kinds.items()]
    if not unused:
        largest = max(kinds, key=lambda use: len(kinds[use]))
        parts = [f"{use}: {names(which)}" for use, which in kinds.items() if use != largest] + [f"{largest}: others"]
    return "; ".join(parts)


def _decisions(monitor: Monitor) -> str:
    listed: list[Any] = []
    rows: list[tuple[str, ...]] = []
    origins: list[str] = []
    before: tuple[str, ...] = ("", "", "", "")
    for variant in monitor.variants.values():
        for each in variant.decisions:
            if each in listed:
                continue
            listed.append(each)
            sharing = [other.name for other in monitor.variants.values() if each in other.decisions]
            alarms = re.sub(r"(none in [^,;]+), so fewer than [^;]+ at 95 %", r"\1", each.false_alarms_in_words)
            if each.source not in origins:
                origins.append(each.source)
            lacking = [other for other in monitor.variants if other not in sharing]
            which = f" (not {names(lacking)})" if len(lacking) < len(sharing) else f" ({names(sharing)})"
            which = which if lacking else ""
            origin = str(origins.index(each.source) + 1)
            cells = (each.distance, each.rule_in_words, alarms, origin)
            shown = [
                "as above" if rows and cell == last and len(cell.split()) > 3 else cell
                for cell, last in zip(cells, before, strict=True)
            ]
            rows.append((each.name + which, *shown))
            before = cells
    header = ("decision", "statistic", "stopping rule", "false alarms", "from")
    numbered = "\n".join(f"{number}. {_linked(origin)}" for number, origin in enumerate(origins, 1))
    return (
        "[Designed and demonstrated](../../explanation/stopping-rules.md#what-monitors-declare) false alarms; none in "
        "T means fewer than 3/T at 95 %.\n\n" + table(header, rows) + f"\n\nFrom:\n\n{numbered}"
    )


def _codes(name: str) -> str:
    codes = load_trouble_codes().of_monitor(name).values()
    if not codes:
        return ""
    return f"## Trouble codes\n\n[{len(codes)} codes](../trouble-codes.md): {names(each.code for each in codes)}."
