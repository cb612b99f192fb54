"""Effect of uncertain vehicle parameters on a monitor's result: band, verdict, and the parameters that decide."""
