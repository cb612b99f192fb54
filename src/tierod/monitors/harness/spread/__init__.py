"""What the spread of a vehicle's parameters does to the result of a monitor: band, verdict, and what decides."""
