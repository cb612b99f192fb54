"""The study of condition monitoring of a whole vehicle: drives of the demonstrator, their scoring, and all parts."""
