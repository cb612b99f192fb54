"""Diagnosis of a recording of any length by one monitor."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from tierod.core import lab
from tierod.core.errors import ParameterError, nearest
from tierod.core.findings import Diagnosis, Status
from tierod.core.recording import Recording
from tierod.io.writers import require_writable, write
from tierod.monitors.harness.baseline import Baseline, keep_first, load_baseline
from tierod.monitors.harness.named_vehicle import vehicle_named_in
from tierod.monitors.harness.over_time import OverTime
from tierod.monitors.harness.pieces import pieces_of, share_read
from tierod.monitors.harness.session import Monitor, Variant
from tierod.monitors.registry import MONITORS, obstacle
from tierod.monitors.run import Run
from tierod.vehicles import Vehicle, load


def diagnose(
    source: Recording | str | Path,
    vehicle: Vehicle | str | Path | None = None,
    monitor: str | Monitor | Variant | None = None,
    variant: str | Variant | None = None,
    *,
    dbc: Any = None,
    channel_map: Any = None,
    baseline: Baseline | str | Path | None = None,
    memory: str | Path | None = None,
    signals: str | Path | None = None,
    spread: bool = True,
    fault_free: bool = False,
    command: str = "",
    progress: Callable[[float], None] = lambda share: None,
) -> Diagnosis:
    """Diagnose a recording with a monitor.

    Args:
        source: a recording, or the path of one; a file is read and judged piece by piece
        vehicle: parameter set, its name, or the path of its file; None takes the one that the recording names
        monitor: name of a registered monitor, a monitor, or a variant of a registered one; None takes the monitor of
            the vehicle file, or friction where the file names none
        variant: name of the variant, or a variant; the monitor's default where not given, if it has one
        dbc: path(s) of CAN databases; the vehicle's own where not given
        channel_map: path of a channel map; the vehicle's own where not given
        baseline: baseline of this vehicle from earlier recordings, or the path of its file. A file that does not exist
            yet is written if the verdict is healthy; an existing file is never changed, so that a slow fault cannot
            become part of the baseline
        memory: path of a fault memory, which takes the recording as one operation cycle; created if it does not exist
        signals: path of a file (.parquet, .csv or .mf4) for the inputs and estimates of the monitor over time, at the
            rate of its grid, substitutes of sensors included
        spread: whether the spread of the vehicle's parameters is carried into bands and verdict, which takes up to four
            times the computing time
        fault_free: whether the vehicle is known to have been fault-free in the recording: a baseline is then learnt
            from it though guesses in the vehicle file forbid a verdict
        command: command line as typed by the user, for the report
        progress: called with the completed share, 0 to 1

    Raises:
        InputError: the recording cannot be read, or lacks a signal that the monitor needs; or the baseline belongs to
            another vehicle or monitor
        OutputError: the baseline, the fault memory or the signals cannot be written
        ParameterError: no such vehicle, monitor or variant; no vehicle given, and the recording names none; or no
            variant given, and the monitor has no default
    """
    kept = None if signals is None else _kept_for(signals)
    named = vehicle_named_in(source, dbc, channel_map) if vehicle is None else vehicle
    car = named if isinstance(named, Vehicle) else load(named)
    definition, chosen = find(monitor or usual_monitor(car), variant)
    known = baseline if isinstance(baseline, Baseline) else _stored(baseline)
    run = Run(definition, chosen, car, known, memory, kept, uncertain=spread)
    pieces = pieces_of(source, run.needs, car, dbc, channel_map)
    run = _over(run, pieces, variant is not None or isinstance(monitor, Variant), progress)
    diagnosis = run.finish(command)
    if signals is not None and kept is not None:
        _write_signals(kept, diagnosis, run.monitor.name, signals)
    if isinstance(baseline, str | Path):
        diagnosis = diagnosis.remarked("baseline", _kept(run, baseline, known, diagnosis, fault_free))
    return diagnosis


def _over(run: Run, pieces: Iterable[Recording], asked: bool, progress: Callable[[float], None]) -> Run:
    """Run over all pieces of a recording, with the default variant that suits it unless the user asked for one."""
    for place, piece in enumerate(pieces):
        # Only the first piece shows the rates and signals on which the grid and the default variant depend.
        run = run if place else run.fitted(piece, asked)
        run.add(piece)
        progress(share_read(piece))
    return run


def _kept_for(path: str | Path) -> OverTime:
    require_writable(path)
    return OverTime()


def _write_signals(kept: OverTime, diagnosis: Diagnosis, monitor: str, path: str | Path) -> None:
    units = {name: each.unit for name, each in diagnosis.traces.items()}
    write(kept.recording(units, f"tierod, monitor {monitor}"), path)


def _kept(run: Run, path: str | Path, known: Baseline | None, diagnosis: Diagnosis, fault_free: bool) -> str:
    """Write the baseline file after the first fault-free recording; what became of it, in a sentence."""
    if known is not None:
        return f"judged against {path}, learnt {known.learnt or 'at a time unknown'}; the file stays as it is"
    learnt = run.learnt or (run.unproven if fault_free else None)
    if learnt is not None:
        return keep_first(dataclasses.replace(learnt, learnt=diagnosis.created), path)
    status = diagnosis.findings[0].status
    if not run.monitor.learns:
        reason = f"the monitor '{run.monitor.name}' learns no baseline"
    elif status is not Status.HEALTHY:
        reason = f"the verdict is '{status}', and a baseline is learnt from a healthy recording only"
        if run.unproven is not None:
            reason += "; if you know that the car was fault-free in this recording, add --fault-free"
    else:
        reason = "too little of the recording could be judged to learn one"
    return f"{path} was not written: {reason}"


def _stored(path: str | Path | None) -> Baseline | None:
    return load_baseline(path) if path is not None and Path(path).exists() else None


def usual_monitor(vehicle: Vehicle) -> str:
    """Name of the monitor for a vehicle's recordings where the user names none.

    Args:
        vehicle: vehicle whose file may name a monitor; friction where it does not
    """
    return vehicle.monitor or "friction"


def find(monitor: str | Monitor | Variant, variant: str | Variant | None = None) -> tuple[Monitor, Variant]:
    """Find a monitor and its variant by name; objects are checked and passed through.

    Args:
        monitor: name, a monitor, or a variant of a registered monitor
        variant: name, or a variant, which need not be one of those that the monitor lists; None takes the default of
            the monitor

    Returns:
        the monitor with the required signals of the variant, and the variant

    Raises:
        ParameterError: no such name, and the message gives the nearest; no variant given where there is no default; or
            an object lacks an attribute
    """
    if isinstance(monitor, Variant):
        variant = variant or monitor
        monitor = _monitor_of(monitor)
    definition = MONITORS.required(monitor) if isinstance(monitor, str) else monitor
    if why := obstacle(definition):
        raise ParameterError(f"the monitor '{getattr(definition, 'name', definition)}' {why}")
    chosen = variant if isinstance(variant, Variant) else _variant_of(definition, variant)
    return definition.needing(chosen), chosen


def _variant_of(monitor: Monitor, name: str | None) -> Variant:
    name = monitor.default if name is None else name
    if name is None:
        choices = " or ".join(f"'{each.name}' ({each.summary.rstrip('.')})" for each in monitor.variants.values())
        raise ParameterError(
            f"the monitor '{monitor.name}' has no default variant, since the wrong one gives a wrong verdict; "
            f"choose with --variant (in Python: variant=...) {choices}"
        )
    if name not in monitor.variants:
        more = "" if lab.installed() else f" Those of the papers are in the package {lab.PACKAGE}"
        raise ParameterError(f"'{monitor.name}' has no variant '{name}'{nearest(name, monitor.variants)}{more}")
    return monitor.variants[name]


def _monitor_of(variant: Variant) -> Monitor:
    """Registered monitor that lists this variant."""
    for monitor in MONITORS.values():
        if monitor.variants.get(variant.name) is variant:
            return monitor
    raise ParameterError(
        f"the variant '{variant.name}' belongs to no registered monitor, so its sampling rate is unknown; give "
        "monitor=tierod.Monitor(...) with it in its variants, or the name of a monitor and variant=..."
    )
