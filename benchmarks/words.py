"""What a benchmark takes on its command line: ``--help``, and a few numbers or words."""

import argparse


def parser(doc: str | None) -> argparse.ArgumentParser:
    """Parser whose help is the text at the top of a script."""
    return argparse.ArgumentParser(
        description=doc, formatter_class=argparse.RawDescriptionHelpFormatter
    )
