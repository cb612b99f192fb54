"""Charts of the page, each described as plain data that plotly draws."""
