"""Recordings on their way in: campaign file, foreign formats, data quality, segments and roles."""
