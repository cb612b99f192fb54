"""Sideslip of the vehicle from its measurements: two observers after Yih, Ryu and Gerdes, and tierod's own."""
