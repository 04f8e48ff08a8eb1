"""Traces logs: `python trace_a_log.py MODEL LOG [TEST]`."""

import sys

import dynamics

model, log, *test = sys.argv[1:]
found = dynamics.trace(model, log, test=test or None)
print(found)
print(found.diff)
