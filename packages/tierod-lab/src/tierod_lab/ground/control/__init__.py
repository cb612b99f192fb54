"""Controllers of the virtual cars: drivers, and control units sampled at the step of the car."""
