"""The study of foreign plants: monitors on simulations that others wrote or that share no code with tierod."""
