"""Rockwell's own files: controllers of Studio 5000 (L5X) and RSLogix 500 (SLC) to programs, and back.

It knows the ladder and the images; how a rack is made of an export is `front/jobs/imports`.
"""
