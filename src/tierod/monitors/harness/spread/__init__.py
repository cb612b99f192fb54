"""Effect of the spread of a vehicle's parameters on a monitor's result: band, verdict, and deciding parameters."""
