"""Figures of a run; matplotlib is imported when one is drawn."""

from .plot import FIGURES, write_figures

__all__ = ["FIGURES", "write_figures"]
