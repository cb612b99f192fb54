"""What a recording must have before a monitor may judge it."""

from __future__ import annotations

from tierod.core.errors import InputError, nearest
from tierod.core.recording import Recording
from tierod.core.shown import written
from tierod.core.signals import SIGNALS
from tierod.core.units import COUNT
from tierod.io.derive import RECIPES
from tierod.monitors.harness.named_vehicle import made_with
from tierod.monitors.harness.session import Monitor
from tierod.vehicles import Vehicle


def refuse_unsuitable(monitor: Monitor, vehicle: Vehicle | None, piece: Recording) -> None:
    """Refuse a recording without a signal that the monitor needs, or with one in counts where a torque is needed.

    Args:
        monitor: what judges
        vehicle: whose torques may be counts; None where none is given
        piece: the first one of the recording, with all derived signals

    Raises:
        InputError: the signal is named, and what to do
    """
    missing = [name for name in monitor.required if name not in piece]
    if missing:
        strangers = [name for name in piece.names if name not in SIGNALS]
        near = nearest(missing[0], strangers) if strangers else "."
        other = None if vehicle is None else made_with(piece.metadata, vehicle.name)
        if vehicle is not None and other is not None:
            raise InputError(
                f"the monitor '{monitor.name}' needs {', '.join(missing)}, which the recording does not have; it was "
                f"made with the vehicle '{other}', not with '{vehicle.name}': judge it with --vehicle {other}"
            )
        raise InputError(
            f"the monitor '{monitor.name}' needs {', '.join(map(_with_ingredients, missing))}, which the "
            f"recording does not have{near} {_in_their_place(monitor, missing)}Give a channel map that names it; "
            "'tierod inspect' shows what the recording has"
        )
    if vehicle is not None:
        _refuse_counts(monitor, vehicle, piece)


def _refuse_counts(monitor: Monitor, vehicle: Vehicle, piece: Recording) -> None:
    """Raw counts are judged only as torques of a vehicle whose file says so: taken as N*m, any verdict is wrong."""
    for name in monitor.required:
        torque = SIGNALS[name].unit == "N*m"
        if piece[name].unit == COUNT and (vehicle.calibrated or not torque):
            other = ', or torque_unit = "count" in the vehicle file' if torque else ""
            raise InputError(
                f"{name} is in raw counts, but the vehicle '{vehicle.name}' needs {written(SIGNALS[name].unit)}; "
                f"give unit and factor (the {written(SIGNALS[name].unit)} of one count) in the channel map{other}"
            )


def _in_their_place(monitor: Monitor, missing: list[str]) -> str:
    """What other variants take in place of the missing signals, as sentences."""
    told = ""
    for variant in monitor.variants.values():
        needed = monitor.needing(variant).required
        others = [name for name in needed if name not in monitor.required]
        if others and not any(name in needed for name in missing):
            told += f"The variant '{variant.name}' takes {', '.join(others)} in its place. "
    return told


def _with_ingredients(name: str) -> str:
    """The signal, and what it could be made from."""
    made_from = RECIPES[name].needs if name in RECIPES else ()
    return f"{name} (or {' and '.join(made_from)})" if made_from else name
