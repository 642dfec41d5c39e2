"""A few lines over xml.etree: attributes as keywords, numbers written without loss."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np


def element(parent: ET.Element | None, tag: str, **attributes) -> ET.Element:
    """Append a child. None is left out, numbers and sequences are written in full, a trailing `_` guards Python keywords."""
    text = {key.rstrip("_"): _text(value) for key, value in attributes.items() if value is not None}
    return ET.Element(tag, text) if parent is None else ET.SubElement(parent, tag, text)


def document(root: ET.Element) -> str:
    """The tree as indented XML."""
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _text(value) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return str(value).lower()
    return " ".join(repr(v) for v in np.atleast_1d(value).tolist())
