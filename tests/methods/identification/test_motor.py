from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.methods.identification.inverter import identified_inverter
from tierod.methods.identification.motor import identify_motor
from tierod.models.stator_frame_motor import MotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleSample
from tierod_lab.ground.motor import Inverter
from tierod_lab.papers.motor_angle import observer_datasets as study
from tierod_lab.papers.motor_angle.bench import bench, observed_drive, to_and_fro
from tierod_lab.papers.motor_angle.fault_trials import salient_bench, salient_drive

FILE = MotorParameters(0.05, 1e-4, 0.0085, 4.0, 1.2e-4, 4e-4)  # what a vehicle file would say


@pytest.fixture(scope="module")
def driven():
    motor = study.drawn(7)
    return motor, study.recording(motor.driven(7), motor.temperature)


@pytest.fixture(scope="module")
def short(driven):
    begin = driven[1].span[0]
    return driven[1].slice(begin, begin + 1.5)


@pytest.fixture(scope="module")
def known(driven):
    return identify_motor(FILE, {"drive": driven[1]})


def test_a_drawn_motor_of_the_bench_is_found(driven, known):
    motor, result = driven[0], known
    assert not result.unidentified
    assert not result.doubt
    for each in study.parameter_errors(motor, result):
        assert abs(each["error"]) < 4.0 * each["deviation"] < 0.2, each["parameter"]
    assert any("no load_torque was recorded" in remark for remark in result.remarks)
    assert not any("samples" in remark for remark in result.remarks)


def test_the_sensor_s_zero_is_found_and_reported(short):
    angle = short["motor_angle_mechanical"]
    turned = short.with_channels([replace(angle, values=angle.values - 0.05)])
    zeros = [identify_motor(FILE, {"drive": each}) for each in (turned, short)]
    apart = zeros[0].electrical.zero.value - zeros[1].electrical.zero.value
    assert apart == pytest.approx(0.2, abs=4.0 * zeros[0].electrical.zero.deviation)
    assert any("away from the flux" in remark for remark in zeros[0].remarks)


def test_phases_and_an_electrical_angle_say_the_same(short):
    names = ("motor_current", "motor_voltage", "motor_angle")
    channels = {name: each for name, each in short.channels.items() if not name.startswith(names)}
    for kind, unit in (("current", "A"), ("voltage", "V")):
        alpha, beta = (short[f"motor_{kind}_{axis}"].values for axis in ("alpha", "beta"))
        parts = (alpha, -0.5 * alpha + 0.75**0.5 * beta, -0.5 * alpha - 0.75**0.5 * beta)
        for phase, values in zip("abc", parts, strict=True):
            name = f"motor_{kind}_{phase}"
            channels[name] = Channel(name, short["motor_current_alpha"].time, values, unit)
    angle = short["motor_angle_mechanical"]
    wrapped = np.mod(4.0 * angle.values, 2.0 * np.pi)
    channels["motor_angle_electrical"] = Channel("motor_angle_electrical", angle.time, wrapped, "rad")
    found, other = (identify_motor(FILE, {"a": each}).electrical for each in (replace(short, channels=channels), short))
    for name in ("resistance", "inductance", "flux"):
        assert getattr(found, name).value == pytest.approx(getattr(other, name).value, rel=1e-6)


def test_at_one_speed_and_current_resistance_and_flux_do_not_separate():
    time = np.arange(4000) * 1e-3
    seen = observed_drive(bench(stiffness=0.0), 30.0 * time, np.full(4000, 0.2), 3)
    result = identify_motor(FILE, {"drive": study.recording(seen)})
    assert {"motor_resistance", "motor_flux"} <= {each.name for each in result.unidentified}
    with pytest.raises(InputError, match="not identifiable here: motor_flux"):
        identify_motor(FILE, {"drive": study.recording(seen)}, ("motor_flux",))


def changed(recording, **factors):
    return recording.with_channels(
        [replace(recording[name], values=factor * recording[name].values) for name, factor in factors.items()]
    )


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ({"motor_current_alpha": -1.0, "motor_current_beta": -1.0}, "'sign = -1' in a channel map"),
        ({"motor_current_beta": -1.0}, "two phases of the currents swapped"),
        ({"motor_voltage_beta": -1.0}, "two phases of the voltages swapped"),
        ({"motor_angle_mechanical": -1.0}, "the angle turns opposite to currents and voltages"),
        ({"motor_angle_mechanical": 4.0}, "the angle is the electrical one"),
        ({"motor_angle_mechanical": 4.0 / 3.0}, "motor_pole_pairs = 3 instead of 4"),
    ],
)
def test_slips_of_a_recording_are_named(short, factors, words):
    with pytest.raises(InputError, match=words):
        identify_motor(FILE, {"drive": changed(short, **factors)})


