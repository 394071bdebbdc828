"""Tables that users write: rows of CSV and Parquet files, checked cell by cell."""
