"""From a folder of unknown logs to a mapping and a campaign, to be edited."""
