"""Equations of motion from a model file, and what a measured log says about them.

    import dynamics

    found = dynamics.trace("arm.model", "log.csv")
    print(found)
"""

from dynamics._logs import Frame, Log, Logs
from dynamics._native import Derivatives, Error, Model, Simulation, SolveError
from dynamics._results import Estimate, Finding, Fit, Result, Rival, Term, Trace
from dynamics._trace import fit, trace

__all__ = [
    "Derivatives",
    "Error",
    "Estimate",
    "Finding",
    "Fit",
    "Frame",
    "Log",
    "Logs",
    "Model",
    "Result",
    "Rival",
    "Simulation",
    "SolveError",
    "Term",
    "Trace",
    "fit",
    "trace",
]
