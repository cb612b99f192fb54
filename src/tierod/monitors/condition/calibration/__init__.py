"""From healthy drives: parameters of the vehicle, and limits between hypotheses."""
