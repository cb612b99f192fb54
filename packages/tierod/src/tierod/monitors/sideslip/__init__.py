"""Sideslip of the vehicle from its measurements: two observers after Yih, Ryu and Gerdes, and a combined filter."""
