"""What inspection says of a recording is what a diagnosis then does."""

from dataclasses import replace

import numpy as np
import pytest

from exact_vehicle import diagnose
from tierod.cli import main
from tierod.core.errors import TierodError
from tierod.core.findings import Finding, Status
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.io.readers import LACKING, read
from tierod.monitors.harness.acceptance import refusals, taken, unable
from tierod.monitors.registry import MONITORS
from tierod.vehicles import load
from tierod.vehicles.classes import typical

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


@pytest.mark.parametrize(
    ("unit", "advice"), [(None, "record it"), ("degC", "record it"), ("N*m", "channel map"), ("", "channel map")]
)
def test_a_channel_map_is_advised_only_where_a_channel_could_be_the_signal(recorded, unit, advice):
    whole = recorded("drive")
    rest = {name: each for name, each in whole.channels.items() if name in SIGNALS and name != "motor_torque"}
    if unit is not None:
        rest["M_17"] = replace(whole["motor_torque"], name="M_17", unit=unit)
    reason = refusals(MONITORS["friction"], load("midsize-eps"), replace(whole, channels=rest))["pre-sliding"]
    assert [each for each in ("record it", "channel map") if each in reason] == [advice]


def test_signals_that_begin_late_are_waited_for():
    time = np.arange(12_000) / 100.0
    names = ("yaw_rate", "steering_wheel_angle", "wheel_speed_rear_left", "wheel_speed_rear_right")
    values = (0.1 * np.sin(time), np.sin(time), 10.0 + np.cos(time), 10.0 - np.cos(time))
    late = {name: slice(6_000 if name.startswith("wheel") else 0, None) for name in names}
    channels = {
        name: Channel(name, time[late[name]], each[late[name]], SIGNALS[name].unit)
        for name, each in zip(names, values, strict=True)
    }
    car = load("midsize-eps")
    car = replace(car, parameters={**typical("midsize"), **car.parameters})
    assert not refusals(MONITORS["condition"], car, Recording(channels))["bank"]
    few = Recording({name: channels[name] for name in names[:2]})
    assert refusals(MONITORS["condition"], car, few)["bank"].startswith("fewer than 4 sensors")


def test_what_shows_only_over_the_whole_is_not_asked_of_a_beginning(recorded):
    beginning = changed(recorded("drive"), "steering_wheel_angle", lambda x: 0.0 * x + 1.0)
    friction, car = MONITORS["friction"], load("midsize-eps")
    assert "constant" in refusals(friction, car, beginning)["pre-sliding"]
    assert not refusals(friction, car, beginning, whole=False)["pre-sliding"]


def test_a_signal_that_was_lost_on_the_way_is_a_verdict_and_no_refusal(recorded):
    lost = Finding("sideslip", Status.NOT_AVAILABLE, "lost", since=3.0, cause="the angle was lost")
    motion = Recording({name: recorded("drive")[name] for name in ("vehicle_speed", "yaw_rate")})
    sideslip = MONITORS["sideslip"]
    assert unable(sideslip, lost, motion) == ""
    assert unable(sideslip, replace(lost, since=None), motion) == "the angle was lost"
    assert unable(sideslip, replace(lost, since=None), recorded("drive")) == "", "a stuck sensor is to be named"


def refusal_of(*asked):
    """Why a diagnosis refuses; "" where it runs."""
    try:
        diagnose(*asked)
    except TierodError as error:
        return str(error)
    return ""


def test_without_a_vehicle_signals_alone_are_looked_at(recorded):
    reasons = refusals(MONITORS["driver-torque"], None, recorded("column"))
    assert set(reasons.values()) == {""}
    assert taken(MONITORS["driver-torque"], reasons)[0] == "interacting"
    assert all(refusals(MONITORS["motor-angle"], None, recorded("column")).values())
