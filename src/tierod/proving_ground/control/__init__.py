"""Control units of the virtual cars, each at the step of the car."""
