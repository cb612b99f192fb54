"""The study of the motor angle: accuracy of its observers, and detection of faults of its sensor."""
