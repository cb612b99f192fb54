"""What healthy drives tell: parameters of the vehicle, and limits between hypotheses."""
