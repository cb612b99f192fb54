"""The study of steering friction: the paper of Mohtat et al. claim by claim, and tierod's own estimator beside it."""
