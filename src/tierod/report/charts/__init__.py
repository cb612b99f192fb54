"""The charts of the page, each a plain description that plotly draws."""
