"""The study of the steering column: analysis, identification, driver torque, hands and position control."""
