"""Observer design: from physical bandwidths to the gains that the core runs with."""
