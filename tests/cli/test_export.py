from importlib.util import find_spec

import pytest

from tierod.cli import main

needs_fmpy = pytest.mark.skipif(find_spec("fmpy") is None, reason="fmpy is not installed")


def validate_fmu(path):
    """Remarks of fmpy on a unit."""
    from fmpy.validation import validate_fmu as validate

    return validate(path)


def test_a_monitor_is_exported_with_the_drive_it_is_compared_by(tmp_path, capsys):
    words = ["export", "c", "sideslip", "--vehicle", "midsize-eps", "-o", str(tmp_path / "ecu")]
    assert main(words) == 0
    assert "make -C" in capsys.readouterr().out
    assert "slalom-winter-tyres" in (tmp_path / "ecu/README.md").read_text()
    assert (tmp_path / "ecu/test/expected.csv").read_text().startswith("step,")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["cc", "friction"], "there is no export 'cc'"),
        (["c", "fricton"], "did you mean 'friction'"),
        (["c", "hysteresis", "--variant", "hoist"], "judges a recording as a whole"),
        (["c", "hysteresis"], "judges a recording as a whole"),
        (["fmu", "hysteresis"], "ecu does not end in .fmu"),
        (["c", "motor-angle"], "lacks motor_resistance"),
        (["c", "friction", "--precision", "half"], "--precision is 'half'"),
        (["c", "friction", "--drive", "nowhere.mf4"], "nowhere.mf4"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_a_sentence(tmp_path, capsys, words, sentence):
    assert main(["export", *words, "--vehicle", "midsize-eps", "-o", str(tmp_path / "ecu")]) == 3
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1
    assert not (tmp_path / "ecu").exists()


@needs_fmpy
@pytest.mark.parametrize("what", ["plant", "driver", "assist"])
def test_what_a_scenario_drives_with_becomes_a_unit(tmp_path, capsys, what):
    words = ["export", "fmu", what, "--scenario", "weave-small-car", "-o", str(tmp_path / "a.fmu")]
    assert main(words) == 0
    assert "FMI 2.0 co-simulation" in capsys.readouterr().out
    assert validate_fmu(str(tmp_path / "a.fmu")) == []


@needs_fmpy
@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["friction"], "name it with --vehicle"),
        (["plant"], "name it with --scenario"),
        (["assist", "--scenario", "steer-by-wire-lane-change"], "has no assist unit"),
        (["condition", "--vehicle", "smartload"], "is a bank of 53 filters, which cannot be exported as a unit"),
        (["hysteresis", "--vehicle", "midsize-eps"], "judges a recording as a whole"),
    ],
)
def test_a_unit_that_cannot_be_made_is_refused_in_a_sentence(tmp_path, capsys, words, sentence):
    assert main(["export", "fmu", *words, "-o", str(tmp_path / "a.fmu")]) == 3
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_c_needs_a_vehicle(tmp_path, capsys):
    assert main(["export", "c", "friction", "-o", str(tmp_path / "ecu")]) == 3
    assert "name it with --vehicle" in capsys.readouterr().err


def test_a_readme_of_the_user_is_not_overwritten(tmp_path, capsys):
    (tmp_path / "README.md").write_text("mine")
    assert main(["export", "c", "sideslip", "--vehicle", "midsize-eps", "-o", str(tmp_path)]) == 3
    assert "name a folder of its own" in capsys.readouterr().err
    assert (tmp_path / "README.md").read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("c fault-memory --vehicle midsize-eps --precision double", "--vehicle and --precision would have no effect"),
        ("c fault-memory --no-libm", "--no-libm would have no effect on the fault memory"),
        ("c friction --vehicle midsize-eps --scenario weave-small-car", "--scenario would have no effect on the C"),
        ("fmu friction --vehicle midsize-eps --precision double", "--precision would have no effect on the unit"),
        ("fmu plant --scenario weave-small-car --vehicle midsize-eps", "--vehicle would have no effect on the unit"),
        ("fmu friction --vehicle midsize-eps --evidence", "--evidence would have no effect on the unit"),
        ("c nope", "there is no monitor 'nope'"),
        ("c fault-memry", "did you mean 'fault-memory'"),
    ],
)
def test_options_without_effect_and_unknown_names_are_refused_in_a_sentence(tmp_path, capsys, words, sentence):
    assert main(["export", *words.split(), "-o", str(tmp_path / "out")]) == 3
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()
