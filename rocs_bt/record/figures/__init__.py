"""Figures of a run; matplotlib is imported only when a figure is drawn."""

from .plot import FIGURES, write_figures

__all__ = ["FIGURES", "write_figures"]
