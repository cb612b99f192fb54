"""Faults as data, separate from vehicle and scenario: element, behaviour, trigger and duration."""

from tierod_lab.ground.faults.behaviours import (
    BEHAVIOURS,
    Course,
    Intermittent,
    Ramp,
    Scale,
    Sluggish,
    Step,
    TorqueLoss,
    WithTemperature,
)
from tierod_lab.ground.faults.fault import Effect, Fault
from tierod_lab.ground.faults.injection import injected
from tierod_lab.ground.faults.reading import FAULTS, FaultFile, fault_of, load, shipped
from tierod_lab.ground.faults.schedule import Schedule
from tierod_lab.ground.faults.signals import (
    BitFlip,
    Delay,
    Drift,
    DropOut,
    Gain,
    Noise,
    Offset,
    Outlier,
    Spikes,
    Stuck,
    TotalLoss,
)
from tierod_lab.ground.faults.triggers import Always, AtDistance, AtTime, When, Within, trigger_of

__all__ = [
    "BEHAVIOURS",
    "FAULTS",
    "Always",
    "AtDistance",
    "AtTime",
    "BitFlip",
    "Course",
    "Delay",
    "Drift",
    "DropOut",
    "Effect",
    "Fault",
    "FaultFile",
    "Gain",
    "Intermittent",
    "Noise",
    "Offset",
    "Outlier",
    "Ramp",
    "Scale",
    "Schedule",
    "Sluggish",
    "Spikes",
    "Step",
    "Stuck",
    "TorqueLoss",
    "TotalLoss",
    "When",
    "WithTemperature",
    "Within",
    "fault_of",
    "injected",
    "load",
    "shipped",
    "trigger_of",
]
