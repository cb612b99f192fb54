"""Virtual cars, composed of chassis, steering, driver and control units."""
