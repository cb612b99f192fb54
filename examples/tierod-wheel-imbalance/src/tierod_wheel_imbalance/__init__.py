"""A monitor of wheel imbalance, a reader and a writer of WIM files, a vehicle, a fault and a scenario."""