@pytest.mark.parametrize(("late", "words"), [(-1, "1 samples early"), (0.5, "0.5 samples late")])
def test_voltages_of_another_step_are_moved(driven, late, words):
    motor, recording = driven
    moved = []
    for name in ("motor_voltage_alpha", "motor_voltage_beta"):
        values = recording[name].values
        before = np.roll(values, 1) if late > 0 else np.roll(values, -1)
        moved.append(replace(recording[name], values=before if abs(late) == 1 else 0.5 * (values + before)))
    result = identify_motor(FILE, {"drive": recording.with_channels(moved)})
    assert any(words in remark for remark in result.remarks)
    assert result.electrical.inductance.value == pytest.approx(motor.machine.inductance_q, rel=0.005)
    assert result.electrical.resistance.value == pytest.approx(motor.machine.resistance, rel=0.002)


def test_recordings_that_cannot_be_used(driven):
    _, recording = driven
    with pytest.raises(ParameterError, match="motor_inertia"):
        identify_motor(FILE, {"drive": recording}, ("motor_intertia",))
    with pytest.raises(InputError, match="at least 0.2 s"):
        identify_motor(FILE, {"drive": recording.slice(1.0, 1.1)})
    without = replace(recording, channels={n: c for n, c in recording.channels.items() if "voltage" not in n})
    with pytest.raises(InputError, match="lacks motor_voltage_alpha and motor_voltage_beta"):
        identify_motor(FILE, {"drive": without})
    names = ("motor_current_alpha", "motor_current_beta", "motor_voltage_alpha", "motor_voltage_beta")
    thin = [replace(recording[n], time=recording[n].time[::20], values=recording[n].values[::20]) for n in names]
    with pytest.raises(InputError, match="from sample to sample; record faster"):
        identify_motor(FILE, {"drive": recording.with_channels(thin)})


@pytest.mark.parametrize("ratio", [3.0])
def test_an_ordinary_drive_of_a_salient_motor_gives_both_inductances(ratio):
    seen = salient_drive(ratio, 3, 15.0)
    names = MotorAngleSample._fields[:5]
    channels = {name: Channel(name, seen.time, seen.samples[:, k], SIGNALS[name].unit) for k, name in enumerate(names)}
    result = identify_motor(FILE, {"drive": Recording(channels, {})})
    found = {each.name: each for each in result.found}
    machine = salient_bench(ratio).motor.machine
    assert found["motor_inductance"].value == pytest.approx(machine.inductance_d, rel=0.02)
    assert found["motor_saliency"].value == pytest.approx(ratio, rel=0.02)
    assert abs(found["motor_saliency"].value - ratio) < 3.0 * found["motor_saliency"].deviation


INVERTER_MOTOR = (0.05, 1e-4, 0.0085)
NAMES = ("motor_current_alpha", "motor_current_beta", "motor_target_voltage_alpha", "motor_target_voltage_beta")


@cache
def recorded(seed, knee=1.0, drop=0.7, dead_time=1e-6, seconds=6.0):
    drive = to_and_fro(seed, seconds, inverter=Inverter(dead_time=dead_time, forward_drop=drop, knee_current=knee))
    columns = dict(zip((*NAMES, "motor_angle_mechanical"), drive.commanded.T, strict=True))
    units = ("A", "A", "V", "V", "rad")
    return Recording(
        {
            name: Channel(name, drive.time, values, unit)
            for (name, values), unit in zip(columns.items(), units, strict=True)
        }
    )


@pytest.mark.parametrize(("knee", "drop"), [(2.5, 0.7), (1.0, 0.1)])
def test_it_finds_loss_and_knee_within_their_deviations(knee, drop):
    found = identified_inverter({"drive": recorded(90, knee, drop)}, 4.0, expected=INVERTER_MOTOR)
    loss, at = found.found
    assert (loss.name, at.name) == ("inverter_voltage_loss", "inverter_knee_current")
    assert loss.value == pytest.approx(0.13 + drop, abs=4.0 * loss.deviation + 0.002)
    assert at.value == pytest.approx(knee, abs=4.0 * at.deviation + 0.005)
    assert at.deviation < 0.03 * knee
    assert at.low < at.value < at.high
    assert found.doubt == ""
    assert found.fit.unexplained < 0.02
    assert found.fit.resistance == pytest.approx(0.05, rel=0.02)


def test_an_inverter_that_takes_nothing_is_doubted():
    assert identified_inverter({"drive": recorded(90, drop=0.0, dead_time=0.0)}, 4.0).doubt


@pytest.mark.parametrize(
    ("signals", "factor", "words"),
    [
        (NAMES[:2], -1.0, "the currents are counted positive out of the motor"),
        (NAMES[1:2], -1.0, "two phases of the currents swapped"),
        (("motor_angle_mechanical",), 4.0, "the angle is the electrical one"),
    ],
)
def test_signals_that_do_not_belong_together_are_named(signals, factor, words):
    drive = recorded(90, drop=0.1)
    wrong = [replace(drive[name], values=factor * drive[name].values) for name in signals]
    with pytest.raises(InputError, match=words):
        identified_inverter({"drive": drive.with_channels(wrong)}, 4.0, expected=INVERTER_MOTOR)
