"""Identification of a motor: against closed forms, against the bench, and where a recording does not identify."""

from dataclasses import replace

import numpy as np
import pytest

from methods.identification.made_motor import FILE, MadeMotor, none, to_and_fro, waving
from tierod.core.errors import InputError, ParameterError
from tierod.core.graph import scan
from tierod.core.graph.trace import trace
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.methods.identification.motor import identify_motor
from tierod.monitors.motor_angle.observer import MotorAngleObserver, MotorAngleSample
from tierod.physics.clarke_park import StatorVector, inverse_clarke
from tierod_lab.papers.motor_angle import drawn_motors as study
from tierod_lab.papers.motor_angle.bench import bench, course, locked, observed_drive
from tierod_lab.papers.motor_angle.salient_bench import salient_bench, salient_drive


def electrical(recording):
    return identify_motor(FILE, {"drive": recording}).electrical


def near(found, true, times=4.0):
    return abs(found.value - true) < times * found.deviation


def test_resistance_inductance_and_flux_of_a_made_motor():
    motor = MadeMotor()
    found = electrical(motor.recording(none, waving(12.0, 1.3), to_and_fro))
    assert near(found.resistance, motor.resistance)
    assert near(found.inductance, motor.inductance_q)
    assert near(found.flux, motor.flux)
    assert found.resistance.deviation < 0.002 * motor.resistance
    assert found.inductance.deviation < 0.005 * motor.inductance_q
    assert found.flux.deviation < 0.001 * motor.flux
    assert found.inductance_q is None
    assert not found.along
    assert found.blind == ()


def test_inductances_are_distinguished_where_current_along_the_flux_is_driven():
    motor = MadeMotor(inductance_d=0.9e-4, inductance_q=1.3e-4)
    recording = motor.recording(waving(8.0, 11.0), waving(12.0, 1.3), to_and_fro)
    result = identify_motor(FILE, {"drive": recording})
    found = {each.name: each for each in result.found}
    assert near(result.electrical.inductance, 0.9e-4)
    assert near(result.electrical.inductance_q, 1.3e-4)
    assert found["motor_saliency"].value == pytest.approx(1.3 / 0.9, rel=0.01)


def test_the_sensor_s_zero_is_found_and_reported():
    motor = MadeMotor(zero=0.2)
    result = identify_motor(FILE, {"drive": motor.recording(none, waving(12.0, 1.3), to_and_fro)})
    assert near(result.electrical.zero, 0.2)
    assert near(result.electrical.flux, motor.flux)
    assert any("+11.5" in remark and "away from the flux" in remark for remark in result.remarks)


def test_the_temperature_takes_resistance_and_flux_to_20_degrees():
    hot = 293.15 + 80.0
    motor = MadeMotor(resistance=0.055 * (1.0 + 80.0 / 255.0), flux=0.009 * (1.0 - 1.1e-3 * 80.0))
    courses = (none, waving(12.0, 1.3), to_and_fro)
    warm = {
        each.name: each for each in identify_motor(FILE, {"a": motor.recording(*courses, motor_temperature=hot)}).found
    }
    blind = identify_motor(FILE, {"a": motor.recording(*courses)})
    assert warm["motor_resistance"].value == pytest.approx(0.055, rel=0.002)
    assert warm["motor_flux"].value == pytest.approx(0.009, rel=0.002)
    found = {each.name: each for each in blind.found}
    assert found["motor_resistance"].value == pytest.approx(motor.resistance, rel=0.002)
    assert found["motor_resistance"].deviation > 0.05 * motor.resistance
    assert any("no motor_temperature was recorded" in remark for remark in blind.remarks)


def test_phases_and_an_electrical_angle_say_the_same():
    motor = MadeMotor()
    plain = motor.recording(none, waving(12.0, 1.3), to_and_fro)
    channels = {}
    for kind, unit in (("current", "A"), ("voltage", "V")):
        alpha, beta = (plain[f"motor_{kind}_{axis}"].values for axis in ("alpha", "beta"))
        parts = (alpha, -0.5 * alpha + 0.75**0.5 * beta, -0.5 * alpha - 0.75**0.5 * beta)
        for phase, values in zip("abc", parts, strict=True):
            name = f"motor_{kind}_{phase}"
            channels[name] = Channel(name, plain["motor_current_alpha"].time, values, unit)
    angle = plain["motor_angle_mechanical"]
    wrapped = np.mod(4.0 * angle.values, 2.0 * np.pi)
    channels["motor_angle_electrical"] = Channel("motor_angle_electrical", angle.time, wrapped, "rad")
    found, other = electrical(replace(plain, channels=channels)), electrical(plain)
    for name in ("resistance", "inductance", "flux"):
        assert getattr(found, name).value == pytest.approx(getattr(other, name).value, rel=1e-6)


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


