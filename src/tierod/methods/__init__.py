"""Methods that know no car: estimators, detectors, filters, identification, analysis."""
