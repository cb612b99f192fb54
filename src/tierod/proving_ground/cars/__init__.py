"""Virtual cars: chassis, steering, driver and control units put together."""
