import numpy as np
import pytest

from tierod.core.graph import scan
from tierod.core.graph.analysis import operation_count
from tierod_lab.papers.motor_angle.bare_observers import BareFeedforward, BareLuenberger, BareReduced


@pytest.mark.parametrize(
    ("block", "products", "states"),
    [(BareLuenberger(), (19,), 3), (BareReduced(), (24, 25), 2), (BareFeedforward(), (7,), 2)],
)
def test_the_bare_equations_cost_what_table_1_prints(block, products, states):
    count = operation_count(block)
    assert count.multiplications + count.divisions in products
    assert count.states == states


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
