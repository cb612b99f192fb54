"""What is stuck is found, and what rests by itself is left alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from driven import drive
from shared_data import shared_data
from tierod.core.graph import scan
from tierod.core.recording import Aligned, Recording
from tierod.io.derive import complete
from tierod.io.readers import read
from tierod.monitors.inputs import StuckOverDrive
from tierod.monitors.registry import MONITORS
from tierod.monitors.stuck import StuckSignals
from tierod.vehicles import load

SIGNALS = MONITORS["friction"].required


@pytest.fixture(scope="module")
def driven() -> Aligned:
    return drive(minutes=8.0, seed=3).align(SIGNALS, 100.0)


def watched(aligned: Aligned) -> dict[str, float]:
    """Since when [s] each signal is stuck at the end."""
    block = StuckSignals(aligned.names, (), 0.05)
    seconds = scan(block, aligned.values[::5]).values
    since = aligned.time[::5][:, None] - seconds
    return {name: since[-1, at] for at, name in enumerate(aligned.names) if seconds[-1, at] > 0.0}


def ever_stuck(recording: Recording, names: tuple[str, ...], rate: float = 100.0) -> tuple:
    over = StuckOverDrive(names, rate)
    over.without(recording.align(names, rate), recording)
    return over.spans()


@pytest.mark.parametrize("name", SIGNALS)
@pytest.mark.parametrize("value", [None, 0.0])
def test_a_signal_that_freezes_is_stuck_from_then_on_and_no_other(driven, name, value):
    values, at = driven.values.copy(), driven.names.index(name)
    values[26000:, at] = values[26000, at] if value is None else value
    found = watched(Aligned(driven.time, values, driven.names))
    assert found == {name: pytest.approx(260.0, abs=0.06)}


@pytest.mark.parametrize(("name", "step"), [("driver_torque", 0.5), ("yaw_rate", 0.004), ("vehicle_speed", 0.3)])
def test_a_coarse_signal_rests_by_itself(driven, name, step):
    values, at = driven.values.copy(), driven.names.index(name)
    values[:, at] = step * np.round(values[:, at] / step)
    assert watched(Aligned(driven.time, values, driven.names)) == {}
    assert not scan(StuckSignals(driven.names, (), 0.05), values[::5]).values.any()


BENDS = ("steering_wheel_angle", "lateral_acceleration", "yaw_rate", "vehicle_speed")


def test_a_coarse_steering_angle_that_freezes_is_contradicted_by_bends_to_both_sides(driven):
    values = driven.values[:, [driven.names.index(name) for name in BENDS]].copy()
    values[:, 0] = math.radians(1.5) * np.round(values[:, 0] / math.radians(1.5))
    assert watched(Aligned(driven.time, values, BENDS)) == {}
    values[26000:, 0] = values[26000, 0]
    assert watched(Aligned(driven.time, values, BENDS)) == {"steering_wheel_angle": pytest.approx(260.0, abs=1.0)}
    backwards = values.copy()
    backwards[:, 1] = np.abs(backwards[:, 1])
    assert watched(Aligned(driven.time, backwards, BENDS)) == {}
    one_spikes = values.copy()
    one_spikes[:, 2] = 0.0
    assert "steering_wheel_angle" not in watched(Aligned(driven.time, one_spikes, BENDS))


REAL = {
    ("rav4_highway_minute", "can.log"): ("friction", "condition"),
    ("revsted_slip_angle", "obd.csv"): ("sideslip",),
    ("ferrari_250lm_race", "laps.parquet"): ("sideslip",),
    ("pmsm_drive", "SigRecSaveE.mat"): ("motor-angle",),
}
"""Recordings of real cars, and the monitors that judge them; the others share signals with these."""


@pytest.mark.parametrize(
    ("parts", "name"),
    [
        pytest.param(parts, name, marks=() if name in judged else pytest.mark.slow, id=f"{parts[0]}-{name}")
        for parts, judged in REAL.items()
        for name in MONITORS
    ],
)
def test_no_signal_of_a_real_recording_is_stuck(parts, name):
    path, rav4, monitor = shared_data(*parts), load("rav4"), MONITORS[name]
    given = {"dbc": rav4.database, "channel_map": rav4.channel_map} if parts[0].startswith("rav4") else {}
    names = (*monitor.required, *monitor.optional)
    assert ever_stuck(complete(read(path, **given), names), names) == ()
