"""Condition monitor: faults of all sensors and actuators of a vehicle, judged together."""
