"""What inspection says of a recording is what a diagnosis then does."""

from dataclasses import replace

import numpy as np
import pytest

from exact_vehicle import diagnose
from tierod.cli import main
from tierod.core.errors import TierodError
from tierod.io.readers import LACKING, read
from tierod.monitors.acceptance import refusals
from tierod.monitors.registry import MONITORS
from tierod.vehicles import load

RECORDINGS = {
    "drive": ("step-steer", "8", "midsize-eps"),
    "column": ("column-bench-multisine", "4", "column-bench"),
    "motor": ("motor-bench-sweep", "2", "motor-bench"),
    "by wire": ("steer-by-wire-lane-change", "8", "steer-by-wire"),
}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder, driven = tmp_path_factory.mktemp("drives"), {}

    def of(name):
        if name not in driven:
            path = folder / f"{name}.parquet"
            scenario, seconds, _ = RECORDINGS[name]
            assert main(["simulate", scenario, "-o", str(path), "--seconds", seconds, "--json"]) == 0
            driven[name] = read(path)
        return driven[name]

    return of


def slower(recording, rate):
    """Every channel at a lower rate [Hz]."""
    return replace(
        recording,
        channels={
            name: replace(each, time=each.time[::step], values=each.values[::step])
            for name, each in recording.channels.items()
            if (step := max(round((len(each.time) - 1) / (each.time[-1] - each.time[0]) / rate), 1))
        },
    )


CHANGES = {
    "as it is": lambda whole: whole,
    "at 15 Hz": lambda whole: slower(whole, 15.0),
    "at 600 Hz": lambda whole: slower(whole, 600.0),
    "angle constant": lambda whole: changed(whole, "steering_wheel_angle", lambda x: 0.0 * x + 1.0),
    "angle missing": lambda whole: changed(whole, "motor_angle_mechanical", lambda x: np.nan * x),
    "raw counts": lambda whole: whole.with_channels(
        [replace(whole[name], unit="count") for name in ("driver_torque", "motor_torque") if name in whole]
    ),
}


def changed(whole, name, change):
    if name not in whole:
        return whole
    return whole.with_channels([replace(whole[name], values=change(whole[name].values))])


ALIKE = ("at 600 Hz", "angle missing")
"""Changes of the drive that the motor shows too."""
CASES = [
    *(("drive", change) for change in CHANGES if change not in ALIKE),
    *(pytest.param("drive", change, marks=pytest.mark.slow) for change in ALIKE),
    *(("motor", change) for change in CHANGES if change != "angle constant"),
    *(("column", change) for change in ("as it is", "raw counts")),
    *(pytest.param("by wire", change, marks=pytest.mark.slow) for change in ("as it is", "raw counts")),
]


@pytest.mark.parametrize(("name", "change"), CASES)
def test_inspection_refuses_what_a_diagnosis_refuses(recorded, name, change):
    whole, car = CHANGES[change](recorded(name)), load(RECORDINGS[name][2])
    for monitor in MONITORS.values():
        for variant, reason in refusals(monitor, car, whole).items():
            refused = refusal_of(whole, car, monitor.name, variant)
            known = reason if reason != "the recording has none of its signals" else refused
            assert bool(known) == bool(refused), f"{monitor.name}, {variant}: '{reason}' but '{refused}'"


def test_a_monitor_names_the_column_that_the_map_gives_for_its_signal_in_vain(recorded):
    whole = recorded("drive")
    rest = {name: each for name, each in whole.channels.items() if name != "motor_torque"}
    absent = {LACKING: {"motor_torque": "car.toml names 'Tm' for motor_torque, which is not a column of the file."}}
    part = replace(whole, channels=rest, metadata={**whole.metadata, **absent})
    reasons = refusals(MONITORS["friction"], load("midsize-eps"), part)
    assert "which the recording does not have: car.toml names 'Tm' for motor_torque" in reasons["pre-sliding"]
    assert not refusals(MONITORS["sideslip"], load("midsize-eps"), part)["combined"]


def refusal_of(*asked):
    """Why a diagnosis refuses; "" where it runs."""
    try:
        diagnose(*asked)
    except TierodError as error:
        return str(error)
    return ""
