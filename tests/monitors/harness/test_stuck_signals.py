"""What is stuck is found, and what rests by itself is left alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from driven import drive
from shared_data import shared_data
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.core.recording import Aligned, Recording
from tierod.io.derive import complete
from tierod.io.readers import read
from tierod.monitors.harness.stuck import StuckOverDrive, StuckSignals
from tierod.monitors.registry import MONITORS
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


@pytest.mark.parametrize("name", SIGNALS)
def test_a_signal_that_freezes_but_for_rounding_residues_is_stuck(driven, name):
    values, at = driven.values.copy(), driven.names.index(name)
    values[26000:, at] = values[26000, at] + 1e-13 * np.random.default_rng(6).standard_normal(len(values) - 26000)
    assert watched(Aligned(driven.time, values, driven.names)) == {name: pytest.approx(260.0, abs=0.06)}


def test_nothing_is_stuck_while_all_is_well(driven):
    assert not scan(StuckSignals(driven.names, (), 0.05), driven.values[::5]).values.any()


@pytest.mark.parametrize(("name", "step"), [("driver_torque", 0.5), ("yaw_rate", 0.004), ("vehicle_speed", 0.3)])
def test_a_coarse_signal_rests_by_itself(driven, name, step):
    values, at = driven.values.copy(), driven.names.index(name)
    values[:, at] = step * np.round(values[:, at] / step)
    assert watched(Aligned(driven.time, values, driven.names)) == {}
    assert not scan(StuckSignals(driven.names, (), 0.05), values[::5]).values.any()


@pytest.mark.parametrize(("name", "step"), [("steering_wheel_rate", math.radians(1.0)), ("yaw_rate", 0.004)])
def test_a_coarse_signal_that_freezes_is_contradicted_by_another(driven, name, step):
    values, at = driven.values.copy(), driven.names.index(name)
    values[:, at] = step * np.round(values[:, at] / step)
    values[26000:, at] = values[26000, at]
    assert list(watched(Aligned(driven.time, values, driven.names))) == [name]


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


def test_missing_samples_are_no_equal_ones(driven):
    values = driven.values.copy()
    values[26000:] = np.nan
    assert watched(Aligned(driven.time, values, driven.names)) == {}


def test_a_signal_that_moves_again_is_used_again(driven):
    values, at = driven.values.copy(), driven.names.index("yaw_rate")
    values[26000:30000, at] = values[26000, at]
    over, whole = StuckOverDrive(SIGNALS, 100.0), drive(minutes=8.0, seed=3)
    again = whole.with_channels([type(whole["yaw_rate"])("yaw_rate", driven.time, values[:, at], "rad/s")])
    usable = over.without(Aligned(driven.time, values, driven.names), again)
    (span,) = over.spans()
    assert (span.start, span.end) == (pytest.approx(260.0, abs=0.06), pytest.approx(300.0, abs=0.06))
    missing = np.isnan(usable.values[:, at])
    assert not missing[:26000].any()
    assert missing[26110:30000].all()
    assert not missing[30010:].any()
    (fact,) = over.facts({"yaw_rate": "rad/s"})
    assert fact.cause.startswith("yaw_rate is stuck at ")
    assert "from 260.0 s to 300.0 s" in fact.cause


def test_names_are_checked():
    with pytest.raises(ParameterError, match="each once"):
        StuckSignals(("yaw_rate",), ("yaw_rate",), 0.05)
    with pytest.raises(ParameterError, match="sample_time"):
        StuckSignals(("yaw_rate",), (), 0.0)


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


def test_a_coarse_rate_that_reads_zero_while_the_wheel_turns_slowly_is_not_stuck(driven):
    angle, rate = (driven.names.index(name) for name in ("steering_wheel_angle", "steering_wheel_rate"))
    values, step, begin = driven.values.copy(), math.radians(8.0), 26000
    values[begin:, rate] = math.radians(3.5)
    turned = math.radians(3.5) * (driven.time[begin:] - driven.time[begin])
    values[begin:, angle] = values[begin, angle] + turned
    values[:, rate] = step * np.round(values[:, rate] / step)
    end = begin + 1500
    assert "steering_wheel_rate" not in watched(Aligned(driven.time[:end], values[:end], driven.names))
