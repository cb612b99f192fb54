"""List the monitors: the signals that each one needs, its variants, and their sources."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tierod.cli.terminal import output, print_json, progress, rows
from tierod.core.shown import written

if TYPE_CHECKING:
    from tierod.monitors.decision import Decision
    from tierod.monitors.inspection import Lacking
    from tierod.monitors.session import Monitor
    from tierod.vehicles import Parameter, Vehicle


def monitors(
    name: Annotated[str | None, typer.Argument(help="a monitor, to see its signals and variants")] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(help="a vehicle: list what its file and its channel map lack, and what each addition brings"),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="print one JSON document")] = False,
) -> None:
    """List the monitors, or show one: the signals it needs, its variants, and their sources."""
    from tierod.monitors.registry import MONITORS

    if vehicle is not None:
        _for_vehicle(name, vehicle, json)
        return
    chosen = list(MONITORS.values()) if name is None else [MONITORS.required(name)]
    if json:
        print_json({"monitors": [_document(monitor) for monitor in chosen]})
        return
    if name is None:
        output().print(rows(("monitor", "what it does"), [(each.name, each.title) for each in chosen]))
        output().print("tierod monitors NAME shows signals, variants, sources and decisions of one", markup=False)
        return
    _show(chosen[0])


def _for_vehicle(name: str | None, vehicle: str, json: bool) -> None:
    """Print the requirements of every variant that a vehicle does not meet."""
    from tierod.monitors.inspection import lacking
    from tierod.monitors.registry import MONITORS
    from tierod.vehicles import load

    car = load(vehicle)
    chosen = list(MONITORS.values()) if name is None else [MONITORS.required(name)]
    found = {}
    with progress(f"opening the monitors for {car.name}") as advance:
        for place, each in enumerate(chosen):
            found[each.name] = {v.name: lacking(each, v, car) for v in each.variants.values()}
            advance((place + 1) / len(chosen))
    if json:
        rows_of = {name: {v: dataclasses.asdict(each) for v, each in parts.items()} for name, parts in found.items()}
        print_json({"vehicle": car.name, "monitors": rows_of})
        return
    for monitor in chosen:
        _show_lacking(monitor, found[monitor.name], car, name is not None)


def _spread(parameter: Parameter) -> str:
    """Standard deviation of a parameter as text: relative, or in its unit if its value is zero."""
    deviation = parameter.standard_deviation or 0.0
    if parameter.value == 0.0:
        return f"±{deviation:.2g} {written(parameter.unit)}".rstrip()
    return f"±{deviation / abs(parameter.value):.0%}"


def _show_lacking(monitor: Monitor, found: Mapping[str, Lacking], car: Vehicle, whole: bool) -> None:
    """Print whether a monitor can run with a vehicle, and what the default variant, or the first one, lacks."""
    from tierod.core.signals import SIGNALS
    from tierod.vehicles import QUANTITIES

    console = output()
    able = [name for name, each in found.items() if not each.obstacle and not each.needed_signals]
    console.print(
        f"[bold]{monitor.name}[/bold]: {'can run as ' + ', '.join(able) if able else 'cannot run'} with {car.name}"
    )
    name = monitor.default or next(iter(found))
    each = found[name]
    cells = [(p, "parameter", f"needed by {name}", QUANTITIES[p].meaning) for p in each.needed]
    cells += [(s, "signal", f"needed by {name}", SIGNALS[s].meaning) for s in each.needed_signals or ()]
    if each.obstacle and not each.needed:
        console.print(each.obstacle, markup=False)
    if whole:
        cells += [(p, "guess", f"known to {_spread(car.parameters[p])}", QUANTITIES[p].meaning) for p in each.guessed]
        more = [s for s in each.optional_signals or () if s in SIGNALS]
        cells += [(s, "signal", "makes it better", SIGNALS[s].meaning) for s in more]
        cells += [(p, "parameter", "replaces a default", QUANTITIES[p].meaning) for p in each.optional]
        if each.needed_signals is None:
            console.print(
                f"{car.name} names no channel map: its signals are not known here; 'tierod inspect' lists them"
            )
        if each.guessed:
            console.print("'tierod diagnose' ranks the guesses by how far each moves the result of a recording")
    if cells:
        console.print(rows(("missing or guessed", "kind", "what it brings", "meaning"), cells))
    console.print()


def _document(monitor: Monitor) -> dict[str, Any]:
    from tierod.monitors.registry import MONITORS

    return {
        "name": monitor.name,
        "package": MONITORS.package_of(monitor.name),
        "title": monitor.title,
        "summary": monitor.summary,
        "source": monitor.source,
        "required": list(monitor.required),
        "optional": list(_measured(monitor.optional)),
        "minimum_rate": monitor.minimum_rate,
        "condition": monitor.condition,
        "drive": monitor.drive,
        "default": monitor.default,
        "variants": [
            {
                "name": each.name,
                "summary": each.summary,
                "source": each.source,
                "required": list(monitor.needing(each).required),
                "decisions": [_decision(decision) for decision in each.decisions],
            }
            for each in monitor.variants.values()
        ],
    }


def _decision(decision: Decision) -> dict[str, Any]:
    shown = decision.demonstrated
    return {
        "name": decision.name,
        "distance": decision.distance,
        "rule": decision.rule_in_words,
        "mean_between_false_alarms": decision.mean_time_between_false_alarms,
        "unit": decision.unit,
        "demonstrated": shown and {"observed": shown.observed, "alarms": shown.alarms, "fewer_per_unit_95": shown.most},
        "source": decision.source,
    }


def _show(monitor: Monitor) -> None:
    from tierod.core.signals import SIGNALS
    from tierod.monitors.registry import MONITORS

    console = output()
    console.print(
        f"[bold]{monitor.name}[/bold]: {monitor.title}", monitor.summary, f"Source: {monitor.source}", sep="\n"
    )
    console.print(f"Package: {MONITORS.package_of(monitor.name)}", markup=False)
    if monitor.drive:
        console.print(f"Drive: {monitor.drive}", markup=False)
    console.print("\n[bold]Signals[/bold]")
    signals = [
        (name, use, written(SIGNALS[name].unit), SIGNALS[name].meaning)
        for use, names in (("needed", monitor.required), ("helps", _measured(monitor.optional)))
        for name in names
    ]
    console.print(rows(("signal", "use", "unit", "meaning"), signals))
    console.print(f"Needed signals at {monitor.minimum_rate:g} Hz or faster.")
    if monitor.condition:
        console.print(f"Only if {monitor.condition}.")
    which = f"the default is {monitor.default}" if monitor.default else "no default: choose one with --variant"
    console.print(f"\n[bold]Variants[/bold], {which}")
    console.print(
        rows(("variant", "what it does", "source"), [(v.name, v.summary, v.source) for v in monitor.variants.values()])
    )
    for line in _other_needs(monitor):
        console.print(line, markup=False)
    _show_decisions(monitor)
    console.print()


def _other_needs(monitor: Monitor) -> Iterable[str]:
    """Signals that variants need in place of the monitor's own; a diagnosis uses them if those are missing."""
    for each in monitor.variants.values():
        needed = monitor.needing(each).required
        if others := [name for name in needed if name not in monitor.required]:
            replaced = [name for name in monitor.required if name not in needed]
            yield f"{each.name} needs {', '.join(others)} in place of {', '.join(replaced)}."


def _show_decisions(monitor: Monitor) -> None:
    """Print the decisions of the default variant, or of the first one; the JSON document has those of all."""
    variant = monitor.variants[monitor.default or next(iter(monitor.variants))]
    if variant.decisions:
        console = output()
        console.print(f"\n[bold]Decisions[/bold] of the variant {variant.name}")
        cells = [
            (each.name, each.distance, each.rule_in_words, each.false_alarms_in_words) for each in variant.decisions
        ]
        console.print(rows(("decides", "on", "rule", "false alarms"), cells))


def _measured(names: Iterable[str]) -> tuple[str, ...]:
    """The signals that a car can measure, without the truths of a simulation."""
    from tierod.core.signals import SIGNALS

    return tuple(name for name in names if name in SIGNALS)
