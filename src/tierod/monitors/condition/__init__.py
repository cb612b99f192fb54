"""Condition of the sensors and actuators of a whole vehicle, judged together."""
