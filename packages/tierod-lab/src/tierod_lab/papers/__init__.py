"""The five papers, each with its printed variants, its claims and its figures, and the studies of own cars, foreign
plants and fleets; the product never imports this package."""
