import json

import pytest

from diagnosis.memories import code, drive, table
from tierod.core.errors import ParameterError
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.diagnosis.sovd import fault, faults


def memory():
    memory = FaultMemory(table(a=code(1, lamp=True), b=code(2)))
    drive(memory, {"a": (-1.0, 5.0, 1.0), "b": -1.0})
    return memory


def test_it_has_the_shape_of_the_resource_faults():
    document = json.loads(json.dumps(faults(memory())))
    (item,) = document["items"]
    assert item["code"] == "5A0162"
    assert item["display_code"] == "C1A01-62"
    assert item["status"]["mask"] == "AF"
    assert item["status"]["confirmedDTC"] == "1"
    assert item["status"]["testNotCompletedThisOperationCycle"] == "0"
    assert item["status"]["aggregatedStatus"] == "active"
    assert len(faults(memory(), everything=True)["items"]) == 2


def test_one_fault_comes_with_its_environment():
    document = json.loads(json.dumps(fault(memory(), "C1A01-62"), allow_nan=False))
    environment = document["environment_data"]
    assert environment["extended_data_records"]["occurrence_counter"] == 1
    assert {"name": "vehicle_speed", "unit": "m/s", "value": 15.0} in environment["snapshots"][0]["data"]


@pytest.mark.parametrize(("name", "says"), [("b", "has not failed"), ("C9", "there is no trouble code 'C9'")])
def test_a_code_that_is_not_there_is_refused(name, says):
    with pytest.raises(ParameterError, match=says):
        fault(memory(), name)
