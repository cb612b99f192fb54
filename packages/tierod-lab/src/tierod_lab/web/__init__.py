"""What the page of tierod shows of the virtual vehicle: scenarios to drive, and the fleet of the demo."""

from tierod_lab.web.demo import demo_fleet
from tierod_lab.web.scenarios import catalogue, drive, scenario_text

__all__ = ["catalogue", "demo_fleet", "drive", "scenario_text"]
