"""Sideslip of the vehicle from what it measures: two observers after Yih, Ryu and Gerdes, and tierod's own."""
