"""What `import tierod` offers is what the commands do."""

import json

import numpy as np
import pytest

import tierod
from tierod.cli import main


@pytest.mark.parametrize("name", dir(tierod))
def test_every_name_is_there(name):
    assert getattr(tierod, name) is not None
    assert name in dir(tierod)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'no_such'"):
        tierod.no_such  # noqa: B018


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    path = tmp_path_factory.mktemp("drive") / "drive.parquet"
    tierod.write(tierod.simulate("hands-off", seconds=20.0, seed=2).recording, path)
    return path


def test_simulate_is_the_command(drive, tmp_path):
    other = tmp_path / "other.parquet"
    assert main(["simulate", "hands-off", "--seconds", "20", "--seed", "2", "-o", str(other)]) == 0
    first, second = tierod.read(drive), tierod.read(other)
    assert first.names == second.names
    for name in first.names:
        np.testing.assert_array_equal(first[name].values, second[name].values)


def test_inspect_is_the_command(drive, capsys):
    assert main(["inspect", str(drive), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    found = tierod.inspect(drive)
    assert [row.name for row in found.quality] == [row["name"] for row in document["channels"]]
    assert [bool(each.variants) for each in found.monitors] == [each["can_run"] for each in document["monitors"]]
    whole = tierod.inspect(tierod.read(drive), "midsize-eps")
    assert whole.vehicle.name == "midsize-eps"


def test_isolability_is_the_command(capsys):
    assert main(["isolability", "--json", "--no-report"]) == 0
    assert json.loads(capsys.readouterr().out)["views"] == json.loads(
        json.dumps(tierod.isolability().document["views"])
    )


def test_identify_refuses_what_it_cannot_do(drive):
    with pytest.raises(tierod.TierodError, match="'colum' cannot be identified; did you mean 'column'"):
        tierod.identify("colum", [drive], "column-bench")
    with pytest.raises(tierod.TierodError, match="does not use a time between false alarms"):
        tierod.identify("column", [drive], "column-bench", hours=10.0)


def test_a_campaign_compared_with_itself_has_no_differences(tmp_path):
    (tmp_path / "base.toml").write_text(
        'name = "base"\ndescription = "Straight."\ncar = "midsize-eps-light"\ncourse = "country"\nseconds = 5.0\n'
    )
    file = tmp_path / "one.toml"
    file.write_text(
        'name = "one"\ndescription = "One drive."\nscenario = "base.toml"\nseeds = [1]\n'
        '[[monitors]]\nmonitor = "friction"\nvehicle = "midsize-eps"\nbaseline = "none"\n'
    )
    found = tierod.campaign(file, tmp_path / "runs", 1)
    assert found.page.is_file()
    assert len(found.content["cells"]) == 1
    compared = tierod.compare(tmp_path / "runs", tmp_path / "runs", tmp_path)
    assert compared.content["monitors"][0]["changed"] == []


def test_objects_are_taken_in_place_of_names(drive):
    recording = tierod.read(drive)
    car = tierod.vehicle("midsize-eps")
    from tierod.monitors.friction.definition import FRICTION

    by_name = tierod.diagnose(recording, car, monitor="friction")
    for monitor in (FRICTION, FRICTION.variants[FRICTION.default]):
        assert tierod.diagnose(recording, car, monitor=monitor).findings == by_name.findings
    with pytest.raises(tierod.TierodError, match="belongs to no registered monitor"):
        tierod.diagnose(recording, car, monitor=tierod.Variant("mine", "", "", print))
    with pytest.raises(tierod.TierodError, match="the monitor '3' is of the type 'int'"):
        tierod.diagnose(recording, car, monitor=3)
