"""Search for failures: first points, evolution, and what makes two failures different."""
