import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.measured import threshold_from_records
from tierod.methods.detectors.stopping_rules import CusumRule, ExcessRule


def test_the_level_is_the_drift_of_a_cumulative_sum():
    rule = ExcessRule(5.0, sides="upper")
    assert rule.run_length(0.5) == CusumRule(0.5, sides="upper").run_length(5.0)
    assert rule.block(0.5, 2.0) == Cusum(1.0, 10.0, 20.0, "upper")
    assert rule.run_length(rule.threshold_for(1e5)) == pytest.approx(1e5, rel=1e-6)


def test_it_alarms_when_the_excess_has_come_together():
    block = ExcessRule(5.0, sides="upper").block(2.0, 1.0)
    assert np.argmax(scan(block, np.full(50, 2.4))["alarm"]) == 12  # 13 values of 0.4
    assert not scan(block, np.full(5000, 1.9))["alarm"].any()


def test_its_level_is_measured_on_residuals_that_remember():
    random = np.random.default_rng(5)
    steps = random.normal(size=100_000) * np.sqrt(1.0 - 0.98**2)
    wander = np.empty_like(steps)
    wander[0] = steps[0]
    for k in range(1, len(steps)):
        wander[k] = 0.98 * wander[k - 1] + steps[k]
    rule = ExcessRule(10.0, sides="upper")
    found = threshold_from_records(rule, [wander[:50_000]], 2000.0)
    alarms = scan(rule.block(found.threshold, found.deviation, restart=True), wander[50_000:])["alarm"].sum()
    assert 50_000 / alarms == pytest.approx(2000.0, rel=0.6)
    assert found.threshold > rule.threshold_for(2000.0)


def test_an_excess_of_nothing_is_refused():
    with pytest.raises(ParameterError, match="greater than zero"):
        ExcessRule(0.0)
