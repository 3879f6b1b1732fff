/* Stands in for the system header while declarations are extracted; see binding.py. */
