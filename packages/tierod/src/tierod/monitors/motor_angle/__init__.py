"""The angle of a motor from its currents and voltages, compared with its angle sensor."""
