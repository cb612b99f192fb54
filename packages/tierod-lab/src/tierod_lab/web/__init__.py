"""Pages of virtual drives: what the page of tierod shows of the virtual vehicle."""
