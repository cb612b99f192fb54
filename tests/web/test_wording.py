"""Sentences of the library with what to do in the page."""

import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.io.readers import read
from tierod.monitors.acceptance import vehicle_named_in
from tierod.web.errors import in_the_page
from tierod_lab.web.scenarios import drive


def test_a_bus_log_without_database_leads_to_the_page(tmp_path):
    path = tmp_path / "can.log"
    path.write_text("".join(f"({n / 100:.6f}) can0 025#0000000000000000\n" for n in range(50)))
    with pytest.raises(InputError) as found:
        read(path)
    said = in_the_page(str(found.value))
    assert ": choose or upload it as CAN database under 'New recording', or name it in the vehicle file" in said
    assert "--dbc" in str(found.value)
    assert "--" not in said


def test_a_recording_without_vehicle_leads_to_the_page(tmp_path):
    path = tmp_path / "drive.csv"
    path.write_text("time,yaw_rate [rad/s]\n" + "".join(f"{n / 100:.2f},0.{n}\n" for n in range(50)))
    with pytest.raises(ParameterError) as found:
        vehicle_named_in(path)
    assert "--vehicle" in str(found.value)
    assert (
        in_the_page(str(found.value))
        == "no vehicle is given, and the recording names none; choose one under 'judged as'"
    )


def test_of_a_damaged_file_the_damage_is_named_and_no_vehicle(tmp_path):
    path = tmp_path / "broken.parquet"
    path.write_bytes(b"PAR1" + bytes(500))
    with pytest.raises(InputError) as found:
        vehicle_named_in(path)
    said = in_the_page(str(found.value))
    assert "no vehicle is given" in str(found.value)
    assert "vehicle" not in said
    assert "broken.parquet" in said


def test_what_names_no_option_stays():
    assert in_the_page("the file is empty; record it again") == "the file is empty; record it again"


@pytest.mark.parametrize("fault", ["friction-step", "driver-torque-offset", "assist-half"])
def test_a_size_of_another_kind_is_named_as_in_the_page(fault, tmp_path):
    chosen = {"car": "midsize-eps", "course": "mixed", "seconds": 1.0, "folder": str(tmp_path)}
    with pytest.raises(ParameterError) as found:
        drive({**chosen, "faults": [{"name": fault, "size": "5 kg", "start": 0.5}]}, lambda share: None)
    said = str(found.value)
    assert said.startswith(f"the size of {fault} is '5 kg', but ")
    assert "; give for example " in said
    assert "'to'" not in said
    assert "faults.0" not in said
