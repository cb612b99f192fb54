"""Quantities that are estimated drive by drive: how they move over months, and how cars and cohorts differ."""
