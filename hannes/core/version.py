"""The version of hannes: kept here, where every package may read it."""

VERSION = "0.1.0"
