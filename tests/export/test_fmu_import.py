"""A unit takes the place of our plant, with our driver and sensors; what is wrong with it is one sentence."""

import numpy as np
import pytest

from exported_c import needs_gcc
from foreign_units import PLANT, Trolley, exported
from tierod.cli import main
from tierod.core.errors import ParameterError
from tierod.core.toml import Document
from tierod_lab.ground.scenarios import load, with_plant

fmpy = pytest.importorskip("fmpy", reason="fmpy is not installed")

pytestmark = needs_gcc


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("units")
    exported(Trolley(), place / "trolley.fmu")
    (place / "trolley.toml").write_text(PLANT.replace("LASTS", "1e9"))
    return place


@pytest.fixture(scope="module")
def mixed():
    return load("mixed-drive-healthy").with_run(6.0)


def driven(scenario, document):
    return with_plant(scenario, document)[0].run()


def changed(folder, old, new):
    return Document.parse(PLANT.replace("LASTS", "1e9").replace(old, new), folder / "changed.toml", "plant")


def test_our_own_plant_as_a_unit_drives_as_without_it(tmp_path, mixed):
    unit = tmp_path / "car.fmu"
    assert main(["export", "fmu", "plant", "--scenario", "mixed-drive-healthy", "-o", str(unit)]) == 0
    found = fmpy.read_model_description(str(unit)).modelVariables
    inputs = {each.name: each.name for each in found if each.causality == "input" and "ports." not in each.name}
    last = {each.name.rpartition(".")[2]: each.name for each in found if each.causality == "output"}
    names = ("steering_wheel_angle", "yaw_rate", "vehicle_speed", "driver_torque", "truth_speed", "truth_distance")
    outputs = {name: last[name] for name in names if name in last}
    document = Document({"fmu": str(unit), "inputs": inputs, "outputs": outputs}, "", tmp_path / "p.toml")
    ours, theirs = mixed.run(), driven(mixed, document)
    assert theirs.reason == ""
    assert {"steering_wheel_angle", "yaw_rate"} <= set(theirs.recording.names)
    for name, other in theirs.recording.channels.items():
        each = ours.recording.channels[name]
        np.testing.assert_array_equal(other.time, each.time)
        np.testing.assert_allclose(other.values, each.values, rtol=0.0, atol=1e-9 * max(np.ptp(each.values), 1e-9))


def test_our_driver_keeps_a_vehicle_of_another_make_on_its_path(folder, mixed):
    outcome = driven(mixed.with_run(20.0), Document.read(folder / "trolley.toml", "plant"))
    assert (outcome.reason, outcome.diverged_at) == ("", None)
    found = {name: each.values for name, each in outcome.recording.channels.items()}
    assert np.abs(found["truth_lateral_offset"]).max() < 0.5
    assert found["truth_distance"][-1] > 50.0
    assert found["vehicle_speed"].max() < 20.0
    np.testing.assert_allclose(
        np.gradient(found["truth_distance"], 0.01)[5:-5], found["truth_vehicle_speed"][5:-5], atol=0.05
    )
    moved = np.abs(np.diff(found["truth_steering_wheel_angle"])).max()
    assert 0.0 < moved < 0.2


SLIPS = {
    "no such input": ("long_force =", "longforce =", "has no input 'longforce'; did you mean 'long_force'"),
    "another unit": ('"v_kmh"', '{ variable = "v_kmh", unit = "kg" }', "cannot become 'm/s'"),
    "no parameter": ("lasts", "lust", "has no parameter 'lust'"),
    "a needed output": ('vehicle_speed = "v_kmh"\n', "", "our driver needs truth_speed or vehicle_speed"),
    "a sign": ("sign = -1", "sign = 2", "'sign' has to be 1 or -1"),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_in_a_plant_file_is_one_sentence(folder, mixed, slip):
    old, new, message = SLIPS[slip]
    with pytest.raises(ParameterError, match=".") as caught:
        with_plant(mixed, changed(folder, old, new))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
