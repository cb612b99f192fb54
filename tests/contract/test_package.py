"""What every public name, command and parameter set of the package promises; new files are found by themselves."""

import dataclasses
import importlib
import inspect
import pkgutil
import typing
from typing import Annotated

import pint
import pytest

import tierod
import tierod_lab
from tierod.cli import main
from tierod.cli.app import commands
from tierod.core.units import known
from tierod.vehicles import QUANTITIES, load, shipped

MODULES = sorted(
    module.name
    for package in (tierod, tierod_lab)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    if not module.name.endswith("__main__")
)


def public(module):
    """The classes and functions that a module itself defines for others, nested classes and methods included."""
    for name, value in vars(module).items():
        own = getattr(value, "__module__", None) == module.__name__
        if own and not name.startswith("_") and (inspect.isclass(value) or inspect.isfunction(value)):
            yield name, value
            if inspect.isclass(value):
                yield from members(name, value)


def members(path, owner):
    for name, value in vars(owner).items():
        inner = getattr(value, "__func__", getattr(value, "fget", value))
        if name.startswith("_") or getattr(inner, "__module__", None) != owner.__module__:
            continue
        if inspect.isclass(inner) and inner.__qualname__ == f"{owner.__qualname__}.{name}":
            yield f"{path}.{name}", inner
            yield from members(f"{path}.{name}", inner)
        elif inspect.isfunction(inner) and not inner.__code__.co_filename.startswith("<"):
            yield f"{path}.{name}", inner


def test_every_module_is_explained():
    bare = [name for name in MODULES if not (importlib.import_module(name).__doc__ or "").strip()]
    assert not bare, f"without a docstring: {', '.join(bare)}"


def test_every_name_that_tierod_exports_is_explained():
    exported = {name: getattr(tierod, name) for name in tierod.__all__}
    found = {name: value for name, value in exported.items() if inspect.isclass(value) or inspect.isfunction(value)}
    assert len(found) > 15
    bare = [name for name, value in found.items() if not (value.__doc__ or "").strip()]
    assert not bare, f"without a docstring: {', '.join(bare)}"


def test_every_exported_name_exists():
    modules = [importlib.import_module(name) for name in MODULES]
    absent = [(each.__name__, n) for each in modules for n in getattr(each, "__all__", ()) if not hasattr(each, n)]
    assert not absent


SAME_UNIT = "unit of the signal"  # What a block says that works on any signal, such as a low-pass or a stopping rule


def tuned():
    """Every dataclass whose floats become inputs of a graph: blocks, `Parameters`, and what they are made of."""
    found = {}
    for name in MODULES:
        for path, value in public(importlib.import_module(name)):
            if inspect.isclass(value) and dataclasses.is_dataclass(value):
                block = hasattr(value, "step") and hasattr(value, "init")
                if block or path.endswith(("Parameters", "Tuning", "Limits")):
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


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_vehicle_loads(name):
    vehicle = load(name)
    for parameter in vehicle.parameters.values():
        quantity = QUANTITIES[parameter.name]
        low, high = quantity.plausible
        assert low <= parameter.value <= high
        assert parameter.unit == (vehicle.torque_unit if quantity.torque else quantity.unit)


def test_every_quantity_has_a_unit_a_meaning_and_a_range():
    for name, quantity in QUANTITIES.items():
        assert known(quantity.unit), name
        assert quantity.meaning, name
        assert quantity.plausible[0] < quantity.plausible[1], name


@pytest.mark.parametrize("verb", commands())
def test_every_command_answers_help(verb, capsys):
    assert main([verb, "--help"]) == 0
    printed = capsys.readouterr().out
    assert f"tierod {verb}" in printed


@pytest.mark.parametrize("verb", commands())
def test_every_command_refuses_an_unknown_option_in_one_line(verb, capsys):
    assert main([verb, "--no-such-option"]) == 3
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert "--no-such-option" in captured.err
