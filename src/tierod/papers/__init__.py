"""The five papers, each with its printed variants, its claims and its figures; the product never imports them."""
