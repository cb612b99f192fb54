"""Trends of quantities that are estimated once per drive: changes over months, differences between cars and cohorts."""
