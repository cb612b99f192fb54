"""What every public name, command, parameter set and scenario promises; new ones are found by themselves."""

import dataclasses
import importlib
import importlib.util
import inspect
import json
import pkgutil
import re
import typing
from pathlib import Path
from typing import Annotated

import numpy as np
import pint
import pytest

import tierod
import tierod_lab
from tierod.cli import main
from tierod.cli.app import commands
from tierod.io.readers import read
from tierod_lab.ground import courses, scenarios
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.run import run

MODULES = sorted(
    module.name
    for package in (tierod, tierod_lab)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    if not module.name.endswith("__main__")
)


def test_every_name_that_tierod_exports_is_explained():
    exported = {name: getattr(tierod, name) for name in tierod.__all__}
    found = {name: value for name, value in exported.items() if inspect.isclass(value) or inspect.isfunction(value)}
    assert len(found) > 15
    bare = [name for name, value in found.items() if not (value.__doc__ or "").strip()]
    assert not bare, f"without a docstring: {', '.join(bare)}"


SAME_UNIT = "unit of the signal"  # What a block says that works on any signal, such as a low-pass or a stopping rule


def tuned():
    """Every dataclass whose floats become inputs of a graph: blocks, `Parameters`, and what they are made of."""
    found = {}
    for name in MODULES:
        for value in vars(importlib.import_module(name)).values():
            if inspect.isclass(value) and value.__module__ == name and dataclasses.is_dataclass(value):
                block = hasattr(value, "step") and hasattr(value, "init")
                if block or value.__name__.endswith(("Parameters", "Tuning", "Limits")):
                    collect(value, found)
    return found


def collect(owner, found):
    key = f"{owner.__module__}.{owner.__qualname__}"
    if key in found:
        return
    found[key] = owner
    for hint in typing.get_type_hints(owner).values():
        for part in (hint, *typing.get_args(hint)):
            if inspect.isclass(part) and dataclasses.is_dataclass(part) and part.__module__.startswith("tierod"):
                collect(part, found)


def unit_of(hint):
    """The unit that `Annotated[float, unit]` declares; None where a float has none, "" where it is no float."""
    if typing.get_origin(hint) is Annotated:
        inner, *notes = typing.get_args(hint)
        return notes[0] if float in (inner, *typing.get_args(inner)) else ""
    return None if float in (hint, *typing.get_args(hint)) and typing.get_origin(hint) is not tuple else ""


def readable(unit):
    return unit == SAME_UNIT or pint.get_application_registry().parse_units(unit) is not None


def test_every_number_that_tunes_has_a_unit():
    found = tuned()
    assert len(found) > 100
    for name, owner in found.items():
        hints = typing.get_type_hints(owner, include_extras=True)
        units = {field.name: unit_of(hints[field.name]) for field in dataclasses.fields(owner)}
        bare = [field for field, unit in units.items() if unit is None]
        assert not bare, f'write Annotated[float, "N*m"] (or "{SAME_UNIT}") for {", ".join(bare)} of {name}'
        for unit in filter(None, units.values()):
            assert readable(unit), name


@pytest.mark.parametrize("verb", commands())
def test_every_command_answers_help_and_refuses_an_unknown_option_in_one_line(verb, capsys):
    assert main([verb, "--help"]) == 0
    usage, _, rest = capsys.readouterr().out.partition(f"tierod {verb}")
    assert usage
    assert re.match(r"[^╭]*\n\s*[A-Z][^╭]*\.", rest), "the help does not say what the command does"
    assert main([verb, "--no-such-option"]) == 3
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert "--no-such-option" in captured.err


SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "budget.py"


def test_nothing_is_above_its_budget():
    spec = importlib.util.spec_from_file_location("budget", SCRIPT)
    budget = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(budget)
    assert not budget.complaints(), "\n".join(budget.complaints())


@pytest.mark.parametrize("name", scenarios.shipped())
def test_every_shipped_scenario_can_be_driven(name, tmp_path, capsys):
    assert main(["simulate", name, "-o", str(tmp_path / "drive.parquet"), "--seconds", "1.5", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    recording = read(tmp_path / "drive.parquet")
    assert recording.span[1] == pytest.approx(1.5, abs=0.02)
    assert set(result["measured_channels"] + result["truth_channels"]) == set(recording.names)
    assert all(np.isfinite(channel.values).any() for channel in recording.channels.values())
    assert scenarios.load(name).name == name
    assert scenarios.load(name).description.endswith(".")


@pytest.mark.parametrize("name", catalogue.shipped())
def test_every_shipped_car_can_be_driven(name):
    car = catalogue.load(name).block
    course = courses.load("mixed" if hasattr(car, "chassis") else "bench-sweep")
    outcome = run(car, course, 2.0)
    assert outcome.diverged_at is None
    assert all(np.isfinite(channel.values).all() for channel in outcome.recording.channels.values())
