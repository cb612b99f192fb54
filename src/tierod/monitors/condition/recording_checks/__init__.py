"""What is wrong with a recording and no fault of any sensor: wiring, scale, time, gaps."""
