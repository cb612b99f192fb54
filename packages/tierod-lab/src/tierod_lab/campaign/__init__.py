"""Campaigns: matrices of simulated drives that monitors judge, which can be resumed and compared."""
