"""What kind of fault a sensor has, and how large it is."""
