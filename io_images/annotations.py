"""Reads annotations in a user's code; Python 3.14 and later evaluate them when they are read [PEP 649].

A name that exists only for type checkers is not an error.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping
from typing import Any

if sys.version_info >= (3, 14):
    from annotationlib import Format, call_annotate_function, get_annotate_from_class_namespace


def declared(namespace: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the annotations in the body of a class or a module.

    Args:
        namespace: `vars()` of the class or the module.
    """
    declared_types: Mapping[str, Any] | None = namespace.get("__annotations__")
    if declared_types is None and sys.version_info >= (3, 14):
        annotate = get_annotate_from_class_namespace(namespace)
        declared_types = call_annotate_function(annotate, Format.FORWARDREF) if annotate else None
    return declared_types or {}


def signature_of(function: Callable[..., Any]) -> inspect.Signature:
    """Return the signature of a function; raise the same errors as `inspect.signature`."""
    if sys.version_info >= (3, 14):
        return inspect.signature(function, annotation_format=Format.FORWARDREF)
    return inspect.signature(function)
