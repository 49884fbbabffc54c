"""Why the native part of the package cannot be imported."""

from __future__ import annotations

import importlib.machinery
import pathlib
import platform
import re
import sys


def sentence(folder: pathlib.Path) -> str | None:
    """None: the native part is there for this Python, and its own error says more."""
    files = [file.name for file in folder.glob("_hecaton.*") if file.suffix == ".so"]
    if any("_hecaton" + suffix in files for suffix in importlib.machinery.EXTENSION_SUFFIXES):
        return None
    tags = [re.match(r"_hecaton\.cpython-(\d)(\d+)-", name) for name in files]
    built = [f"{tag[1]}.{tag[2]}" for tag in tags if tag]
    this = f"{platform.python_implementation()} {platform.python_version()}"
    if not built:
        return f"the native part of hecaton is missing in {folder}: install python3-hecaton, or build the target hecaton_python"
    return (f"hecaton is built for CPython {' and '.join(built)}, but {sys.executable} is {this}: "
            f"run the program with python{built[0]}")
