"""What every model of the package promises: pure equations whose shapes fit, with Jacobians that agree with steps."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from dataclasses import MISSING, fields

import numpy as np
import pytest

import tierod.models
import tierod_lab.papers
from tierod.core.block import leaves, rebuild, skeleton, units
from tierod.core.graph import jacobian
from tierod.models.steering_column import ColumnParameters, TwoInertiaColumn, without_gear
from tierod.vehicles import load, shipped


def models() -> list[type]:
    found = []
    modules = [
        info.name
        for package in (tierod.models, tierod_lab.papers)
        for info in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    ]
    for name in modules:
        module = importlib.import_module(name)
        for member in vars(module).values():
            parts = ("State", "Input", "Output", "Parameters", "output")
            if inspect.isclass(member) and member.__module__ == name and all(hasattr(member, p) for p in parts):
                found.append(member)
    return found


@pytest.fixture(params=models(), ids=lambda model: model.__name__)
def model(request):
    return request.param


def trees(model):
    random = np.random.default_rng(2)
    state, inputs = skeleton(model.State), skeleton(model.Input)
    draw = lambda tree: rebuild(tree, random.uniform(0.3, 1.0, len(list(leaves(tree)))).tolist())  # noqa: E731
    return draw(state), draw(inputs), parameters_of(model)


def parameters_of(model):
    """From the first shipped vehicle that has all of them; a model of what no vehicle file holds has its own here."""
    if model is TwoInertiaColumn:
        return without_gear(load("column-bench").parameters_for(ColumnParameters))
    needed = [f.name for f in fields(model.Parameters) if f.default is MISSING and f.default_factory is MISSING]
    if needed == ["sample_time"]:
        return model.Parameters(0.01)
    vehicle = next(load(name) for name in shipped() if all(each in load(name) for each in needed))
    return vehicle.parameters_for(model.Parameters)


def equations(model):
    return model.derivative if hasattr(model, "derivative") else model.transition


def test_it_is_a_model_whose_signals_have_units(model):
    assert hasattr(model, "derivative") != hasattr(model, "transition")
    for part in (model.State, model.Input, model.Output):
        assert len(units(part)) == len(part._fields)
        assert inspect.getdoc(part)


def test_shapes_fit_and_nothing_is_remembered(model):
    state, inputs, parameters = trees(model)
    first = equations(model)(state, inputs, parameters)
    assert type(first) is model.State
    assert type(model.output(state, inputs, parameters)) is model.Output
    assert equations(model)(state, inputs, parameters) == first
    assert np.isfinite([value for _, value in leaves(first)]).all()


def test_its_jacobian_agrees_with_small_steps(model):
    state, inputs, parameters = trees(model)
    exact = np.array(jacobian(lambda at: equations(model)(at, inputs, parameters), state))
    centre = np.array([value for _, value in leaves(state)])
    for column in range(len(centre)):
        step = np.zeros_like(centre)
        step[column] = 1e-6
        ahead, behind = (
            np.array(equations(model)(rebuild(state, (centre + sign * step).tolist()), inputs, parameters))
            for sign in (1.0, -1.0)
        )
        rounding = 8.0 * np.finfo(float).eps * np.abs(ahead).max() / 2e-6  # of stiff models, whose rates are large
        np.testing.assert_allclose(exact[:, column], (ahead - behind) / 2e-6, rtol=1e-5, atol=1e-6 + rounding)
