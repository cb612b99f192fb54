"""Position control of the column: controller design, control blocks, stability margins and references."""
