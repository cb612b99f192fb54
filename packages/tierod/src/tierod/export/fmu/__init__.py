"""Functional mock-up units for co-simulation, FMI 2.0: monitors, plants and controllers."""
