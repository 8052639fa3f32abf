"""Kinds of fault, a function each; every module in this folder is read."""
