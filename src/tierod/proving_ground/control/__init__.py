"""Controllers of the virtual cars: drivers, and control units at the step of the car."""
