"""Sensors of the virtual cars: rate, noise, drift, resolution, range, delay, jitter and loss of every channel."""

from tierod_lab.ground.sensors.sensor import PRESETS, Sensor, SensorSet

__all__ = ["PRESETS", "Sensor", "SensorSet"]
