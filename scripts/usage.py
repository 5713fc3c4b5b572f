"""argparse with the exit codes of our programs: 1 for a wrong command line, where argparse has 2, our "cannot read or
write"."""
import argparse
import sys


class ArgumentParser(argparse.ArgumentParser):
    def __init__(self, description):
        super().__init__(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)

    def error(self, message):
        self.print_usage(sys.stderr)
        self.exit(1, f"{self.prog}: {message}\n")
