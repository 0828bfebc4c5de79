"""An L5X as a document: records of its elements, within limits."""
