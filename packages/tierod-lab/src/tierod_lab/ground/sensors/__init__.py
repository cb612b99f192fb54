"""Sensors of the virtual cars: rate, noise, drift, resolution, range, delay, jitter and loss of every channel."""

from tierod_lab.ground.sensors.sensor import Sensor
from tierod_lab.ground.sensors.sensor_set import PRESETS, SensorSet

__all__ = ["PRESETS", "Sensor", "SensorSet"]
