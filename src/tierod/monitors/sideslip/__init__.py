"""Sideslip: the observers of Yih, Ryu and Gerdes and the combined estimator that goes beyond them."""
