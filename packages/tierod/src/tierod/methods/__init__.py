"""Methods that are independent of any vehicle: estimators, detectors, filters, identification, analysis."""
