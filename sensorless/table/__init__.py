"""The k_s table: axes, values, file format and C image."""