def test_noise_in_the_loop_of_the_current_control_makes_no_bias():
    names = ("motor_current_alpha", "motor_current_beta")
    off = []
    for seed in range(3):
        motor = study.drawn(900 + seed)
        time = np.arange(10_000) * 1e-3
        noise = np.random.default_rng(seed).normal(size=(10_000, 2))
        inputs = {name: np.zeros(10_000) for name in trace(motor.plant).sample}
        inputs |= {name: np.ones(10_000) for name in inputs if name.endswith(".gain") or name == "control"}
        inputs |= {f"ports.{name}.offset": noise[:, k] for k, name in enumerate(names)}
        found = scan(motor.plant, np.column_stack(list((inputs | {"target_motor_angle": course(time, seed)}).values())))
        readings = {
            name: np.column_stack([found[f"motor.fine.{name}.{k}"] for k in range(10)]).ravel()
            for name in MotorAngleObserver.Sample._fields
        }
        readings |= {name: readings[name] + np.repeat(noise[:, k], 10) for k, name in enumerate(names)}
        fine = np.arange(100_000) * 1e-4
        channels = {name: Channel(name, fine, values, "") for name, values in readings.items()}
        channels["motor_temperature"] = Channel("motor_temperature", fine, np.full(100_000, motor.temperature), "K")
        result = identify_motor(FILE, {"drive": Recording(channels)})
        rows = study.parameter_errors(motor, result)
        errors = {each["parameter"]: each["error"] / each["deviation"] for each in rows}
        off.append([errors[name] for name in ("motor_resistance", "motor_flux")])
    assert np.all(np.abs(np.mean(off, axis=0)) < 2.0)


def test_two_recordings_show_more_than_one(driven, known):
    motor, recording = driven
    both = identify_motor(FILE, {"a": recording, "b": study.recording(motor.driven(8), motor.temperature)})
    assert both.mechanical.friction.deviation < known.mechanical.friction.deviation
    assert both.electrical.resistance.deviation < known.electrical.resistance.deviation
    assert len(both.mechanical.courses) == 2


def test_a_measured_torque_is_held_against_that_of_the_currents(driven, known):
    _, recording = driven
    course = known.mechanical.courses[0]
    assert known.torque_ratio is None
    torque = Channel("motor_torque", course.time, course.driving * 2.0 / 3.0, "N*m")
    scaled = identify_motor(FILE, {"a": recording.with_channels([torque])})
    assert scaled.torque_ratio.value == pytest.approx(2.0 / 3.0, rel=0.05)
    assert any("not amplitude-invariant" in remark for remark in scaled.remarks)


def test_at_one_speed_and_current_resistance_and_flux_do_not_separate():
    time = np.arange(4000) * 1e-3
    seen = observed_drive(bench(stiffness=0.0), 30.0 * time, np.full(4000, 0.2), 3)
    result = identify_motor(FILE, {"drive": study.recording(seen)})
    assert {"motor_resistance", "motor_flux"} <= {each.name for each in result.unidentified}
    with pytest.raises(InputError, match="not identifiable here: motor_flux"):
        identify_motor(FILE, {"drive": study.recording(seen)}, ("motor_flux",))


def test_a_locked_shaft_shows_the_resistance_alone_or_with_the_inductance():
    time = np.arange(4000) * 1e-3
    waves = locked(bench(), 0.5 * np.sin(2.0 * np.pi * 3.0 * time), 4)
    result = identify_motor(FILE, {"drive": study.recording(waves)})
    assert [each.name for each in result.found] == ["motor_resistance", "motor_inductance"]
    assert near(result.electrical.resistance, 0.05)
    assert near(result.electrical.inductance, 1e-4)
    assert result.mechanical is None
    still = identify_motor(FILE, {"drive": study.recording(locked(bench(), np.full(4000, 0.5), 4))})
    assert "no parameter" in still.doubt


