"""Evidence from a fleet that one car does not give: the errors of a monitor, ramps over months, and cohorts."""
