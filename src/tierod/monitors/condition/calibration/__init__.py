"""Calibration from fault-free drives: parameters of the vehicle, and limits between hypotheses."""
