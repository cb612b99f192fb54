"""What becomes of findings: trouble codes, the memory of faults, and what a workshop reads from it."""
