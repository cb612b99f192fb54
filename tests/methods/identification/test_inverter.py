"""Loss and knee of the bench's inverter, 1 us of dead time and 0.7 V of drop, from its commands."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Channel, Recording
from tierod.methods.identification.inverter import identified_inverter
from tierod_lab.ground.motor import Inverter
from tierod_lab.papers.motor_angle.bench import to_and_fro

MOTOR = (0.05, 1e-4, 0.0085)
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


@pytest.mark.parametrize(("knee", "drop"), [(1.0, 0.7), pytest.param(2.5, 0.7, marks=pytest.mark.slow), (1.0, 0.1)])
def test_it_finds_loss_and_knee_within_their_deviations(knee, drop):
    found = identified_inverter({"drive": recorded(90, knee, drop)}, 4.0, expected=MOTOR)
    loss, at = found.found
    assert (loss.name, at.name) == ("inverter_voltage_loss", "inverter_knee_current")
    assert loss.value == pytest.approx(0.13 + drop, abs=4.0 * loss.deviation + 0.002)
    assert at.value == pytest.approx(knee, abs=4.0 * at.deviation + 0.005)
    assert at.deviation < 0.03 * knee
    assert at.low < at.value < at.high
    assert found.doubt == ""
    assert found.fit.unexplained < 0.02
    assert found.fit.resistance == pytest.approx(0.05, rel=0.02)


def test_deviations_are_those_of_repetition():
    fits = [identified_inverter({"drive": recorded(seed)}, 4.0).fit for seed in (90, 91, 92, 93)]
    errors = [(fit.loss - 0.83) / fit.loss_deviation for fit in fits]
    errors += [np.log(fit.knee) / fit.knee_deviation for fit in fits]
    assert np.sqrt(np.mean(np.square(errors))) < 3.0


@pytest.mark.parametrize("seed", [90, 91, 92])
def test_an_inverter_that_takes_nothing_is_doubted(seed):
    found = identified_inverter({"drive": recorded(seed, drop=0.0, dead_time=0.0)}, 4.0)
    assert found.doubt


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
        identified_inverter({"drive": drive.with_channels(wrong)}, 4.0, expected=MOTOR)


def test_measured_voltages_are_no_commands():
    channels = dict(recorded(90).channels)
    del channels["motor_target_voltage_beta"]
    with pytest.raises(InputError, match="motor_target_voltage_beta"):
        identified_inverter({"drive": Recording(channels)}, 4.0)


def test_only_what_is_wanted_and_no_other():
    found = identified_inverter({"drive": recorded(90)}, 4.0, ("inverter_knee_current",))
    assert [each.name for each in found.found] == ["inverter_knee_current"]
    with pytest.raises(ParameterError, match="did you mean 'inverter_knee_current'"):
        identified_inverter({"drive": recorded(90)}, 4.0, ("inverter_knee",))
