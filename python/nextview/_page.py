"""The page of a scan in a notebook."""

from __future__ import annotations

import html
from dataclasses import dataclass


@dataclass(frozen=True)
class Page:
    """The report of a scan, with its 3D view: a cell of a notebook that ends with it shows it."""

    html: str
    """One HTML document that needs no network."""
    height_px: int = 720
    """Height of the cell's picture, pixels."""

    def _repr_html_(self) -> str:
        # A document within a document keeps its styles and its script to itself.
        source = html.escape(self.html, quote=True)
        style = f"width: 100%; height: {self.height_px:d}px; border: 0"
        return f'<iframe srcdoc="{source}" style="{style}"></iframe>'

    def __repr__(self) -> str:
        """Its size."""
        return f"Page({len(self.html)} characters of HTML)"
