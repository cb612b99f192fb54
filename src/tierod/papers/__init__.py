"""The five papers, each with its printed variants, its claims and its figures, and the study of fleets; the product
never imports them."""
