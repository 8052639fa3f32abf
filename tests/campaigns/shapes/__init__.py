"""File shapes as labs write them, a function each; every module in this folder is read."""
