"""The friction monitor and its variants.

From `tierod diagnose` to the verdict in eight files:

1. `cli/diagnose.py` reads the options.
2. `monitors/diagnose.py` finds the monitor and feeds it piece by piece.
3. `monitors/harness/run.py` puts every piece on one grid, without stuck signals, and makes the report.
4. `monitors/friction/definition.py`, this file, opens a variant for a vehicle.
5. `monitors/friction/monitor.py`: the block, which is estimator and verdict, and the session that collects.
6. `monitors/friction/presliding.py` estimates friction; the filters of the paper are variants in tierod-lab.
7. `monitors/friction/verdict.py` states what that means: status, since when, why none, and the figures behind it.
8. `monitors/friction/finding.py` puts the last statement into words.
"""

from __future__ import annotations

from collections.abc import Callable

from tierod.monitors.friction.decisions import DECISIONS, TUNING
from tierod.monitors.friction.monitor import FrictionMonitor, FrictionSession, acting_by_build_up
from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.session import Monitor, Session, Variant
from tierod.monitors.registry import variants_with_plugins
from tierod.vehicles import Vehicle

PAPER = "Mohtat et al., Steering friction monitoring by joint state-parameter estimation"

Opener = Callable[[Vehicle, float, Baseline | None], Session]

_WIDE = (
    "This estimator allows for errors of its torque balance that last half a second, and so expects a large variance: "
    "a mean NIS far below 1 is normal. A NIS near or above 1 means that the balance does not fit the car."
)


def _presliding(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
    block = FrictionMonitor.of_vehicle(vehicle, 1.0 / rate, *learnt(baseline))
    return FrictionSession(block, vehicle, rate, acting_by_build_up, _WIDE)


def learnt(baseline: Baseline | None) -> tuple[float | None, float]:
    """Level and standard deviation of the baseline from earlier recordings [N*m]."""
    return (baseline.value, baseline.deviation) if baseline else (None, 0.0)


PRE_SLIDING = Variant(
    "pre-sliding",
    "Regression that also learns the angle over which friction builds up, so that pre-sliding causes no bias.",
    f"beyond {PAPER}; docs/explanation/friction.md",
    _presliding,
    DECISIONS,
)

FRICTION = Monitor(
    name="friction",
    title="Friction of the steering",
    subject="Friction",
    summary="Detects and quantifies rising dry friction of column, gear and rack in natural driving.",
    source=PAPER,
    drive=f"Bends to both sides, steered by hand on city or country roads: {TUNING.ready_time:g} s in which driver and "
    "motor turn the wheel together, some three minutes of mixed driving; a baseline needs some six minutes.",
    required=(
        "steering_wheel_angle",
        "steering_wheel_rate",
        "driver_torque",
        "motor_torque",
        "yaw_rate",
        "lateral_acceleration",
        "vehicle_speed",
    ),
    optional=(),
    rate=100.0,
    minimum_rate=20.0,
    maximum_age=0.1,
    variants=variants_with_plugins("friction", {"pre-sliding": "tierod.monitors.friction.definition:PRE_SLIDING"}),
    default="pre-sliding",
    learns=True,
    # After a step of friction the torque balance does not fit for up to 57 s (verdict_tuning).
    reaction=60.0,
)
