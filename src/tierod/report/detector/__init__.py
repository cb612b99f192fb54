"""What the design of a detector looks like."""
