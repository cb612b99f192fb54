import numpy as np
import pytest

from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod.core.graph import scan
from tierod.core.graph.analysis import operation_count
from tierod_lab.papers.motor_angle.bare_observers import BareFeedforward, BareLuenberger, BareReduced
from tierod_lab.papers.motor_angle.table_one import PRINTED, bare_observers, items, observers
from tierod_lab.studies.effort import Effort


def test_every_printed_row_is_counted():
    found = list(items(Effort(quick=True)))
    table = next(item for item in found if isinstance(item, Table))
    assert {row[0] for row in table.rows} == set(observers()) >= set(PRINTED)
    luenberger = table.rows[0]
    assert luenberger[1].startswith("19 / ")
    assert luenberger[6].startswith("3 / ")
    claims = {item.id: item for item in found if isinstance(item, Claim)}
    assert {name for name, each in claims.items() if not each.met} == {"motor-angle.table-one.feedforward"}


def test_two_transforms_cost_four_trigonometric_functions_and_a_load_costs_more():
    counted = {name: operation_count(observer) for name, observer in observers().items()}
    for name in ("Luenberger", "reduced Luenberger", "Kalman filter"):
        assert counted[name].trigonometric == 4
        assert counted[f"{name}, with load"].multiplications > counted[name].multiplications


def test_the_bare_equations_cost_what_the_paper_prints():
    """Table 1: 19 with 3 integrators, 24 with 2, 7 with 2."""
    counted = {name: operation_count(block) for name, block in bare_observers().items()}
    full, reduced, forward = (counted[name] for name in ("Luenberger", "reduced Luenberger", "feedforward"))
    assert (full.multiplications + full.divisions, full.states) == (19, 3)
    assert reduced.multiplications + reduced.divisions in (23, 24, 25)
    assert (forward.multiplications + forward.divisions, reduced.states, forward.states) == (7, 2, 2)


def test_bare_observers_follow_a_turning_motor():
    """A motor at constant speed in closed form: the equations that are counted are the right ones."""
    resistance, inductance, constant, torque, inertia, damping = 0.05, 1e-4, 0.034, 0.051, 1.2e-4, 4e-4
    speed, time = 60.0, 1e-4 * np.arange(6000)
    angle, quadrature = speed * time, damping * speed / torque
    turned = np.exp(4j * angle)
    current = 1j * quadrature * turned
    voltage = (resistance + 4j * speed * inductance) * current + 1j * constant * speed * turned
    seen = np.column_stack([voltage.real, voltage.imag, current.real, current.imag, angle])
    full = scan(BareLuenberger(), seen)
    assert full["motor_speed"][-1] == pytest.approx(speed, rel=0.01)
    gain = (-300.0 + damping / inertia) * inductance / constant
    known = [gain, resistance, inductance, constant, torque, inertia, damping]
    reduced = scan(BareReduced(), np.column_stack([seen, np.tile(known, (len(seen), 1))]))
    assert reduced["motor_speed"][-1] == pytest.approx(speed, rel=0.01)
    found = scan(BareFeedforward(), seen)["electrical_angle"]
    away = np.angle(np.exp(2j * (found - 4.0 * angle)))[1000:] / 2.0  # half turns are left open
    assert np.abs(away).max() < 0.05
