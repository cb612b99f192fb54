"""Studies: what papers and tierod claim, measured claim by claim."""
