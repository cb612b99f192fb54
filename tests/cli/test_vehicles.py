import json

import pytest

from tierod.cli import main
from tierod.core.errors import ParameterError
from tierod.vehicles import VEHICLES, load, shipped


def test_lists_what_is_shipped(capsys):
    assert main(["vehicles"]) == 0
    printed = capsys.readouterr().out
    for name in shipped():
        assert name in printed


@pytest.mark.parametrize("name", shipped())
def test_shows_sources_and_what_it_is_not_good_for(name, capsys):
    assert main(["vehicles", name]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    vehicle = load(name)
    assert "Not good for" in printed
    for line in vehicle.not_good_for:
        assert line in printed
    for parameter in vehicle.parameters:
        assert parameter in printed


def test_prints_a_file_to_begin_with(capsys, tmp_path):
    assert main(["vehicles", "midsize-eps", "--toml"]) == 0
    mine = tmp_path / "mine.toml"
    mine.write_text(capsys.readouterr().out, encoding="utf-8")
    assert load(mine).rows() == load("midsize-eps").rows()


def test_a_copy_finds_the_files_that_the_vehicle_names(capsys, tmp_path):
    assert main(["vehicles", "rav4", "--toml"]) == 0
    mine = tmp_path / "mine.toml"
    mine.write_text(capsys.readouterr().out, encoding="utf-8")
    copy, shipped_one = load(mine), load("rav4")
    assert copy.channel_map.samefile(shipped_one.channel_map)
    assert copy.database.samefile(shipped_one.database)


def test_shows_one_vehicle_as_json(capsys):
    assert main(["vehicles", "rav4", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["torque_unit"] == "count"
    assert document["parameters"][0].keys() == {"name", "value", "unit", "standard_deviation", "source"}


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--toml"], "--toml needs a vehicle"),
        (["rav4", "--toml", "--json"], "exclude each other"),
        (["rav5"], "did you mean 'rav4'"),
    ],
)
def test_wrong_use_is_reported(arguments, sentence, capsys):
    assert main(["vehicles", *arguments]) == 3
    assert sentence in capsys.readouterr().err


def test_a_copy_names_no_place_of_this_computer(capsys):
    assert main(["vehicles", "ferrari-250lm", "--toml"]) == 0
    assert 'map = "ferrari-250lm.channels.toml"' in capsys.readouterr().out


def test_a_vehicle_file_that_moved_finds_its_map_beside_it_or_says_what_is_missing(tmp_path):
    text = VEHICLES["midsize-eps"].read_text(encoding="utf-8")
    text += '\n[channels]\nmap = "/home/somebody/maps/car.channels.toml"\n'
    (tmp_path / "car.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ParameterError, match="put it beside the vehicle file"):
        load(tmp_path / "car.toml")
    own = tmp_path / "car.channels.toml"
    own.write_text('[signals.yaw_rate]\nsource = "yaw"\n', encoding="utf-8")
    assert load(tmp_path / "car.toml").channel_map.samefile(own)
