"""Structural analysis against a published toolbox, and against cases that can be worked out by hand."""

import random
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.methods.analysis.structure import Equation, StructuralModel, gain_of_sensors, isolability, structure_of


def drawn(seed, equations=12, unknowns=8, faults=5):
    chance = random.Random(seed)
    names = [f"x{j}" for j in range(unknowns)]
    inside = [set(chance.sample(names, chance.randint(1, 3))) for _ in range(equations)]
    for name in set(names) - set().union(*inside):
        inside[chance.randrange(equations)].add(name)
    faulty = dict(zip(chance.sample(range(equations), faults), (f"f{k}" for k in range(faults)), strict=True))
    return StructuralModel(tuple(Equation.of(f"e{i}", each, (), faulty.get(i, "")) for i, each in enumerate(inside)))


def by_toolbox(model):
    toolbox = pytest.importorskip("faultdiagnosistoolbox")
    faults = sorted(model.faults)
    rows = [[*sorted(each.unknowns), *([each.fault] if each.fault else [])] for each in model.equations]
    definition = {"type": "VarStruc", "x": list(model.unknowns), "f": faults, "z": [], "rels": rows}
    return toolbox.DiagnosisModel(definition, name="drawn")


SEEDS = range(12)


@pytest.mark.parametrize("seed", SEEDS)
def test_detectable_and_isolable_faults_are_those_of_the_toolbox(seed):
    model = drawn(seed)
    found, toolbox = isolability(model), by_toolbox(model)
    detectable, _ = toolbox.DetectabilityAnalysis()
    assert {fault for fault, seen in zip(found.faults, found.detectable, strict=True) if seen} == set(detectable)
    order = [found.faults.index(fault) for fault in toolbox.f]
    theirs = np.asarray(toolbox.IsolabilityAnalysis()) > 0.5
    seen = found.detectable[order]
    assert np.array_equal(found.mistaken[np.ix_(order, order)][seen], theirs[seen])


def test_drawn_structures_isolate_some_faults_but_not_all():
    found = [isolability(drawn(seed)) for seed in SEEDS]
    assert any(each.undetectable for each in found)
    assert any(len(group) > 1 for each in found for group in each.groups)
    assert any(each.isolable for each in found)


def three_sensors_of_one_speed(count):
    return StructuralModel(tuple(Equation.of(f"sensor {k}", ["speed"], [f"y{k}"], f"fault {k}") for k in range(count)))


def test_two_sensors_of_one_quantity_detect_a_fault_and_three_isolate_it():
    two, three = (isolability(three_sensors_of_one_speed(count)) for count in (2, 3))
    assert two.undetectable == ()
    assert two.isolable == ()
    assert two.groups == (("fault 0", "fault 1"),)
    assert two.mistaken_for("fault 0") == ("fault 1",)
    assert three.isolable == three.faults
    one = isolability(three_sensors_of_one_speed(1))
    assert one.undetectable == ("fault 0",)
    assert one.groups == ()


def test_four_sensors_of_one_quantity_show_two_faults_at_once():
    pairs = {count: isolability(three_sensors_of_one_speed(count), at_once=2) for count in (3, 4)}
    assert set(pairs[3].groups[-1]) == {"fault 0 + fault 1", "fault 0 + fault 2", "fault 1 + fault 2"}
    assert all(len(group) == 1 for group in pairs[4].groups[:4])


def test_the_sensor_that_helps_most_comes_first():
    model = StructuralModel(
        (
            Equation.of("speed", ["speed"], ["y"], "speed fault"),
            Equation.of("drag", ["speed", "force"], (), "drag fault"),
        )
    )
    useless = Equation.of("temperature", ["temperature"], ["t"], "temperature fault")
    second = Equation.of("second speed", ["speed"], ["z"], "second fault")
    force = Equation.of("force", ["force"], ["f"], "force fault")
    gains = gain_of_sensors(model, [useless, second, force])
    assert [gain.sensor for gain in gains] == ["force", "second speed", "temperature"]
    assert gains[0].detectable == ("speed fault", "drag fault")
    assert gains[1].detectable == ("speed fault",)
    assert gains[2].detectable == ()
    assert not gains[2].own_isolable


class Mass:
    """A mass on a spring with a force that is commanded; its position is measured."""

    class State(NamedTuple):
        position: float
        speed: float
        drift: float

    class Input(NamedTuple):
        force: float

    class Output(NamedTuple):
        position_sensor: float
        speed_sensor: float

    @dataclass(frozen=True)
    class Parameters:
        stiffness: float = 3.0
        offset: float = 0.0

    @staticmethod
    def derivative(x, u, p):
        return Mass.State(x.speed, u.force - p.stiffness * x.position + x.drift, 0.0)

    @staticmethod
    def output(x, u, p):
        return Mass.Output(x.position, x.speed + p.offset * u.force)


def test_the_structure_of_a_model_is_read_from_its_functions():
    faults = {"position_sensor": "position", "speed_sensor": "speed", "known force": "actuator"}
    model = structure_of(Mass, Mass.Parameters(), faults, known_inputs=["force"], without=["drift"])
    inside = {each.name: each.unknowns for each in model.equations}
    assert inside == {
        "motion of position": {"d position", "speed"},
        "motion of speed": {"d speed", "force", "position"},
        "d position": {"d position", "position"},
        "d speed": {"d speed", "speed"},
        "position_sensor": {"position"},
        "speed_sensor": {"speed"},
        "known force": {"force"},
    }
    found = isolability(model)
    assert found.undetectable == ()
    assert found.mistaken_for("actuator") == ()  # the two sensors agree all the same
    with_offset = structure_of(Mass, Mass.Parameters(offset=0.1), faults, ["force"], ["drift"])
    assert with_offset.by_name["speed_sensor"].unknowns == {"speed", "force"}


def test_an_unknown_input_or_a_drifting_model_hides_the_actuator():
    faults = {"position_sensor": "position", "speed_sensor": "speed", "known force": "actuator"}
    free = structure_of(
        Mass, Mass.Parameters(), {k: v for k, v in faults.items() if v != "actuator"}, without=["drift"]
    )
    assert isolability(free).groups == (("position", "speed"),)
    drifting = structure_of(Mass, Mass.Parameters(), faults, known_inputs=["force"])
    assert "drift" in drifting.unknowns
    one = structure_of(Mass, Mass.Parameters(), faults, ["force"], ["drift", "speed_sensor", "position_sensor"])
    assert isolability(one).undetectable == ("actuator",)


def test_bad_structures_are_refused():
    with pytest.raises(ParameterError, match="two equations are named 'a'"):
        StructuralModel((Equation.of("a", "x"), Equation.of("a", "y")))
    with pytest.raises(ParameterError, match="two equations hold the fault 'f'"):
        StructuralModel((Equation.of("a", "x", (), "f"), Equation.of("b", "y", (), "f")))
    with pytest.raises(ParameterError, match="no equation 'speedd'.*speed"):
        StructuralModel((Equation.of("speed", ["x"]),)).without("speedd")
    with pytest.raises(ParameterError, match="no 'forc'"):
        structure_of(Mass, Mass.Parameters(), {}, known_inputs=["forc"])
