"""The virtual vehicle and the evidence of tierod: simulation, faults, campaigns, and the claims of the papers."""
