"""The rules of Li, Frey and Gauterin (residuals, thresholds, symptoms) as variants of the condition monitor."""
