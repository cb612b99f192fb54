"""Classification of a sensor's fault: kind and magnitude."""