def test_a_slow_and_noisy_angle_makes_no_bias():
    motor = MadeMotor()
    recording = motor.recording(none, waving(12.0, 1.3), lambda time: 0.15 * to_and_fro(time))
    angle = recording["motor_angle_mechanical"]
    rough = angle.values + 3e-3 * np.random.default_rng(5).normal(size=len(angle.values))
    slow = replace(angle, time=angle.time[::10], values=rough[::10])
    found = electrical(recording.with_channels([slow]))
    assert near(found.flux, motor.flux)
    assert near(found.resistance, motor.resistance)
    assert found.flux.deviation < 0.1 * motor.flux


def changed(recording, **factors):
    return recording.with_channels(
        [replace(recording[name], values=factor * recording[name].values) for name, factor in factors.items()]
    )


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ({"motor_current_alpha": -1.0, "motor_current_beta": -1.0}, "'sign = -1' in a channel map"),
        ({"motor_current_beta": -1.0}, "two phases of the currents swapped"),
        pytest.param({"motor_voltage_beta": -1.0}, "two phases of the voltages swapped", marks=pytest.mark.slow),
        ({"motor_angle_mechanical": -1.0}, "the angle turns opposite to currents and voltages"),
        ({"motor_angle_mechanical": 4.0}, "the angle is the electrical one"),
        ({"motor_angle_mechanical": 4.0 / 3.0}, "motor_pole_pairs = 3 instead of 4"),
    ],
)
def test_slips_of_a_recording_are_named(short, factors, words):
    with pytest.raises(InputError, match=words):
        identify_motor(FILE, {"drive": changed(short, **factors)})


def test_swapped_phases_of_a_fast_motor_are_named():
    recording = MadeMotor().recording(none, waving(6.0, 5.3), lambda time: 60.0 * time + 2.0 * to_and_fro(time))
    with pytest.raises(InputError, match=r"\(([6-9]|1\d|2[0-4]) % of the voltage.*phases of the currents swapped"):
        identify_motor(FILE, {"drive": changed(recording, motor_current_beta=-1.0)})


def test_a_wrong_sampling_time_is_reported():
    motor = MadeMotor(0.05, 1.02e-4, 1.02e-4, 0.0084)
    recording = motor.recording(none, waving(12.0, 1.3), to_and_fro)
    channels = {name: replace(each, time=2.0 * each.time) for name, each in recording.channels.items()}
    remarks = identify_motor(FILE, {"drive": replace(recording, channels=channels)}).remarks
    assert any("come every 0.1 ms, but by their time stamps every 0.2 ms" in each for each in remarks)
    assert not any("come every" in each for each in identify_motor(FILE, {"drive": recording}).remarks)


@pytest.mark.parametrize(("offset", "reported"), [(0.0, False), (5.0, True)])
def test_phase_currents_that_do_not_add_up_are_reported(short, offset, reported):
    a, b, c = inverse_clarke(StatorVector(*(short[f"motor_current_{axis}"].values for axis in ("alpha", "beta"))))
    time = short["motor_current_alpha"].time
    phases = {"motor_current_a": a, "motor_current_b": b + offset, "motor_current_c": c}
    channels = {n: each for n, each in short.channels.items() if "motor_current" not in n}
    channels |= {name: Channel(name, time, values, "A") for name, values in phases.items()}
    remarks = identify_motor(FILE, {"drive": replace(short, channels=channels)}).remarks
    assert any("do not add up to zero" in each for each in remarks) == reported


@pytest.mark.parametrize("whose", ["current", pytest.param("voltage", marks=pytest.mark.slow)])
def test_exchanged_axes_are_named(short, whose):
    alpha, beta = short[f"motor_{whose}_alpha"], short[f"motor_{whose}_beta"]
    channels = [replace(alpha, values=beta.values), replace(beta, values=alpha.values)]
    with pytest.raises(InputError, match=f"alpha and beta of the {whose}s exchanged"):
        identify_motor(FILE, {"drive": short.with_channels(channels)})


@pytest.mark.parametrize(("late", "words"), [(1, "1 samples late"), (-1, "1 samples early"), (0.5, "0.5 samples late")])
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


def test_a_gap_costs_only_its_own_samples(driven, known):
    _, recording = driven
    whole = known.electrical
    holed = recording["motor_voltage_alpha"].values.copy()
    holed[30_000:35_000] = np.nan
    found = electrical(recording.with_channels([replace(recording["motor_voltage_alpha"], values=holed)]))
    assert found.resistance.value == pytest.approx(whole.resistance.value, rel=0.002)
    assert found.blind == ()


@pytest.mark.parametrize("ratio", [1.5, 3.0])
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
