"""The rules of Li, Frey and Gauterin: residuals, thresholds and symptoms, as variants of the condition monitor."""
