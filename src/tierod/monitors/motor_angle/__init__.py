"""The angle of a motor from its currents and voltages, beside the sensor that is watched."""
