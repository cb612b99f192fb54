"""Units are valid, state what `scan` states, and say in a message what is wrong."""

import ctypes
import zipfile

import numpy as np
import pytest

from exported_c import needs_gcc, reference, rounded, worst_share
from tierod.core.fields import replaced
from tierod.core.graph import scan
from tierod.export.fmu_archive import write_unit
from tierod.export.fmu_description import Model
from tierod.export.interface import Interface, Options
from tierod.export.subject import subject_of, subject_of_block
from tierod.export.vectors import random_inputs
from tierod_lab.ground.cars.benches import ColumnBench
from tierod_lab.ground.run import usual_inputs
from watched_torque import Watch

fmpy = pytest.importorskip("fmpy", reason="fmpy is not installed")
fmi2 = pytest.importorskip("fmpy.fmi2")

pytestmark = needs_gcc

OPTIONS = Options("double", libm=False, fused=True)


def unit(subject, folder, starts=None, present=False):
    """A unit written into a folder: its model and path."""
    model = Model(Interface(subject, OPTIONS), starts or {}, present)
    return model, write_unit(model, folder / "unit.fmu")


class Instance:
    """A unit that runs; collects its log messages."""

    def __init__(self, path, folder):
        self.description = fmpy.read_model_description(path)
        given = {
            "guid": self.description.guid,
            "unzipDirectory": fmpy.extract(str(path), str(folder / "unpacked")),
            "modelIdentifier": self.description.coSimulation.modelIdentifier,
            "instanceName": "one",
        }
        self.fmu = fmi2.FMU2Slave(**given)
        self.references = {each.name: each.valueReference for each in self.description.modelVariables}
        self.messages = []
        self.fmu.instantiate(callbacks=self._callbacks(), loggingOn=True)
        self.time = 0.0

    def _callbacks(self):
        from fmpy.logging import addLoggerProxy

        def log(environment, name, status, category, message):
            self.messages.append(message.decode())

        self.kept = fmi2.fmi2CallbackFunctions()
        self.kept.logger = fmi2.fmi2CallbackLoggerTYPE(log)
        self.kept.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        self.kept.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        addLoggerProxy(ctypes.byref(self.kept))
        return self.kept

    def begin(self, stop=None):
        self.fmu.setupExperiment(startTime=0.0, stopTime=stop)
        self.fmu.enterInitializationMode()

    def begun(self):
        self.fmu.exitInitializationMode()

    def set(self, names, values):
        chosen = [self.references[name] for name in names]
        self.fmu.setReal(chosen, [float(each) for each in values])

    def get(self, names):
        chosen = [self.references[name] for name in names]
        return self.fmu.getReal(chosen)

    def status(self, name):
        chosen = [self.references[name]]
        return self.fmu.getInteger(chosen)[0]

    def step(self, size):
        self.fmu.doStep(self.time, size)
        self.time += size

    def end(self):
        self.fmu.terminate()
        self.fmu.freeInstance()


def rows_of(instance, model, inputs, step):
    names = [each.name for each in model.of("input")]
    outputs = model.of("output", "status")
    numbers = [each.name for each in outputs if each.kind == "output"]
    found = np.zeros((len(inputs), len(outputs)))
    at = [each.kind == "output" for each in outputs]
    for k, row in enumerate(inputs):
        instance.set(names, row)
        if model.present:
            found[k, at] = instance.get(numbers)
        instance.step(step)
        if not model.present:
            found[k, at] = instance.get(numbers)
            found[k, np.logical_not(at)] = [instance.status(e.name) for e in outputs if e.kind == "status"]
    return found


@pytest.fixture(scope="module")
def friction():
    return subject_of("friction", "midsize-eps")


@pytest.fixture(scope="module")
def watch():
    return subject_of_block("watch", Watch(), 100.0, "A watch")


@pytest.fixture(scope="module")
def watches(watch, tmp_path_factory):
    return unit(watch, tmp_path_factory.mktemp("watch"))


@pytest.fixture(scope="module")
def benches(tmp_path_factory):
    bench = ColumnBench()
    subject = subject_of_block("plant", bench, 1.0 / bench.step_time, "A bench")
    folder, starts = tmp_path_factory.mktemp("bench"), usual_inputs(bench)
    return unit(subject, folder, starts, present=True)


def test_a_monitor_is_valid_and_states_what_scan_states(friction, tmp_path):
    from fmpy.validation import validate_fmu

    model, path = unit(friction, tmp_path)
    assert validate_fmu(str(path)) == []
    inputs = rounded(random_inputs(friction, 600, seed=2))
    instance = Instance(path, tmp_path)
    instance.begin()
    instance.begun()
    found = rows_of(instance, model, inputs, 0.01)
    instance.end()
    assert worst_share(found, reference(friction, inputs)).max() <= 1e-12


def test_a_tunable_parameter_acts_from_the_next_step_and_a_fixed_one_before_the_first(watches, tmp_path):
    model, path = watches
    kinds = {each.name: each.kind for each in model.variables}
    assert kinds["limit"] == kinds["memory"] == "tunable"
    assert "sample_time" not in kinds
    instance = Instance(path, tmp_path)
    instance.begin()
    instance.set(["limit"], [6.0])
    instance.begun()
    rows = rows_of(instance, model, np.full((50, 1), 5.0), 0.01)
    other = scan(replaced(Watch(), {"limit": 6.0}), np.full((50, 1), 5.0)).values
    assert worst_share(rows, other).max() <= 1e-12
    instance.set(["limit"], [1.0])
    assert rows_of(instance, model, np.full((50, 1), 5.0), 0.01)[-1, 0] == 2.0
    instance.end()


def wrong(instance, action, *arguments):
    instance.messages.clear()
    with pytest.raises(Exception, match="failed"):
        action(*arguments)
    return instance.messages[-1]


def test_what_is_wrong_is_said_in_a_message(watches, tmp_path):
    _, path = watches
    instance = Instance(path, tmp_path)
    assert "a step follows initialization" in wrong(instance, instance.step, 0.01)
    instance.begin(stop=1.0)
    instance.begun()
    assert "the instance is at 0 s" in wrong(instance, instance.fmu.doStep, 0.5, 0.01)
    assert "beyond the end of the run, 1 s" in wrong(instance, instance.fmu.doStep, 0.0, 1.5)
    assert "'smooth' is no input and no parameter" in wrong(instance, instance.set, ["smooth"], [1.0])
    assert "no variable with the value reference 99" in wrong(instance, instance.fmu.getReal, [99])
    assert "'statement.status' is an enumeration" in wrong(instance, instance.get, ["statement.status"])
    instance.end()


def test_the_same_unit_is_made_of_the_same_bytes(watch, watches, tmp_path):
    _, first = watches
    before = first.read_bytes()
    _, second = unit(watch, tmp_path)
    assert second.read_bytes() == before
    names = zipfile.ZipFile(second).namelist()
    assert {"modelDescription.xml", "sources/fmi2.c", "documentation/index.html"} <= set(names)
    assert "2-Clause BSD" in zipfile.ZipFile(second).read("licenses/fmi-headers.txt").decode()
