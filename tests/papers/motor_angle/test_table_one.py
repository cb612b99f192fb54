from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod.core.graph.operation_count import operation_count
from tierod.experiments.effort import Effort
from tierod.papers.motor_angle.table_one import PRINTED, items, observers


def test_every_printed_row_is_counted():
    found = list(items(Effort(quick=True)))
    table = next(item for item in found if isinstance(item, Table))
    assert {row[0] for row in table.rows} == set(observers()) >= set(PRINTED)
    luenberger = table.rows[0]
    assert luenberger[1].startswith("19 / ")
    assert luenberger[6].startswith("3 / ")
    assert all(item.met for item in found if isinstance(item, Claim))


def test_two_transforms_cost_four_trigonometric_functions_and_a_load_costs_more():
    counted = {name: operation_count(observer) for name, observer in observers().items()}
    for name in ("Luenberger", "reduced Luenberger", "Kalman filter"):
        assert counted[name].trigonometric == 4
        assert counted[f"{name}, with load"].multiplications > counted[name].multiplications
