"""The filter of the nominal demonstrator, as a calibration would find it."""

from dataclasses import replace
from functools import lru_cache

from tierod.monitors.condition.signals import ConditionSample
from tierod.monitors.condition.vehicle_filter import LeaveOutFilter
from tierod.vehicles import load
from tierod_lab.papers.condition.drives import vehicle


@lru_cache(maxsize=1)
def nominal_filter():
    """It assumes no fault; the file's values are those of the nominal demonstrator, offsets its sensors'."""
    car, sensors = load("smartload"), vehicle(0).sensors
    known = {name: replace(each, standard_deviation=0.0) for name, each in car.parameters.items()}
    for name in ConditionSample._fields[:8]:
        if f"{name}_offset" in known:
            known[f"{name}_offset"] = replace(known[f"{name}_offset"], value=sensors[name].bias)
    return LeaveOutFilter.of_vehicle(replace(car, parameters=known))
