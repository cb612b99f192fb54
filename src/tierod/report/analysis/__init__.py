"""What `tierod analyse` shows: a file per subject, and the page."""
