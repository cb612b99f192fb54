"""The study of fleets: the errors of a monitor, changes over months, and cohorts that differ."""
