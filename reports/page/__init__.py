"""The report page of saved runs: figures, player, templates."""
