"""CMA-ES on the gains of a drive: from those of the formulas to better ones, if there are any."""
