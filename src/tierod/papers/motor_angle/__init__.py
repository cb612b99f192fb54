"""The angle of a steering motor and its sensor: what observers and their detectors attain."""
