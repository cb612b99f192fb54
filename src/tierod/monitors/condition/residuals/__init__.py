"""The residuals of Li, Frey and Gauterin: of sensors and of actuators, their calibration and their symptoms."""
