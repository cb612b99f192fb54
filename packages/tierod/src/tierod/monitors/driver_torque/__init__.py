"""Torque of the driver's hands from the steering column: observers, detection of hands, and the monitor."""
