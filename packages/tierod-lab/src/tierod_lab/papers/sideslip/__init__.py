"""The study of sideslip: the paper of Yih, Ryu and Gerdes claim by claim, and the combined estimator beside it."""
