"""Scenarios: files that define car, course, duration, sensors and faults of a run.

outcome = load("country-friction-step").run()
"""

from tierod_lab.ground.scenarios.reader import SCENARIOS, from_document, load, shipped, simulate
from tierod_lab.ground.scenarios.scenario import Scenario

__all__ = ["SCENARIOS", "Scenario", "from_document", "load", "shipped", "simulate"]
