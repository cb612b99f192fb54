"""Virtual fleets: years of many cars, drawn at the level of estimates or driven by the virtual car."""
