"""The cache of rendered footage in the user's cache folder."""
