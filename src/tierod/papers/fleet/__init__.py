"""What a fleet shows that one car does not: the errors of a monitor, ramps over months, and cohorts."""
