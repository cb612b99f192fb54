"""Position control of the column: design of the control, its block and references."""
