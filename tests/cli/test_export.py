import pytest

from tierod.cli import main


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


def test_a_readme_of_the_user_is_not_overwritten(tmp_path, capsys):
    (tmp_path / "README.md").write_text("mine")
    assert main(["export", "c", "sideslip", "--vehicle", "midsize-eps", "-o", str(tmp_path)]) == 3
    assert "name a folder of its own" in capsys.readouterr().err
    assert (tmp_path / "README.md").read_text() == "mine"
