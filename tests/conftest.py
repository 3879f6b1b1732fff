"""Settings that hold for all tests; they act before any library is imported."""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # two threads of torch on a busy machine are slower
os.environ.setdefault("MPLBACKEND", "Agg")  # figures without a screen
