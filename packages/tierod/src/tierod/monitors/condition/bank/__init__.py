"""Bank of filters: one filter per fault hypothesis, and the decision between the hypotheses."""
